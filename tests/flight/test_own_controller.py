"""A user's own controller in flight: compiled, with its gains and its signals."""

import re
import sys
from pathlib import Path

import numpy as np
import pytest

import skylimb
from short_flights import HOLD
from skylimb.base.config import write_toml
from skylimb.base.errors import ConfigError, UnknownNameError
from skylimb.control.laws.preset import preset_mapping
from skylimb.flight.drivers.native import fly_native, native_available
from skylimb.flight.flying import fly_here
from skylimb.flight.takeoff import take_off

EXAMPLE = str(Path(__file__).parents[2] / "examples" / "user_controller.py")


def test_both_compiled_drivers_give_the_same_bits() -> None:
    if not native_available():
        pytest.skip("no compiler here")
    (takeoff,) = take_off("paper", (EXAMPLE,), set=HOLD)
    assert takeoff.traceable
    here, native = fly_here(takeoff), fly_native([takeoff])[0]
    assert (here.cause, here.ticks) == (native.cause, native.ticks) == ("", len(takeoff.times))
    np.testing.assert_array_equal(here.signals[: here.ticks], native.signals[: native.ticks])


def test_a_run_has_its_gains_and_its_signals_with_units() -> None:
    run = skylimb.run("paper", EXAMPLE, set={**HOLD, "controller.spin": [12.0, 12.0, 6.0]})
    assert run.status == "OK", run.cause
    signal = run.log.integral_acceleration
    assert signal.attrs == {
        "units": "m/s^2",
        "frame": "W",
        "long_name": "what the integral adds",
        "kind": "command",
    }
    assert signal.dims == ("time", "axis")
    assert run.config_units["controller.spin"] == "1/s"
    assert "spin = [\n    12.0,\n    12.0,\n    6.0,\n]" in run.config


def test_a_signal_that_is_declared_is_recorded(tmp_path: Path) -> None:
    text = (
        Path(EXAMPLE)
        .read_text(encoding="utf-8")
        .replace('        "integral_acceleration": sky', '        "integral": sky')
    )
    (tmp_path / "own.py").write_text(text, encoding="utf-8")
    with pytest.raises(UnknownNameError, match=r"'integral'; did you mean 'integral_acceleration'"):
        skylimb.run("paper", str(tmp_path / "own.py"), set=HOLD)
    (tmp_path / "own.py").write_text(text.replace("SIGNALS = {", "SIGNALS = 3 or {"), encoding="utf-8")
    with pytest.raises(skylimb.SkylimbError, match="SIGNALS should be a table"):
        skylimb.run("paper", str(tmp_path / "own.py"), set=HOLD)


LAW = """
import skylimb
from skylimb.control.translation.laws.pid import Gains, initial_state
from skylimb.control.translation.laws.pid import step as pid

SIGNALS = {"pull": skylimb.Signal("N", "W", "what the law wants")}

def step(gains, state, inputs):
    state, force, signals = pid(gains, state, inputs)
    return state, force, {**signals, "pull": force}
"""


def test_a_law_declares_its_signals(tmp_path: Path) -> None:
    (tmp_path / "law.py").write_text(LAW, encoding="utf-8")
    tables = preset_mapping("pid")[0]
    tables["translation"]["law"] = "law.py"
    (tmp_path / "own.toml").write_text(write_toml(tables), encoding="utf-8")
    run = skylimb.run("paper", str(tmp_path / "own.toml"), set=HOLD)
    assert run.log.pull.attrs["units"] == "N"
    assert run.log.pull.attrs["long_name"] == "what the law wants"


IN_PYTHON = """
import numpy as np
from skylimb import Command

class Own:
    name = "own"
    def __init__(self, robot): self.robot = robot
    def gains(self): return None
    def initial_state(self): return 0.0
    def step(self, gains, state, measurement, reference, dt):
        if measurement.position[2] < 0.0:
            raise ValueError("below the floor")
        SEEN.append(measurement)
        model = self.robot.at(measurement.joint_angles, measurement.vectoring_angles)
        command = Command(list(model.hover_thrusts), reference.joint_angles, reference.vectoring_angles)
        return state + dt, command, SIGNALS

SEEN = []

def controller(robot):
    return Own(robot)
"""


def written(folder: Path, signals: str = '{"z": measurement.position[2], "both": np.ones(2)}') -> str:
    (folder / "own.py").write_text(IN_PYTHON.replace("SIGNALS", signals), encoding="utf-8")
    return str(folder / "own.py")


def test_a_flight_in_python_says_why_and_what_a_tick_costs(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    run = skylimb.run("paper", written(tmp_path), set=HOLD)
    (said,) = [record.getMessage() for record in caplog.records if record.name == "skylimb.flight.flying"]
    assert re.fullmatch(
        r"controller 'own' flies in Python, \d+ us a tick \(.* control periods.*\): "
        r".*own\.py, line 11, `if measurement\..*where.*",
        said,
    )
    assert run.log["both"].shape == (run.log.sizes["time"], 2)
    np.testing.assert_array_equal(run.log["z"], run.log.root_position_measured.sel(axis="z"))


def test_what_a_controller_keeps_of_a_measurement_stays(tmp_path: Path) -> None:
    (takeoff,) = take_off("paper", (written(tmp_path),), set=HOLD)
    flight = fly_here(takeoff)
    made = vars(takeoff.controller)["made"]
    seen = sys.modules[type(made).__module__].SEEN[-flight.ticks :]
    kept = np.array([measurement.position for measurement in seen])
    np.testing.assert_array_equal(kept, flight.signal("root_position_measured"))


@pytest.mark.parametrize(
    ("signals", "message"),
    [
        ("({'a': 1.0} if state < 0.1 else {'b': 1.0})", "records other signals than at its first tick: a, b"),
        (
            "{'a': np.ones(3 if state < 0.1 else 2)}",
            r"signal 'a' the shape \(2,\), at its first tick it had \(3,\)",
        ),
    ],
)
def test_signals_are_those_of_the_first_tick(tmp_path: Path, signals: str, message: str) -> None:
    run = skylimb.run("paper", written(tmp_path, signals), set=HOLD)
    assert run.failed
    assert re.search(rf"^broken off at t = 0\.100 s: controller 'own'.*{message}", run.cause)


def test_a_surface_is_no_controller(tmp_path: Path) -> None:
    (tmp_path / "bumps.py").write_text("def height(u, v, keys): return 0.0 * u\n", encoding="utf-8")
    with pytest.raises(ConfigError, match=r"bumps\.py' is a surface, not a controller; .*surface\.kind="):
        skylimb.run("paper", str(tmp_path / "bumps.py"), set=HOLD)


def test_a_law_is_no_controller(tmp_path: Path) -> None:
    law = Path(__file__).parents[2] / "examples" / "laws" / "spring.py"
    with pytest.raises(
        ConfigError, match=r"spring\.py' is a law, not a controller; name it in the slot of a preset"
    ):
        skylimb.run("paper", str(law))


REMEMBERING = """import numpy as np, skylimb
RNG, COUNT = np.random.default_rng(), []
class Own:
    name = "own"
    def __init__(self): self.rng, self.sum = np.random.default_rng(3), 0.0
    def gains(self): return None
    def initial_state(self): return ()
    def step(self, gains, state, measurement, reference, dt):
        self.sum += float(measurement.position[2])
        COUNT.append(1)
        thrusts = 9.0 + np.full(4, ADDED)
        return state, skylimb.Command(thrusts, reference.joint_angles, reference.vectoring_angles), {}
ONE = Own()
def controller(robot): return MADE
"""


@pytest.mark.parametrize(
    ("added", "made", "repeats"),
    [
        ("RNG.normal()", "Own()", False),
        ("1e-3 * len(COUNT)", "Own()", False),
        ("1e-3 * self.sum", "ONE", False),
        ("1e-3 * self.sum", "Own()", True),  # made anew for each flight
        ("self.rng.normal()", "Own()", True),  # seeded
        ("0.0", "5 / (len(COUNT) < 15) and Own()", False),
    ],
)
def test_a_controller_that_is_another_one_when_it_is_made_anew_is_a_note(
    tmp_path: Path, added: str, made: str, repeats: bool
) -> None:
    own = tmp_path / "own.py"
    own.write_text(REMEMBERING.replace("ADDED", added).replace("MADE", made), encoding="utf-8")
    run = skylimb.run("paper", str(own), set={**HOLD, "stop_at": 0.1})
    noted = [note for note in run.notes if note.startswith("this run cannot be repeated: controller 'own' ")]
    assert bool(noted) != repeats, run.notes
    if "COUNT) <" in made:
        assert "fails when it is made anew" in noted[0]
    elif noted:
        assert "gives other thrusts when it is made anew" in noted[0]


TABLED = """from dataclasses import dataclass
from pathlib import Path
FILES = NAMED
SCALE = float(open(OPENED).read())
@dataclass(frozen=True)
class Gains: ...
def initial_state(gains, start): return ()
def step(gains, state, inputs):
    return state, SCALE * inputs.estimate.body.model.mass * inputs.estimate.body.model.gravity, {}
"""
BESIDE = 'Path(__file__).parent / "scale.csv"'


@pytest.mark.parametrize(
    ("opened", "named", "noted"),
    [
        (BESIDE, "()", True),
        ('"scale.csv"', "()", True),
        (BESIDE, '("scale.csv",)', False),
        (BESIDE.replace("scale.csv", ".cache"), "()", False),  # a cache is nobody's table
    ],
)
def test_a_file_that_a_law_opens_and_does_not_name_is_a_note(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, opened: str, named: str, noted: bool
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("scale.csv", ".cache"):
        (tmp_path / name).write_text("1.0")
    text = TABLED.replace("NAMED", named).replace("OPENED", opened)
    (tmp_path / "law.py").write_text(text, encoding="utf-8")
    run = skylimb.run("paper", "pid", set={**HOLD, "stop_at": 0.1, "controller.translation.law": "law.py"})
    assert any(name.endswith("scale.csv") for name in run.sources) == ("scale" in named)
    told = (
        "this run cannot be repeated: 'law.py' opens 'scale.csv', of which no copy is kept: put it beside, "
        f'write FILES = ("scale.csv",), and open {BESIDE}'
    )
    assert [note for note in run.notes if "repeated" in note] == ([told] if noted else [])


def test_what_an_installed_package_opens_is_its_own_affair(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "site-packages").mkdir()
    (tmp_path / "site-packages" / "opening_package.py").write_text('TEXT = open("its.cfg").read()\n')
    monkeypatch.syspath_prepend(tmp_path / "site-packages")
    (tmp_path / "its.cfg").write_text("1.0")
    text = "import opening_package\ndef height(u, v, keys): return 0.1 * u\n"
    (tmp_path / "ramp.py").write_text(text)
    run = skylimb.run("paper", "pid", set={**HOLD, "stop_at": 0.1, "surface.kind": "ramp.py"})
    assert "opening_package" in sys.modules
    assert not [note for note in run.notes if "repeated" in note]


def test_so_is_a_file_that_a_surface_opens(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "slope.csv").write_text("0.1")
    text = 'SLOPE = float(open("slope.csv").read())\ndef height(u, v, keys): return SLOPE * u\n'
    (tmp_path / "ramp.py").write_text(text)
    run = skylimb.run("paper", "pid", set={**HOLD, "stop_at": 0.1, "surface.kind": "ramp.py"})
    (note,) = [note for note in run.notes if "repeated" in note]
    assert "'ramp.py' opens 'slope.csv', of which no copy is kept" in note


@pytest.mark.parametrize("files", ['"table.csv"', "(1,)"])
def test_files_are_a_tuple_of_names(tmp_path: Path, files: str) -> None:
    (tmp_path / "table.csv").write_text("1.0")
    (tmp_path / "own.py").write_text(f"FILES = {files}\ndef controller(robot): return None\n")
    with pytest.raises(ConfigError, match=r"'own\.py': FILES = .* should be a tuple of names"):
        skylimb.run("paper", str(tmp_path / "own.py"), set=HOLD)
