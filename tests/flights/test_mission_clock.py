"""A controller that sets the pace of the mission's own clock."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import skylimb
from skylimb.config import write_toml
from skylimb.control.cascade import Cascade
from skylimb.control.controller import load_controller
from skylimb.control.preset import preset_mapping
from skylimb.experiments.flyable import first_row
from skylimb.experiments.run import prepare_flight
from skylimb.simulation.drivers import fly_compiled, mission_rows
from skylimb.simulation.flight import Flight
from skylimb.simulation.native import NativeJob, fly_native, native_available
from skylimb.simulation.plant import initial_data
from skylimb.simulation.python_driver import fly_python
from skylimb.simulation.tick import Clock, compile_tick, reference_between

MISSION = {
    "phases.hover": 0.2,
    "phases.tare": 0.2,
    "phases.settle": 0.1,
    "phases.hover_end": 0.1,
    "phases.patience": 2.1,
    "approach.contact": False,
    "trajectory.shape": "line",
    "trajectory.length": 0.1,
    "trajectory.speed": 0.2,
    "trajectory.feedforward": "full",
}
LAW = '''
"""Keeps the mission's clock at one pace, from the beginning of the path on."""
from dataclasses import dataclass
from skylimb.control.records import no_contact

PACED = True


@dataclass(frozen=True)
class Gains:
    pace: float


def initial_state(gains):
    return ()


def step(gains, state, inputs):
    return state, no_contact(), {"pace": gains.pace}
'''


@pytest.fixture
def preset(tmp_path: Path) -> Any:
    """Writes the hybrid with a contact law that keeps one pace, and tells its file."""
    (tmp_path / "steady.py").write_text(LAW)

    def write(pace: float) -> str:
        tables, _ = preset_mapping("hybrid")
        tables["contact"] = {"law": "steady.py", "pace": pace}
        file = tmp_path / f"pace{pace:g}.toml"
        file.write_text(write_toml(tables))
        return str(file)

    return write


def flights(controller: str, patience: float) -> tuple[Flight, Flight, Flight | None]:
    """The same flight by the compiled tick, the plain loop and the native driver."""
    experiment = skylimb.load_experiment("paper", {**MISSION, "phases.patience": patience})
    robot = skylimb.load_robot("hydrus_xi_quad")
    cascade = load_controller(controller, robot)
    assert isinstance(cascade, Cascade)
    plant, mission = prepare_flight(experiment, robot)
    rows = mission_rows(plant, mission, experiment.sensors, 0, cascade.paced)
    dt, start = experiment.control_period, first_row(mission)
    data = initial_data(plant, start)
    root = np.concatenate([data.qpos[0:7], data.qvel[0:6]])
    tick = compile_tick(cascade, plant, experiment.sensors, root, dt)
    native = None
    if native_available():
        [native] = fly_native([NativeJob(tick, plant, data, mission, rows)])
    compiled = fly_compiled(tick, plant, data, mission, rows)
    plain = fly_python(cascade, plant, initial_data(plant, start), mission, rows, experiment.sensors, dt)
    return compiled, plain, native


@pytest.mark.parametrize("pace", [1.0, 0.5])
def test_half_the_pace_takes_twice_the_time(pace: float, preset: Any) -> None:
    usual = skylimb.run("paper", controller="hybrid", set=MISSION)
    run = skylimb.run("paper", controller=preset(pace), set=MISSION)
    assert run.status == "OK", run.cause
    assert float(run.log.time[-1]) == pytest.approx(float(usual.log.time[-1]) / pace, abs=0.02)
    clock = run.log.mission_time.values
    np.testing.assert_allclose(clock, pace * run.log.time.values, atol=0.006)
    # The reference goes through the same places, and each phase takes its longer time.
    np.testing.assert_allclose(
        run.log.tip_position_reference.values[:: round(1.0 / pace)][: usual.log.sizes["time"]],
        usual.log.tip_position_reference.values[: len(clock[:: round(1.0 / pace)])],
        atol=2e-3,
    )
    for phase in range(7):
        ticks = int((run.log.phase == phase).sum())
        assert ticks == pytest.approx(int((usual.log.phase == phase).sum()) / pace, abs=3)
    if pace == 1.0:
        # Not to the bit: a flight that may take longer draws the noise of its encoders in another order.
        np.testing.assert_allclose(run.log.cog_position.values, usual.log.cog_position.values, atol=5e-3)


def test_every_driver_keeps_the_same_clock(preset: Any) -> None:
    compiled, plain, native = flights(preset(0.6), 2.0)
    for other in (plain, native):
        if other is not None:
            assert (other.ticks, other.cause) == (compiled.ticks, compiled.cause) == (compiled.ticks, "")
            for name in ("mission_time", "configuration", "thrusts_command"):
                np.testing.assert_allclose(other.signal(name), compiled.signal(name), atol=1e-9, err_msg=name)


def test_a_mission_that_never_goes_on_fails_and_says_so(preset: Any) -> None:
    compiled, plain, native = flights(preset(0.0), 1.0)
    for flight in (compiled, plain, native):
        if flight is not None:
            assert "the controller held the mission back, which was at 0.000 s of" in flight.cause
            assert flight.ticks == compiled.ticks
    run = skylimb.run("paper", controller=preset(0.0), set={**MISSION, "phases.patience": 1.5})
    assert run.status == "FAILED"
    assert "1.5 times its time were over" in run.cause
    assert run.metrics["error_y_median"] is None
    length = skylimb.run("paper", controller="hybrid", set=MISSION).log.sizes["time"]
    assert run.log.sizes["time"] == pytest.approx(1.5 * length, abs=2)


@pytest.mark.parametrize("pace", [-3.0, 1e9])
def test_a_pace_beyond_reason_breaks_nothing(pace: float, preset: Any) -> None:
    compiled, _, native = flights(preset(pace), 1.0)
    assert ("held the mission back" in compiled.cause) == (pace < 0.0)
    if native is not None:
        assert (native.ticks, native.cause) == (compiled.ticks, compiled.cause)
        np.testing.assert_allclose(native.signal("mission_time"), compiled.signal("mission_time"), atol=1e-12)


def test_a_users_controller_with_a_pace_has_to_tell_it(tmp_path: Path) -> None:
    file = tmp_path / "own.py"
    file.write_text(
        "from skylimb.control.controller import load_controller\n\n\n"
        "class Paced:\n    name, paced, tells = 'own', True, False\n\n"
        "    def __init__(self, robot):\n        self.inner = load_controller('pid', robot)\n"
        "        self.gains, self.initial_state = self.inner.gains, self.inner.initial_state\n\n"
        "    def step(self, *given):\n        return self.inner.step(*given)\n\n\n"
        "def controller(robot):\n    return Paced(robot)\n"
    )
    with pytest.raises(skylimb.SkylimbError, match="tells no signal 'pace'"):
        skylimb.run("paper", controller=str(file), set=MISSION)


def test_between_two_ticks_rates_slow_down_with_the_clock() -> None:
    _, mission = prepare_flight(
        skylimb.load_experiment("paper", MISSION), skylimb.load_robot("hydrus_xi_quad")
    )
    here, there = (type(mission.reference)(*(entry[k] for entry in mission.reference)) for k in (150, 151))
    found = reference_between(here, there, Clock(150.25, 0.5))
    np.testing.assert_allclose(found.position, 0.75 * here.position + 0.25 * there.position)
    np.testing.assert_allclose(found.velocity, 0.5 * (0.75 * here.velocity + 0.25 * there.velocity))
    np.testing.assert_allclose(
        found.acceleration, 0.25 * (0.75 * here.acceleration + 0.25 * there.acceleration)
    )


def test_a_surface_that_is_not_there_is_given_up_and_the_mission_goes_on() -> None:
    far = {
        "phases.hover": 0.5,
        "phases.tare": 0.5,
        "phases.settle": 0.5,
        "phases.hover_end": 0.5,
        "phases.patience": 5.0,
        "approach.speed": 0.2,
        "trajectory.shape": "hold",
        "trajectory.duration": 1.0,
        "surface.slope": 0.0,
        "surface.advance_distance": -0.6,
        "surface.advance_speed": 2.0,
    }
    run = skylimb.run("paper", controller="following", set=far)
    assert run.status == "OK", run.cause
    assert not (run.log.contact > 0).any()
    assert "nothing there" in run.log.attrs["contact_transitions"]
