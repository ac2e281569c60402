"""The loop by itself: any driver, any mission, no simulator."""

import subprocess
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import skylimb
from skylimb.base.packing import Layout
from skylimb.control.loop.flight import CONFIGURATION, Flight
from skylimb.control.loop.loop import CHECK_INTERVAL, Loop
from skylimb.control.loop.terminations import Terminations, find_loss
from skylimb.control.missions.frame import contact_frame
from skylimb.control.missions.mission import Mission
from skylimb.control.missions.reference import Reference, zero_reference
from skylimb.flight.flying import begin_loop
from skylimb.flight.stepped import SteppedFlight
from skylimb.flight.takeoff import take_off

LAYOUT: Layout[dict[str, Any]] = Layout(
    {"root_position_measured": np.zeros(3), "root_quaternion_measured": np.zeros(4)}
)
HERE = np.array([0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0])


class Scripted:
    """A driver that records poses it was given, and goes on with the mission as it was told."""

    def __init__(self, poses: np.ndarray, pace: int = 1, fault_after: int = 10**9) -> None:
        self.layout, self.poses, self.pace, self.fault_after = LAYOUT, poses, pace, fault_after
        self.log = np.full((len(poses), LAYOUT.size), np.nan)
        self.flown = 0

    def tick(self, k: int) -> int:
        assert k == self.flown
        self.log[k] = self.poses[k]
        self.flown += 1
        return self.pace * (k + 1)

    def fault(self) -> str:
        return "the wheels came off" if self.flown > self.fault_after else ""

    def notes(self) -> tuple[str, ...]:
        return (f"{self.flown} ticks flown",)


def mission(ticks: int = 250, patience: float = 1.0) -> Mission:
    zeros = zero_reference(1, 1)._asdict()
    zeros.pop("ahead")
    rows: dict[str, Any] = {name: np.zeros((ticks, *np.shape(entry))) for name, entry in zeros.items()}
    reference = Reference(**rows)
    reference = reference._replace(position=np.tile([0.0, 0.0, 1.0], (ticks, 1)))
    return Mission(
        np.arange(ticks) * 0.01,
        0.01,
        reference,
        np.zeros(ticks, int),
        contact_frame((1.0, 0.0, 0.0)),
        np.zeros((ticks, 3)),
        False,
        patience,
    )


def loop(poses: np.ndarray, **options: Any) -> tuple[Loop, Scripted]:
    driver = Scripted(poses, **options)
    return Loop(driver, mission(len(poses)), Terminations(), len(poses)), driver


def test_a_flight_ends_with_its_mission() -> None:
    flown, driver = loop(np.tile(HERE, (250, 1)))
    ticks = 0
    while flown.tick():
        ticks += 1
        assert flown.ticks == ticks
        assert flown.time == pytest.approx(0.01 * ticks)
    flight = flown.stop()
    assert (flight.ticks, flight.cause, driver.flown) == (250, "", 250)
    assert flown.over
    assert not flown.tick()
    assert driver.flown == 250


def test_a_mission_that_goes_faster_ends_earlier() -> None:
    flown, _ = loop(np.tile(HERE, (250, 1)), pace=2)
    flight = flown.fly()
    assert (flight.ticks, flight.cause) == (125, "")


@pytest.mark.parametrize(
    ("change", "cause"),
    [
        ({2: 0.04}, "hit the floor: below 0.05 m"),
        ({0: 2.1}, "lost position: more than 2 m from the reference"),
        ({3: np.cos(0.51), 4: np.sin(0.51)}, "lost attitude: tilt above 1 rad"),
        ({3: np.cos(0.51), 5: np.sin(0.51)}, "lost attitude: tilt above 1 rad"),
        ({1: np.nan}, "diverged: root_position_measured not finite"),
    ],
)
def test_a_loss_ends_the_flight_at_its_first_tick(change: dict[int, float], cause: str) -> None:
    poses = np.tile(HERE, (250, 1))
    for column, value in change.items():
        poses[130:, column] = value
    flown, driver = loop(poses)
    flight = flown.fly()
    assert flight.ticks == 131
    assert flight.cause == f"{cause} at t = 1.300 s"
    assert driver.flown == 2 * CHECK_INTERVAL


@pytest.mark.parametrize(
    "inside", [{2: 0.06}, {0: 1.9}, {3: np.cos(0.49), 4: np.sin(0.49)}, {3: 0.0, 6: 1.0}]
)
def test_what_is_within_the_limits_goes_on(inside: dict[int, float]) -> None:
    poses = np.tile(HERE, (250, 1))
    for column, value in inside.items():
        poses[:, column] = value
    assert loop(poses)[0].fly().cause == ""


def test_limits_are_those_of_the_experiment() -> None:
    poses = np.tile(HERE, (250, 1))
    poses[50:, 0] = 0.3
    driver = Scripted(poses)
    flight = Loop(driver, mission(), Terminations(distance=0.2), 250).fly()
    assert flight.cause == "lost position: more than 0.2 m from the reference at t = 0.500 s"


def test_a_fault_of_the_vehicle_ends_the_flight() -> None:
    flown, _ = loop(np.tile(HERE, (250, 1)), fault_after=150)
    flight = flown.fly()
    assert flight.cause == "diverged: the wheels came off before t = 1.990 s"
    assert flight.ticks == 200


def test_progress_ends_with_the_mission() -> None:
    flown, _ = loop(np.tile(HERE, (250, 1)))
    seen: list[tuple[int, int]] = []
    flown.fly(lambda done, total: seen.append((done, total)))
    assert seen == [(100, 250), (200, 250), (250, 250)]


def test_a_flight_that_is_stopped_says_so() -> None:
    flown, _ = loop(np.tile(HERE, (250, 1)))
    for _ in range(42):
        flown.tick()
    flight = flown.stop()
    assert flight.cause == "stopped from outside at t = 0.420 s, before the mission's end"
    assert flight.ticks == 42


SHORT = {
    "phases.hover": 0.2,
    "phases.tare": 0.2,
    "phases.settle": 0.2,
    "phases.hover_end": 0.1,
    "approach.depth": 0.05,
    "approach.standoff": 0.02,
    "approach.speed": 0.2,
    "trajectory.shape": "hold",
    "trajectory.duration": 0.3,
}


PUSHED = {
    **SHORT,
    "events": [{"kind": "push", "time": 0.3, "duration": 0.6, "force": [0.0, 6.0, -3.0]}],
}


@pytest.mark.parametrize("controller", ["hybrid", "following"])
def test_stepped_by_hand_it_is_the_flight_of_run(controller: str) -> None:
    flight = skylimb.begin("paper", controller=controller, set=SHORT, seed=3)
    assert isinstance(flight, SteppedFlight)
    while flight.tick():
        assert len(flight.signal("contact_force")) == flight.ticks
    stepped, whole = flight.finish(), skylimb.run("paper", controller=controller, set=SHORT, seed=3)
    assert stepped.status == whole.status == "OK"
    assert stepped.metrics == whole.metrics
    for name in ("configuration", "thrusts_command", "contact_force", "cog_position_reference"):
        np.testing.assert_array_equal(stepped.log[name].values, whole.log[name].values)


def test_a_stepped_flight_may_be_left_early() -> None:
    flight = skylimb.begin("paper", controller="pid", set=SHORT)
    while flight.time < 0.5:
        flight.tick()
    run = flight.finish()
    assert run.status == "FAILED"
    assert "stopped from outside at t = 0.500 s" in run.cause
    assert run.metrics["error_u_median"] is None


def test_the_experiment_states_when_a_flight_is_lost() -> None:
    run = skylimb.run("paper", controller="pid", set={**PUSHED, "terminations.tilt": 0.06})
    assert run.status == "FAILED"
    assert "tilt above 0.06 rad" in run.cause
    with pytest.raises(skylimb.SkylimbError, match=r"terminations\.tilt"):
        skylimb.run("paper", set={"terminations.tilt": -1.0})


def test_every_driver_stops_at_the_same_limit(any_limit: Callable[[], dict[str, Any]]) -> None:
    from skylimb.flight.drivers.native import fly_native, native_available

    if not native_available():
        pytest.skip("no C compiler on this machine")
    (takeoff,) = take_off("paper", ("pid",), set={**PUSHED, **any_limit()})
    here, [native] = begin_loop(takeoff).fly(), fly_native([takeoff])
    assert here.cause
    assert (native.ticks, native.cause) == (here.ticks, here.cause)


@pytest.fixture(params=["tilt", "distance", "height"])
def any_limit(request: pytest.FixtureRequest) -> Callable[[], dict[str, Any]]:
    limits = {"tilt": 0.06, "distance": 0.1, "height": 1.19}
    return lambda: {f"terminations.{request.param}": limits[request.param]}


def test_a_flight_program_needs_no_simulator() -> None:
    code = (
        "import sys, skylimb.flight.drivers.free, skylimb.control.loop.loop, skylimb.control.missions.plan, "
        "skylimb.control.cascade; print(sorted({'mujoco'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_loss_names_the_signals_that_are_no_numbers() -> None:
    """Whatever ends the flight, a signal that became NaN before is the likelier reason."""
    layout = Layout({CONFIGURATION: np.zeros(7), "force_command": np.zeros(3), "mine": 0.0, "other": 0.0})
    rows = np.tile(np.concatenate([HERE, np.zeros(5)]), (200, 1))
    rows[:, layout.slices["other"]] = np.where(np.arange(200) < 20, 0.0, np.nan)[:, None]
    rows[50:, layout.slices["force_command"]] = rows[50:, layout.slices["mine"]] = np.nan
    rows[130:, 2] = 0.04
    flown = Flight(rows, layout, 200, "")
    assert find_loss(flown, mission(), Terminations()) == (
        130,
        "hit the floor: below 0.05 m at t = 1.300 s; other not finite since t = 0.200 s (tick 20)"
        "; mine not finite since t = 0.500 s (tick 50); force_command not finite since t = 0.500 s (tick 50)",
    )
