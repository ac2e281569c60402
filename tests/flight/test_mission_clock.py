"""A controller that sets the pace of the mission's own clock."""

import dataclasses
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import skylimb
from skylimb.base.config import write_toml
from skylimb.control.laws.preset import preset_mapping
from skylimb.control.loop.flight import Flight
from skylimb.control.missions.clock import Clock, reference_between
from skylimb.control.needs import needs_of
from skylimb.flight.flying import fly, fly_here
from skylimb.flight.takeoff import take_off

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
from skylimb.control.needs import Needs
from skylimb.control.records import ContactView


@dataclass(frozen=True)
class Gains:
    pace: float


def needs(gains):
    return Needs(paced=True)


def initial_state(gains, start):
    return ()


def step(gains, state, inputs):
    return state, ContactView(), {"pace": gains.pace}
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


def flights(controller: str, patience: float) -> tuple[Flight, Flight, Flight]:
    """The same flight by the compiled driver, the free one and the fastest of this machine."""
    (takeoff,) = take_off("paper", (controller,), set={**MISSION, "phases.patience": patience})
    inner = takeoff.controller
    hidden: Any = SimpleNamespace(
        name=inner.name,
        needs=needs_of(inner),
        gains=inner.gains,
        initial_state=inner.initial_state,
        step=inner.step,
    )
    slow = dataclasses.replace(takeoff, controller=hidden)
    return fly_here(takeoff), fly_here(slow), fly(takeoff)


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


@pytest.mark.slow
def test_every_driver_keeps_the_same_clock(preset: Any) -> None:
    compiled, plain, native = flights(preset(0.6), 2.0)
    for other in (plain, native):
        assert (other.ticks, other.cause) == (compiled.ticks, compiled.cause) == (compiled.ticks, "")
        for name in ("mission_time", "configuration", "thrusts_command"):
            np.testing.assert_allclose(other.signal(name), compiled.signal(name), atol=1e-9, err_msg=name)


@pytest.mark.parametrize(("pace", "patience"), [(0.2, 5.0), (0.8, 4.0), (0.01, 20.0)])
def test_a_flight_has_patience_for_a_path_that_waits_all_the_way(pace: float, patience: float) -> None:
    changes = {**MISSION, "controller.contact.waiting_pace": pace}
    (takeoff,) = take_off("paper", ("drawing",), set=changes)
    assert len(takeoff.times) == pytest.approx(patience * len(takeoff.mission.times), abs=1.0)


def test_a_mission_that_never_goes_on_fails_and_says_so(preset: Any) -> None:
    compiled, plain, native = flights(preset(0.0), 1.0)
    for flight in (compiled, plain, native):
        assert "the controller held the mission back, which was at 0.000 s of" in flight.cause
        assert flight.ticks == compiled.ticks
    run = skylimb.run("paper", controller=preset(0.0), set={**MISSION, "phases.patience": 1.5})
    assert (run.status, run.failed, run.lost) == ("UNFINISHED", True, False)
    assert "1.5 times its time were over" in run.cause
    assert run.metrics["error_u_median"] is None
    length = skylimb.run("paper", controller="hybrid", set=MISSION).log.sizes["time"]
    assert run.log.sizes["time"] == pytest.approx(1.5 * length, abs=2)


@pytest.mark.parametrize("pace", [-3.0, 1e9])
def test_a_pace_beyond_reason_breaks_nothing(pace: float, preset: Any) -> None:
    compiled, _, native = flights(preset(pace), 1.0)
    assert ("held the mission back" in compiled.cause) == (pace < 0.0)
    assert (native.ticks, native.cause) == (compiled.ticks, compiled.cause)
    np.testing.assert_allclose(native.signal("mission_time"), compiled.signal("mission_time"), atol=1e-12)


def test_a_users_controller_that_sets_the_pace_has_to_have_the_signal(tmp_path: Path) -> None:
    file = tmp_path / "own.py"
    file.write_text(
        "from skylimb.control.controller import load_controller\n"
        "from skylimb.control.needs import Needs\n\n\n"
        "class Paced:\n    name, needs = 'own', Needs(paced=True)\n\n"
        "    def __init__(self, robot):\n        self.inner = load_controller('pid', robot)\n"
        "        self.gains, self.initial_state = self.inner.gains, self.inner.initial_state\n\n"
        "    def step(self, *given):\n        return self.inner.step(*given)\n\n\n"
        "def controller(robot):\n    return Paced(robot)\n"
    )
    with pytest.raises(skylimb.SkylimbError, match="has no signal 'pace'"):
        skylimb.run("paper", controller=str(file), set=MISSION)


def test_between_two_ticks_rates_slow_down_with_the_clock() -> None:
    (takeoff,) = take_off("paper", ("hybrid",), set=MISSION)
    here, there = takeoff.mission.row(150), takeoff.mission.row(151)
    found = reference_between(here, there, Clock(150.25, 0.5))
    np.testing.assert_allclose(found.position, 0.75 * here.position + 0.25 * there.position)
    np.testing.assert_allclose(found.velocity, 0.5 * (0.75 * here.velocity + 0.25 * there.velocity))
    np.testing.assert_allclose(
        found.acceleration, 0.25 * (0.75 * here.acceleration + 0.25 * there.acceleration)
    )


def test_the_logged_reference_velocity_is_the_derivative_of_the_logged_position(preset: Any) -> None:
    """The log shows what a controller was sent whose clock is slower than the mission's."""
    run = skylimb.run("paper", controller=preset(0.5), set=MISSION)
    t, position = run.log.time.values, run.log.cog_position_reference.values
    derivative = np.gradient(position, t, axis=0)
    velocity = run.log.cog_velocity_reference.values
    sliding = (run.log.phase == 4).values
    inside = np.convolve(sliding, np.ones(9), "same") == 9.0
    assert abs(velocity[inside]).max() > 0.03
    np.testing.assert_allclose(velocity[inside], derivative[inside], atol=1e-3)


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
