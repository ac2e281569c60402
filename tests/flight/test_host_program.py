"""The host program in C: recorded measurements in, the recorded commands out."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import skylimb
from skylimb.analysis.report.output import write_records
from skylimb.apps.cli.main import main
from skylimb.base.errors import ConfigError
from skylimb.control.supervisor.limits import Limits
from skylimb.flight.export import export_c
from skylimb.flight.export.host import FLIGHT, export_with_flight, host_input
from skylimb.flight.flying import fly
from skylimb.flight.simulated_run import scored_run
from skylimb.flight.takeoff import Takeoff
from strict_c import STRICT, StrictC

SANITIZERS = ("-O0", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
SOURCES = ("host.c", "controller.c", "controller_function.c")
COMPILER = shutil.which("gcc") or shutil.which("clang")

needs_compiler = pytest.mark.skipif(COMPILER is None, reason="no gcc or clang on this machine")


def built(folder: Path) -> Path:
    """The program, which says where it goes wrong."""
    program = folder / "host"
    sources = (str(folder / name) for name in SOURCES)
    command = [str(COMPILER), *STRICT, *SANITIZERS, *sources, "-o", str(program), "-lm"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return program


def linked(folder: Path, strict_c: StrictC) -> Path:
    strict_c.link([folder / name for name in SOURCES], folder / "host")
    return folder / "host"


@needs_compiler
@pytest.mark.parametrize(("name", "sanitized"), [("hybrid", True), ("following", False)])
def test_it_commands_what_was_recorded(
    make_takeoff: Callable[..., Takeoff], strict_c: StrictC, tmp_path: Path, name: str, sanitized: bool
) -> None:
    takeoff = make_takeoff(controller=name)
    run = scored_run(takeoff, fly(takeoff))
    export_with_flight(run, tmp_path / "c")
    done = subprocess.run(
        [built(tmp_path / "c") if sanitized else linked(tmp_path / "c", strict_c)],
        input=(tmp_path / "c" / FLIGHT).read_bytes(),
        capture_output=True,
        check=False,
    )
    said = done.stderr.decode()
    assert done.returncode == 0, said
    log = run.log
    found = np.frombuffer(done.stdout).reshape(log.sizes["time"], -1)
    names = ("thrusts_command", "joint_angles_command", "vectoring_angles_command")
    np.testing.assert_allclose(found, np.hstack([log[name].values for name in names]), atol=1e-9)
    assert said.startswith(f"{log.sizes['time']} ticks, ")
    assert "us at worst, of 5000 us" in said


def test_the_supervisor_of_the_flight_is_written(tmp_path: Path) -> None:
    """Exported from a log, it acted by the limits that ship, whatever the flight had."""
    flown = skylimb.run("free_flight", set={"supervisor.cut_after": 0.7, "stop_at": 0.02})
    limits = Limits(cut_after=0.7)
    for losses in (None, True):
        export_with_flight(flown, tmp_path / f"{losses}", losses)
        export_c(
            skylimb.load_controller(flown.controller, skylimb.load_robot("hydrus_xi_quad")),
            tmp_path / f"{losses} wanted",
            limits=limits if losses is None else replace(limits, losses=losses),
        )
        found, wanted = (
            (tmp_path / name / "controller.h").read_text() for name in (f"{losses}", f"{losses} wanted")
        )
        assert found == wanted  # its digest is of all files


@needs_compiler
def test_input_that_is_cut_is_told(
    make_takeoff: Callable[..., Takeoff],
    strict_c: StrictC,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    takeoff = make_takeoff()
    run = scored_run(takeoff, fly(takeoff))
    run.save(tmp_path / "log.nc")
    assert main(["export-c", "--log", str(tmp_path / "log.nc"), str(tmp_path / "c")]) == 0
    assert "./host < flight.bin > commands.bin" in capsys.readouterr().out
    program, content = linked(tmp_path / "c", strict_c), (tmp_path / "c" / FLIGHT).read_bytes()
    for part, why in ((b"", "the input is empty"), (content[:-8], "the input ends within a tick")):
        done = subprocess.run([program], input=part, capture_output=True, check=False)
        assert (done.returncode, why in done.stderr.decode()) == (1, True)
    with Path("/dev/full").open("wb") as full:  # the last commands, too, that one buffer holds
        for part in (content, content[: len(content) // len(run.log.time)]):
            done = subprocess.run([program], input=part, stdout=full, stderr=subprocess.PIPE, check=False)
            assert (done.returncode, done.stderr.decode().endswith("host: commands cannot be written\n")) == (
                2,
                True,
            )
    with pytest.raises(ConfigError, match="cannot be written as C"):
        host_input(run, takeoff.experiment, type("Own", (), {"name": "own"})())  # type: ignore[arg-type]


PLAIN = """from dataclasses import dataclass
import numpy as np
@dataclass(frozen=True)
class Gains: ...
def initial_state(gains, start): return ()
def step(gains, state, inputs):
    model = inputs.estimate.body.model
    return state, np.array([float(part) for part in model.mass * model.gravity]), {}
"""


def test_a_law_in_python_is_named_where_it_stays(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("plain.py").write_text(PLAIN, encoding="utf-8")
    law = {"controller.translation.law": str(tmp_path / "plain.py")}
    flown = skylimb.run("free_flight", set={**law, "stop_at": 0.02})
    write_records({flown.name: flown}, "flown")
    assert main(["export-c", "--log", "flown", "c"]) == 2
    err = capsys.readouterr().err
    (copy,) = Path("flown/sources").rglob("plain.py")
    assert f"'{copy.relative_to('flown')}' flies in Python and cannot be written as C: sources/" in err
    assert "skylimb-" not in err
    assert err.count("\n") == 1
