"""Orders in, a flight out: the simulated plant under the lab's flight states, tick by tick, without ROS."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any

import numpy as np
import pytest

import skylimb
from skylimb.analysis.exchange.lab_messages import pose_errors
from skylimb.analysis.exchange.lab_ticks import Names
from skylimb.analysis.exchange.messages import Joints, Pose
from skylimb.apps.ros.grounded import STAND, GroundedPlant
from skylimb.apps.ros.limits import FlightLimits
from skylimb.apps.ros.requests import Requests
from skylimb.apps.ros.states import FORCE_LANDING, FlightState, Order
from skylimb.apps.ros.tick import Received
from skylimb.base.errors import ConfigError
from skylimb.base.rotations import wrapped
from skylimb.control.estimation.records import Measurement
from skylimb.flight.takeoff import take_off
from steered import Steered, in_hover

LEVEL = (1.0, 0.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def flown(slow_rotors: Callable[[], AbstractContextManager[None]]) -> Steered:
    """A whole flight: up, somewhere, joints, the mission, down."""
    robot = Steered()
    with slow_rotors():
        robot.hover()
    here = robot.ticks[-1].body
    assert here is not None
    x, y, z = here.cog
    w, s = np.cos(here.yaw / 2), np.sin(here.yaw / 2)
    robot.tick(requests=(Pose(0.0, (x - 0.5, y + 0.3, z + 0.4), (w, 0.0, 0.0, s)),))
    robot.fly(8.0)
    robot.at_goal = robot.ticks[-1].body  # type: ignore[attr-defined]
    robot.goal = np.array([x - 0.5, y + 0.3, z + 0.4])  # type: ignore[attr-defined]
    robot.tick(requests=(Joints(0.0, (), (0.9708, 1.2, -0.6)),))
    robot.fly(3.0)
    robot.posed = robot.plant.measure().joint_angles  # type: ignore[attr-defined]
    robot.tick(mission="paper")
    robot.fly(14.0)
    robot.tick(Order.LAND)
    robot.until(FlightState.ARM_OFF)
    return robot


def test_the_robot_goes_where_it_is_sent(flown: Any) -> None:
    np.testing.assert_allclose(flown.at_goal.cog, flown.goal, atol=0.08)
    # The servos are springs: they hang by up to 0.06 rad under the rotors.
    np.testing.assert_allclose(flown.posed, [0.9708, 1.2, -0.6], atol=0.07)
    assert flown.said[4:] == [
        "mission 'paper': on the way to its beginning",
        "mission 'paper': flown; hovering at its end",
        "HOVER -> LAND",
        "LAND -> STOP",
        "STOP -> ARM_OFF",
    ]
    assert not flown.pilot.faults


def test_motors_are_off_on_the_ground_and_commands_within_limits(flown: Steered) -> None:
    low, high = flown.robot.thrust_limits()
    for tick in flown.ticks:
        if tick.motors:
            assert np.all(tick.command.thrusts >= low)
            assert np.all(tick.command.thrusts <= high)
        else:
            assert not tick.command.thrusts.any()
    assert flown.plant.stands
    assert not flown.ticks[0].motors
    assert not flown.ticks[-1].motors


def test_the_mission_is_that_of_the_experiment(flown: Steered) -> None:
    missions = [tick for tick in flown.ticks if tick.script is not None and tick.script.begun]
    assert len(missions) == len(flown.takeoff.mission.times)
    for k in (0, 400, len(missions) - 1):
        np.testing.assert_array_equal(
            missions[k].reference.position,  # type: ignore[union-attr]
            flown.takeoff.mission.reference.position[k],
        )
    force = flown.plant.layout.slices["contact_force"]
    pressed = [np.linalg.norm(row[force]) > 0.5 for row in flown.rows]
    assert sum(pressed) > 150


def test_references_never_jump(flown: Steered) -> None:
    references = [tick.reference for tick in flown.ticks if tick.reference is not None]
    path = np.array([one.position for one in references])
    assert np.linalg.norm(np.diff(path, axis=0), axis=1).max() < 0.6 * flown.takeoff.period + 0.01
    headings = np.array([one.heading for one in references])
    assert np.abs(np.diff(headings)).max() < 0.01


def test_takeoff_in_hover_start_in_flight_and_a_mission_that_nobody_knows_change_nothing() -> None:
    robot = in_hover()
    before = robot.pilot.flight
    robot.tick(Order.TAKEOFF, Order.START)
    robot.fly(0.5)
    assert robot.state == FlightState.HOVER
    assert robot.said[-2:] == [
        "takeoff is refused in HOVER: the robot flies already",
        "start is refused in HOVER: it would reset the controller of this flight",
    ]
    assert robot.pilot.flight is before
    assert robot.height > 0.5
    robot.tick(mission="papper")
    assert "did you mean 'paper'?" in robot.said[-1]
    robot.tick(mission="")
    assert robot.said[-1].startswith("unknown mission ''")
    robot.tick(mission="paper")
    robot.tick(mission="paper", requests=(Pose(0.0, (0.0, 0.0, 1.0), LEVEL),))
    assert robot.said[-2:] == [
        "pose refused: mission 'paper' is being flown",
        "mission 'paper' refused: 'paper' is being flown",
    ]


def test_a_silent_motion_capture_holds_then_comes_down() -> None:
    robot = in_hover()
    robot.measures = False
    robot.fly(0.3)
    assert robot.state == FlightState.HOVER
    robot.fly(0.4)
    assert (robot.state, robot.ticks[-1].flying.shown) == (FlightState.LAND, FORCE_LANDING)
    assert robot.pilot.faults["no pose for long"] > 0
    assert any(words.startswith("force landing: broken off by the guard (") for words in robot.said)
    robot.measures = True
    robot.until(FlightState.ARM_OFF, 40.0)
    assert robot.plant.stands


SPOILT: dict[str, Callable[[Measurement], Measurement]] = {
    "not finite": lambda m: m._replace(position=np.array([np.nan, 0.0, 1.0])),
    "no attitude": lambda m: m._replace(quaternion=np.zeros(4)),
    "jump": lambda m: m._replace(position=m.position + 3.0),
    "wrong size": lambda m: m._replace(joint_angles=np.zeros(5)),
}


def test_a_spoiled_measurement_is_not_believed() -> None:
    robot = in_hover()
    for fault, spoil in SPOILT.items():
        assert not robot.pilot.faults[fault]
        for _ in range(10):
            robot.tick(spoil=spoil)
        robot.fly(0.5)
        assert robot.pilot.faults[fault] >= 10
        assert robot.state == FlightState.HOVER


def test_low_battery_lands_and_does_not_start() -> None:
    robot = in_hover()
    robot.battery = 5.0
    robot.until(FlightState.ARM_OFF, 20.0)
    robot.tick(Order.START)
    assert robot.state == FlightState.ARM_OFF
    assert "start is refused: low battery" in robot.said


def test_the_yaw_error_is_that_of_the_labs_link() -> None:
    robot = in_hover()
    place = robot.pilot.flyer.references.place_of(robot.ticks[-1].reference)  # type: ignore[arg-type]
    x, y, z = place.position
    turned = place.yaw + 0.4
    robot.tick(requests=(Pose(0.0, (x, y, z), (np.cos(turned / 2), 0.0, 0.0, np.sin(turned / 2))),))
    seen = []
    for _ in range(600):
        tick = robot.tick()
        seen.append(pose_errors(tick.view(0.0, Names(robot.robot), None)))
    wanted = [one["yaw.target_p"] for one in seen]
    assert np.ptp(wanted) == pytest.approx(0.4, abs=0.01)
    assert wanted[-1] == pytest.approx(wrapped(turned), abs=1e-6)
    off = np.abs([one["yaw.err_p"] for one in seen])
    assert off.max() > 0.02  # it lags its target
    assert off[-1] < 0.05
    yaw = robot.ticks[-1].body.yaw  # type: ignore[union-attr]
    assert seen[-1]["yaw.err_p"] == pytest.approx(wrapped(turned - yaw), abs=1e-6)
    wanted = np.mean([[one[f"{axis}.total"][0] for axis in "xyz"] for one in seen[-300:]], axis=0)
    np.testing.assert_allclose(wanted, [0.0, 0.0, robot.robot.description.gravity], atol=0.3)
    # Roll and pitch: what the attitude law aims at, in the axes of the lab's link.
    aimed = np.array([[one["roll.target_p"], one["pitch.target_p"]] for one in seen])
    said = np.array([one.signals["attitude_target"][:2] for one in robot.ticks[-600:]])
    np.testing.assert_allclose(np.linalg.norm(aimed, axis=1), np.linalg.norm(said, axis=1), atol=1e-4)
    assert np.abs([[one["roll.err_p"], one["pitch.err_p"]] for one in seen[-100:]]).max() < 0.05


@pytest.mark.parametrize("preset", ["pid", "hybrid", "following"])
def test_the_terms_of_every_axis_are_what_its_law_adds_up(preset: str) -> None:
    robot = Steered(preset)
    robot.hover()
    names = Names(robot.robot)
    for _ in range(300):
        told = pose_errors(robot.tick().view(0.0, names, None))
        assert told is not None
        for axis in ("x", "y", "z", "roll", "pitch", "yaw"):
            terms = [told[f"{axis}.{term}_term"] for term in "pid"]
            assert all(len(term) == 1 for term in terms)
            total, lift = told[f"{axis}.total"][0], robot.robot.description.gravity if axis == "z" else 0.0
            # What a law adds up is what it commands, but for what it feeds back and forward.
            assert total == pytest.approx(sum(term[0] for term in terms) + lift, abs=0.25)
        if preset != "following":  # which smooths what it sees, and holds the pen
            away, pull = (np.array([told[f"{axis}.{one}"] for axis in "xyz"]) for one in ("err_p", "p_term"))
            clear = np.abs(away) > 5e-3
            np.testing.assert_array_equal(np.sign(away[clear]), np.sign(pull[clear, 0]))


@pytest.mark.usefixtures("rotors_come_up_slowly")
@pytest.mark.parametrize(
    ("preset", "scale", "within"), [("hybrid", 0.8, 0.015), ("following", 1.25, 0.025), ("pid", 0.92, 0.015)]
)
def test_a_take_off_learns_its_thrust(preset: str, scale: float, within: float) -> None:
    robot = Steered(preset, {"plant.thrust_scale": scale})
    robot.tick()
    robot.tick(Order.START)
    robot.until(FlightState.ARM_ON)
    robot.tick(Order.TAKEOFF)
    robot.until(FlightState.HOVER, 10.0)
    flight = robot.pilot.flight
    assert flight is not None
    assert flight.lift.share == pytest.approx(1.0 / scale, rel=within)
    assert max(tick.body.tilt for tick in robot.ticks if tick.body) < 0.1  # type: ignore[union-attr]
    lifted = [tick for tick in robot.ticks if tick.scale != 1.0]
    np.testing.assert_array_equal(lifted[0].driven.thrusts, flight.lift.share * lifted[0].command.thrusts)
    assert any("times the thrust of the robot's file" in words for words in robot.said)
    robot.tick(mission="paper")
    assert ("it touches nothing" in robot.said[-1]) == (abs(1.0 / scale - 1.0) > 0.12)


@pytest.mark.usefixtures("rotors_come_up_slowly")
def test_rotors_that_do_not_lift_the_robot_stop() -> None:
    robot = Steered("hybrid", {"plant.thrust_scale": 0.7})
    robot.tick()
    robot.tick(Order.START)
    robot.until(FlightState.ARM_ON)
    robot.tick(Order.TAKEOFF)
    robot.until(FlightState.ARM_OFF, 12.0)
    assert "force landing: 1.35 times the hover thrusts do not lift it" in robot.said
    assert robot.plant.truth().position[2] < STAND + 0.01


@pytest.mark.usefixtures("rotors_come_up_slowly")
def test_a_landing_while_the_rotors_come_up_stops_them() -> None:
    robot = Steered()
    robot.tick()
    robot.tick(Order.START)
    robot.until(FlightState.ARM_ON)
    robot.tick(Order.TAKEOFF)
    robot.fly(0.5)
    robot.tick(Order.LAND)
    robot.until(FlightState.ARM_OFF, 5.0)
    assert max(row[robot.plant.layout.slices["configuration"]][2] for row in robot.rows) < STAND + 0.01


def test_a_fence_lands_who_leaves_it_and_refuses_who_would() -> None:
    robot = Steered()
    limits = FlightLimits(fence=((-5.0, 5.0), (-0.5, 5.0), (-1.0, 1.0)))
    robot.pilot.flyer = dataclasses.replace(robot.pilot.flyer, limits=limits)
    robot.pilot._requests = Requests(robot.robot, limits)
    robot.hover()
    robot.tick(requests=(Pose(0.0, (0.0, 0.0, 1.2), LEVEL),))
    assert robot.said[-1] == "pose refused: it is beyond the fence: z = 1.20 m is outside of -1 .. 1 m"
    robot.tick(mission="paper")
    assert "it leads beyond the fence" in robot.said[-1]
    robot.plant._data.qvel[1] = -2.0  # pushed out
    robot.until(FlightState.LAND, 3.0)
    assert robot.said[-2].startswith("force landing: beyond the fence: y = -0.5")
    robot.plant._data.qvel[1] = 0.0
    robot.until(FlightState.ARM_OFF, 10.0)


def test_land_on_the_surface_goes_back_before_it_goes_down() -> None:
    robot = in_hover()
    robot.tick(mission="paper")
    contact = 0
    while contact < 50:
        script = robot.tick().script
        contact += script is not None and script.begun and robot.ticks[-1].reference.touch > 0.0  # type: ignore[union-attr]
    robot.fly(0.5)
    x = robot.ticks[-1].body.cog[0]  # type: ignore[union-attr]
    robot.tick(Order.LAND)
    robot.fly(1.6)
    assert robot.ticks[-1].body.cog[0] < x - 0.2  # type: ignore[union-attr]
    assert robot.state == FlightState.LAND
    robot.until(FlightState.ARM_OFF, 30.0)


def test_halt_stops_the_motors_at_once() -> None:
    robot = in_hover()
    robot.acknowledges = False
    tick = robot.tick(Order.HALT)
    assert (robot.state, tick.motors) == (FlightState.STOP, False)
    robot.fly(1.0)
    assert robot.plant.stands


def test_requests_are_refused_where_nothing_hovers() -> None:
    robot = Steered()
    robot.tick()
    robot.tick(requests=(Pose(0.0, (0.0, 0.0, 1.0), LEVEL),), mission="paper")
    assert robot.said == ["pose refused: nothing flies", "mission 'paper' refused: nothing flies"]
    robot.tick(requests=(Joints(0.0, (), (0.9708, 1.2, -0.6)),))
    robot.fly(1.0)
    np.testing.assert_allclose(robot.plant.measure().joint_angles, [0.9708, 1.2, -0.6], atol=0.02)
    robot.tick(Order.START)
    robot.tick(requests=(Pose(0.0, (0.0, 0.0, 1.0), LEVEL),))
    assert "not steered" in robot.said[-1] or "not steered" in robot.said[-2]


def test_a_controller_that_fails_brings_the_robot_down() -> None:
    class Fails:
        name = "fails"

        def __init__(self) -> None:
            self.inner = skylimb.load_controller("hybrid", skylimb.load_robot("hydrus_xi_quad"))
            self.ticks = 0

        def gains(self) -> Any:
            return self.inner.gains()

        def initial_state(self) -> Any:
            return self.inner.initial_state()

        def step(self, *given: Any) -> Any:
            self.ticks += 1
            if self.ticks > 100:
                raise ValueError("spring broke")
            return self.inner.step(*given)

    robot = Steered()
    failing: Any = Fails()
    robot.pilot.flyer = dataclasses.replace(robot.pilot.flyer, controller=failing)
    robot.tick()
    robot.tick(Order.START)
    robot.until(FlightState.ARM_ON)
    robot.tick(Order.TAKEOFF)
    robot.fly(4.0)
    assert "controller 'fails' failed: spring broke" in robot.said
    assert robot.ticks[-1].flying.shown == FORCE_LANDING or robot.plant.stands


def test_experiments_whose_changes_hang_on_take_off_are_refused() -> None:
    push = {"kind": "push", "time": 1.0, "duration": 1.0, "force": [1.0, 0.0, 0.0]}
    (takeoff,) = take_off("paper", ("hybrid",), set={"events": [push]})
    with pytest.raises(ConfigError, match="whose take-off its user chooses, cannot apply 'push'"):
        GroundedPlant(takeoff)


def test_the_ground_holds_the_plant(flown: Steered) -> None:
    layout = flown.plant.layout
    heights = np.array([row[layout.slices["configuration"]][2] for row in flown.rows])
    # A link may sink by a hair while the centre of gravity already rises: the ground has let go.
    assert heights.min() >= STAND - 1e-5
    assert heights[:200].max() == STAND


def test_who_commands_a_robot_that_flies_as_well_is_named_at_once() -> None:
    """Nobody heard of it before the next `start`."""
    robot, other = in_hover(), "/base_node on /hydrus_xi/four_axes/command"
    robot.said.clear()
    for foreign in ((), (other,), (other,), None):
        robot.tick(received=Received(foreign=foreign))
    assert robot.said == [f"{other} commands the robot as well: end it"]
    assert robot.pilot.faults["another node commands the robot"] == 1
    assert robot.state == FlightState.HOVER
