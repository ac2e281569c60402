"""Exported C is the controller: it passes its own test vector, and flies the same flight."""

import ctypes
import dataclasses
import functools
import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import skylimb
from skylimb.base.errors import ConfigError, OutputError
from skylimb.control.cascade import Cascade
from skylimb.control.estimation.records import Measurement
from skylimb.control.laws.traced_step import TracedStep
from skylimb.control.laws.user_trace import shaken_hover
from skylimb.control.missions.reference import Reference
from skylimb.control.needs import Needs, needs_of
from skylimb.control.records import Command
from skylimb.control.supervisor.limits import Limits
from skylimb.flight.export import export_c
from skylimb.flight.export.step import controller_step
from skylimb.flight.flying import fly_here
from skylimb.flight.takeoff import Takeoff
from strict_c import StrictC

SOURCES = ("controller.c", "controller_function.c")


def cascade(name: str) -> Cascade:
    controller = skylimb.load_controller(name, skylimb.load_robot("hydrus_xi_quad"))
    assert isinstance(controller, Cascade)
    return controller


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Path]:
    """The folder of a preset's C, which is exported once and then only looked at."""

    @functools.cache
    def made(name: str, losses: bool = False) -> Path:
        folder = tmp_path_factory.mktemp(name) / "export"
        files = export_c(cascade(name), folder, limits=Limits(losses=losses))
        assert {path.name for path in files} == {path.name for path in folder.iterdir()}
        return folder

    return made


@pytest.mark.parametrize(
    ("name", "losses"),
    [
        *((name, False) for name in ("pid", "impedance", "admittance", "hybrid", "following")),
        ("following", True),
    ],
)
def test_the_example_passes_its_test_vector(
    name: str, losses: bool, exported: Callable[..., Path], tmp_path: Path, strict_c: StrictC
) -> None:
    folder = exported(name, losses)
    strict_c.link([folder / source for source in ("main.c", *SOURCES)], tmp_path / "example")
    done = subprocess.run([tmp_path / "example"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    assert "60 ticks" in done.stdout
    assert len((folder / "main.c").read_text().splitlines()) <= 30


def test_the_header_says_of_every_gain_what_it_is(exported: Callable[..., Path]) -> None:
    folder = exported("following")
    lines = [line for line in (folder / "controller.h").read_text().splitlines() if "_GAINS_" in line]
    (force,) = [line for line in lines if line.startswith("#define SKYLIMB_GAINS_TRANSLATION_FORCE ")]
    assert force.endswith("/* 1 number: N_ref, the wanted force; N; 0 .. 20 */")
    assert not [line for line in lines[1:] if line.startswith("#define") and ": " not in line]


def test_the_header_says_of_every_signal_what_it_is(exported: Callable[..., Path]) -> None:
    lines = (exported("following") / "controller.h").read_text().splitlines()
    signals = [line for line in lines if line.startswith("#define SKYLIMB_SIGNALS_")][1:]
    assert len(signals) > 30
    assert not [line for line in signals if ": " not in line]
    (torque,) = [line for line in signals if "_TORQUE_COMMAND " in line]
    assert torque.endswith("/* 3 numbers: wanted torque; N m; C */")


def test_the_header_says_which_rotor_and_joint_is_which_and_when_the_supervisor_acts(tmp_path: Path) -> None:
    robot = skylimb.load_robot("hydrus_xi_quad")
    export_c(cascade("hybrid"), tmp_path / "c", limits=Limits(cut_after=0.7))
    text = (tmp_path / "c" / "controller.h").read_text()
    assert "COMMAND_THRUSTS 0 /* 4 numbers: N; of rotor1, rotor2, rotor3, rotor4 */\n" in text
    for part in ("MEASUREMENT", "REFERENCE", "COMMAND"):
        for name, joints in (("JOINT", "shape_joints"), ("VECTORING", "vectoring_joints")):
            (line,) = [one for one in text.splitlines() if f"_{part}_{name}_ANGLES " in one]
            assert line.endswith(f"of {', '.join(getattr(robot.description, joints))} */")
    assert f"The measured link is '{robot.description.measured_link}'." in text
    assert "\n *   cut_after = 0.7: without one, after which" in text
    named = set(re.findall(r"`(\w+)`", text[text.index("#define SKYLIMB_BIT_STOP") :])) - {"signals"}
    assert "cut_after" in named
    assert not [name for name in named if f"\n *   {name} = " not in text]


def test_the_header_takes_any_name(tmp_path: Path, strict_c: StrictC) -> None:
    """JSON's way to write what lies beyond 16 bits is none of C."""
    preset = Path(skylimb.__file__).parent / "control/presets/pid.toml"
    mine = Path(shutil.copy(preset, tmp_path / "mine \N{HELICOPTER} \N{OCTOPUS}.toml"))
    controller = skylimb.load_controller(str(mine), skylimb.load_robot("hydrus_xi_quad"))
    export_c(controller, tmp_path / "c")
    says = '#include <stdio.h>\n#include "controller.h"\n'
    (tmp_path / "c" / "says.c").write_text(
        f"{says}int main(void) {{ puts(SKYLIMB_CONTROLLER); return 0; }}\n"
    )
    strict_c.link([tmp_path / "c" / "says.c"], tmp_path / "says")
    said = subprocess.run([tmp_path / "says"], capture_output=True, text=True, check=True, encoding="utf-8")
    assert said.stdout == f"{controller.name}\n"


@pytest.mark.parametrize("spoilt", [np.nan, np.inf, -np.inf])
def test_a_pace_that_was_spoilt_is_a_number_at_the_next_tick(spoilt: float) -> None:
    """Whoever moves a mission's clock by it would never have a time again."""
    step = controller_step(cascade("following"), 0.005)
    layout, state = step.inputs.state, step.state.copy()
    state[layout.slices["pace"]] = spoilt
    state[layout.slices["watch.flags.late"]] = 1.0  # the controller is not asked, so that the old pace stays
    needs = Needs(vectoring="contact")
    given = shaken_hover(skylimb.load_robot("hydrus_xi_quad"), np.random.default_rng(0), needs)
    packed = step.inputs.measurement.pack(given[0]), step.inputs.reference.pack(given[1])
    _, _, signals = step.function(state, *packed, step.gains)
    found = step.signals.unpack(np.asarray(signals).ravel())["pace"]
    assert 0.0 <= float(found) <= 100.0


def test_a_header_and_a_source_of_two_exports_do_not_compile(tmp_path: Path) -> None:
    """Where all sizes agree, nothing else would tell."""
    for name in ("pid", "pid again"):
        limits = Limits() if name == "pid" else Limits(hold_for=0.06)
        export_c(cascade("pid"), tmp_path / name, limits=limits)
    one, other = tmp_path / "pid", tmp_path / "pid again"
    header = (one / "controller.h").read_text()
    assert '#define SKYLIMB_ROBOT "hydrus_xi_quad"\n#define SKYLIMB_CONTROLLER "pid"\n' in header
    whole = [shutil.which("cc") or "cc", "-std=c99", "-fsyntax-only", "controller.c"]
    assert subprocess.run(whole, cwd=one, capture_output=True, check=False).returncode == 0
    (one / "controller.h").write_text((other / "controller.h").read_text())
    done = subprocess.run(whole, cwd=one, capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert "controller.h is of another export than controller.c" in done.stderr


def test_the_example_notices_a_wrong_number(
    exported: Callable[..., Path], tmp_path: Path, strict_c: StrictC
) -> None:
    folder = shutil.copytree(exported("hybrid"), tmp_path / "export")
    text, first = (folder / "controller.c").read_text(), "preset_gains[SKYLIMB_GAINS_SIZE] = {"
    assert first in text
    (folder / "controller.c").write_text(text.replace(first, f"{first}1e-9 + "))
    strict_c.link([folder / source for source in ("main.c", *SOURCES)], tmp_path / "example")
    assert subprocess.run([tmp_path / "example"], capture_output=True, check=False).returncode == 1


@pytest.mark.skipif(shutil.which("nm") is None, reason="nm is not on this machine")
def test_it_needs_nothing_but_libm(exported: Callable[..., Path], strict_c: StrictC) -> None:
    folder = exported("hybrid")
    defined, wanted = set(), set()
    for source in SOURCES:
        made = strict_c.compiled(folder / source)
        listing = subprocess.run(["nm", made], capture_output=True, text=True, check=True).stdout
        symbols = [line.split()[-2:] for line in listing.splitlines()]
        defined |= {name for kind, name in symbols if kind in "TRD"}
        wanted |= {name for kind, name in symbols if kind == "U"}
    libm = {
        "acos",
        "asin",
        "atan",
        "atan2",
        "cos",
        "exp",
        "fabs",
        "fmax",
        "fmin",
        "log",
        "pow",
        "sin",
        "sqrt",
    }
    # A compiler may make a call of a loop that copies or clears; the table is what code of any place has.
    assert wanted - defined <= libm | {"tan", "tanh", "sincos", "memcpy", "memset", "_GLOBAL_OFFSET_TABLE_"}


class InC:
    """The exported code in the place of a user's own controller."""

    name = "exported"

    def __init__(self, library: ctypes.CDLL, step: TracedStep, needs: Needs) -> None:
        self._library, self._step, self.needs = library, step, needs

    def gains(self) -> Any:
        return None

    def initial_state(self) -> np.ndarray:
        return np.array(
            (ctypes.c_double * len(self._step.state)).in_dll(self._library, "skylimb_initial_state")
        )

    def step(
        self, gains: Any, state: np.ndarray, measurement: Measurement, reference: Reference, dt: float
    ) -> tuple[np.ndarray, Command, dict[str, Any]]:
        s, new = self._step, state.copy()
        told = np.array((ctypes.c_double * 5).in_dll(self._library, "skylimb_all_well"))
        given = [
            new,
            told,
            s.inputs.measurement.pack(measurement),
            s.inputs.reference.pack(reference),
            s.gains,
        ]
        command, signals = np.zeros(s.commands.size), np.zeros(s.signals.size)
        arrays = [*given, command, signals]
        self._library.skylimb_controller_step(*(ctypes.c_void_p(array.ctypes.data) for array in arrays))
        return new, s.commands.unpack(command), s.signals.unpack(signals)


@pytest.mark.parametrize("name", ["hybrid", "following"])
def test_exported_c_flies_the_same_flight(
    name: str,
    make_takeoff: Callable[..., Takeoff],
    exported: Callable[..., Path],
    tmp_path: Path,
    strict_c: StrictC,
) -> None:
    folder, takeoff = exported(name), make_takeoff("paper", name)
    controller = cascade(name)
    strict_c.link([folder / source for source in SOURCES], tmp_path / "controller.so", "-shared")
    flown = InC(
        ctypes.CDLL(str(tmp_path / "controller.so")), controller_step(controller, 0.005), needs_of(controller)
    )
    wanted = fly_here(takeoff)
    found = fly_here(dataclasses.replace(takeoff, controller=flown))
    assert (found.ticks, found.cause) == (wanted.ticks, wanted.cause)
    assert found.signal("contact_duty").max() > 0.0
    for signal in wanted.layout.slices:
        np.testing.assert_allclose(
            found.signal(signal), wanted.signal(signal), rtol=0.0, atol=1e-9, err_msg=signal
        )


def test_what_cannot_be_exported_is_refused(tmp_path: Path) -> None:
    class Own:
        name = "own"

    with pytest.raises(ConfigError, match="own"):
        export_c(Own(), tmp_path / "a")  # type: ignore[arg-type]
    with pytest.raises(ConfigError, match="-1"):
        export_c(cascade("pid"), tmp_path / "a", -1.0)
    (tmp_path / "b").mkdir()
    with pytest.raises(OutputError, match="exists"):
        export_c(cascade("pid"), tmp_path / "b")
    assert not (tmp_path / "a").exists()
    assert not any((tmp_path / "b").iterdir())
