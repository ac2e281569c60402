"""The flight controller's inner loop, and our controller over its sensors, wired without ROS."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from board_case import BoardCase
from skylimb.analysis.exchange import lab_topics as topics
from skylimb.analysis.exchange.messages import (
    FourAxes,
    Gains,
    Motor,
    MotorInfo,
    PMatrix,
    TorqueInverse,
    UavInfo,
)
from skylimb.apps.ros.attitude_loop import attitude_loop, forced_by
from skylimb.apps.ros.grounded import STAND
from skylimb.apps.ros.messages import Outgoing
from skylimb.apps.ros.spinal import Spinal
from skylimb.apps.ros.states import FlightState
from skylimb.base.rotations import rotation_from_rpy
from wired import Wire

LIMITS = (np.full(4, 1.0), np.full(4, 30.0))
STILL, LEVEL = np.zeros(3), np.eye(3)
MOTORS = MotorInfo(0.58, 0.92, 1.0, 7.0, 0, (Motor(25.2, 33.0, (0.0, -5.0, 0.1, 0.0, 0.0)),))
KNOWN = Spinal(4).informed(UavInfo(4, 17)).informed(MOTORS)
BASE = FourAxes((0.0, 0.0, 0.0), (9.0, 10.0, 11.0, 12.0))


def armed(message: FourAxes = BASE) -> Spinal:
    return KNOWN.configured(0).commanded(message, 0.0)


def loop(
    spinal: Spinal, R: Any = LEVEL, rates: np.ndarray = STILL, now: float = 0.1
) -> tuple[Spinal, np.ndarray]:
    return attitude_loop(spinal, np.asarray(R), rates, now, 0.001, LIMITS)


@pytest.mark.parametrize("volts", [22.0, 24.6])
def test_duties_say_how_much_thrust_they_are_at_most(volts: float) -> None:
    thrusts = (2.0, 7.0, 8.5, 20.0)
    duties = [int(2000.0 * duty) for duty in MOTORS.duties(thrusts, volts)]
    assert sum(thrusts) <= MOTORS.most(duties, volts) < sum(thrusts) + 1.5
    assert MOTORS.most(duties, None) > MOTORS.most(duties, volts)  # as with a full battery
    assert MOTORS.most([*duties, 2000], volts) == np.inf  # a motor at its limit may give anything


def test_zero_gains_pass_the_base_thrusts_on() -> None:
    R = rotation_from_rpy(0.3, -0.2, 1.0)
    np.testing.assert_array_equal(loop(armed(), R, np.array([1.0, 2.0, 3.0]))[1], BASE.base_thrust)
    np.testing.assert_array_equal(loop(Spinal(4).commanded(BASE, 0.0))[1], np.zeros(4))


def test_terms_are_those_of_the_board() -> None:
    gains = Gains(((1000, 0, 200, 500, 0, 100, 300), (0,) * 7, (0,) * 7, (0, 0, 0, 0, 0, 0, -600)))
    spinal = KNOWN.configured(0).gained(gains).commanded(FourAxes((0.1, -0.1, 0.6), BASE.base_thrust), 0.0)
    rates = np.array([0.5, -0.5, 1.0])
    thrusts = loop(spinal, rotation_from_rpy(0.05, 0.02, 2.0), rates)[1]
    # The yaw term is that of the largest gain above zero, not of the largest one: the first rotor's.
    first = 1.0 * 0.05 + 0.5 * -0.12 - 0.2 * 0.5 - 0.1 * -0.5 - 0.3 * 1.0 + 0.6
    last = 0.6 * 1.0 + 0.6 * -0.6 / 0.3
    np.testing.assert_allclose(thrusts - BASE.base_thrust, [first, 0.0, 0.0, last], atol=1e-12)
    gyro = armed().with_p_matrix(PMatrix(((1000, 0, 0),) * 4, (1000, 2000, 3000, 0, 0, 0)))
    np.testing.assert_allclose(loop(gyro, rates=rates)[1] - BASE.base_thrust, np.full(4, -0.5), atol=1e-12)


@pytest.mark.parametrize("gimbal_dof", [0, 1, 2])
def test_it_is_the_labs_board_in_cases_that_its_own_code_flew(gimbal_dof: int) -> None:
    """Thrusts of the lab's compiled attitude controller (tools/lab_stack), in single precision."""
    kept = json.loads((Path(__file__).parent / f"board_{gimbal_dof}.json").read_text(encoding="utf-8"))
    rng = np.random.default_rng(kept["seed"])
    ours = np.array([BoardCase(rng, gimbal_dof).ours() for _ in kept["board"]])
    np.testing.assert_allclose(ours, kept["board"], atol=1e-3)
    assert ours[:, -1].sum() < len(ours) / 2


def test_where_a_motor_cannot_yaw_gives_way_then_all_base_thrusts_alike() -> None:
    gains = Gains(((0, 0, 0, 0, 0, 0, 500), (0,) * 7, (0,) * 7, (0, 0, 0, 0, 0, 0, -500)))
    spinal, wide = KNOWN.configured(0).gained(gains), (-LIMITS[1], 2.0 * LIMITS[1])
    for base, wanted in (
        ((10.0, 11.0, 12.0, 13.0), (14.0, 11.0, 12.0, 9.0)),
        ((10.0, 11.0, 12.0, 0.5), (13.5, 11.0, 12.0, -3.0)),
        ((10.0, 11.0, 12.0, 36.0), tuple(np.array([10.0, 11.0, 12.0, 36.0]) * 33.0 / 36.0)),
    ):
        thrusts = attitude_loop(
            spinal.commanded(FourAxes((0.0, 0.0, 4.0), base), 0.0), LEVEL, STILL, 0.1, 0.001, wide
        )[1]
        np.testing.assert_allclose(thrusts, wanted, atol=1e-12)


def test_gains_of_torques_become_those_of_the_rotors() -> None:
    inverse = TorqueInverse(((500, 0, 200), (-500, 0, -200), (0, 500, 200), (0, -500, -200)))
    one, tilted = Gains(((2000, 0, 0, 4000, 0, 0, 1000),)), rotation_from_rpy(0.1, 0.2, 0.0)
    for spinal in (
        armed().gained(one).with_torque_inverse(inverse),
        armed().with_torque_inverse(inverse).gained(one),
    ):
        added = loop(spinal, tilted)[1] - BASE.base_thrust
        np.testing.assert_allclose(added, [-0.1, 0.1, -0.4, 0.4], atol=1e-9)
    assert Spinal(4).with_torque_inverse(inverse).torque_inverse is None


def test_errors_are_integrated_on_command_only() -> None:
    gains = Gains(((0, 1000, 0, 0, 0, 0, 0),) * 4)
    spinal = armed().gained(gains)
    thrusts = STILL
    for command, grown in ((161, 0.0), (160, -0.1 * 1.0)):
        out = spinal.configured(command)
        for _ in range(1000):
            out, thrusts = loop(out, rotation_from_rpy(0.1, 0.0, 0.0))
        np.testing.assert_allclose(thrusts - BASE.base_thrust, np.full(4, grown), atol=1e-9)


@pytest.mark.parametrize("why", ["silence", "tilt", "commanded tilt", "command"])
def test_a_forced_landing_lowers_the_thrusts(why: str) -> None:
    spinal, R, now, thrusts = armed(), np.eye(3), 0.1, STILL
    if why == "silence":
        now = 0.6
    elif why == "tilt":
        R = rotation_from_rpy(1.1, 0.0, 0.0)
    elif why == "commanded tilt":
        spinal = armed(FourAxes((0.0, 1.1, 0.0), BASE.base_thrust))
    else:
        spinal = spinal.configured(2)
    for _ in range(1000):
        spinal, thrusts = attitude_loop(spinal, R, STILL, now, 0.001, LIMITS)
    assert spinal.force_landing
    said = "no command for 0.5 s" if why == "silence" else "commanded, or tilted by more than 1 rad"
    assert forced_by(spinal, now) == said
    assert thrusts.mean() == pytest.approx(8.0, abs=0.01)
    for _ in range(2000):
        spinal, thrusts = attitude_loop(spinal, R, STILL, now, 0.001, LIMITS)
    assert thrusts.mean() == pytest.approx(7.0, abs=0.01)
    weak = spinal.commanded(FourAxes(BASE.angles, (1.0,) * 4), 1.0)
    np.testing.assert_array_equal(weak.base, spinal.base)
    assert not spinal.configured(1).armed
    assert why != "tilt" or spinal.integral == (0.0, 0.0)


def test_messages_of_another_robot_are_none() -> None:
    spinal = armed()
    assert spinal.commanded(FourAxes(BASE.angles, (1.0,) * 6), 1.0) is spinal
    assert spinal.commanded(FourAxes(BASE.angles, (float("nan"),) * 4), 1.0) is spinal
    assert spinal.gained(Gains(((0,) * 7,) * 6)) is spinal
    assert spinal.with_p_matrix(PMatrix(((0, 0, 0),), (0,) * 6)) is spinal


def test_it_is_not_armed_before_it_knows_its_motors() -> None:
    for known in (Spinal(4), Spinal(4).informed(MOTORS), Spinal(4).informed(UavInfo(4, 17))):
        assert not known.configured(0).armed
    assert not KNOWN.informed(replace(MOTORS, max_pwm=0.58)).configured(0).armed
    assert KNOWN.configured(0).armed
    # The number of motors is not taken twice; what it knows outlasts the flight.
    assert KNOWN.informed(UavInfo(6, 17)).uav == UavInfo(4, 17)
    assert KNOWN.configured(0).configured(1).configured(0).armed


def test_a_forced_landing_ends_at_the_thrust_of_the_motor_table() -> None:
    spinal = KNOWN.informed(replace(MOTORS, force_landing_thrust=9.0)).configured(0).commanded(BASE, 0.0)
    spinal = spinal.configured(2)
    thrusts = STILL
    for _ in range(2000):
        spinal, thrusts = attitude_loop(spinal, LEVEL, STILL, 0.1, 0.001, LIMITS)
    assert thrusts.mean() == pytest.approx(9.0, abs=0.01)


def test_without_motor_info_nothing_is_acknowledged() -> None:
    wire = Wire(())
    for _ in range(30):
        wire.tick()
    wire.tick("teleop_command/start")
    for _ in range(40):
        wire.tick()
    assert wire.pilot.pilot.flying.state == FlightState.START
    assert wire.robot.faults["armed without motor_info and uav_info: not acknowledged"] > 0


def test_a_forced_landing_of_the_flight_controller_is_the_pilots_too() -> None:
    wire = Wire()
    for _ in range(30):
        wire.tick()
    wire.tick("teleop_command/start")
    wire.until(FlightState.ARM_ON, 1.0)
    wire.tick("teleop_command/takeoff")
    for _ in range(300):
        wire.tick()
    assert wire.pilot.pilot.flying.in_air
    wire.down.append(Outgoing(topics.FOUR_AXES, FourAxes((0.0, 1.1, 0.0), (9.0,) * 4)))
    wire.tick()
    wire.tick()
    assert wire.pilot.pilot.flying.force_landing
    assert "force landing: by the flight controller" in wire.said
    assert wire.robot.faults["forced landing: commanded, or tilted by more than 1 rad"] == 1


@pytest.mark.parametrize(
    "files",
    [pytest.param(("motor_info.yaml",), marks=pytest.mark.slow), ("motor_info.yaml", "servo.yaml")],
)
def test_controller_and_simulator_fly_over_the_labs_topics(files: tuple[str, ...]) -> None:
    wire = Wire(files)
    wire.hover()
    for _ in range(400):
        wire.tick()
    assert wire.pilot.last is not None
    assert wire.pilot.last.body is not None
    assert wire.pilot.last.body.cog[2] == pytest.approx(0.6, abs=0.1)
    by_name, by_count = (
        ("joints_ctrl", "gimbals_ctrl", "joint_states"),
        ("servo/states", "servo/target_states"),
    )
    spoken, silent = (by_count, by_name) if len(files) == 2 else (by_name, by_count)
    assert all(wire.names[name] > 100 for name in spoken)
    assert not any(wire.names[name] for name in silent)
    assert wire.names["desire_coordinate"] > 10
    # Motors and servos are published before arming only.
    assert 0 < wire.names["motor_info"] < 20
    wire.silent = True
    for _ in range(140):
        wire.tick()
    assert wire.pilot.last.flying.force_landing
    wire.silent = False
    wire.until(FlightState.ARM_OFF, 30.0)
    # Servos that still move may lift it by less than anybody sees.
    assert wire.robot.plant.truth().position[2] == pytest.approx(STAND, abs=1e-3)
    assert [kept.name for kept in wire.pilot.kept] == ["flight"]


def test_the_labs_axes_at_the_centre_of_gravity_have_the_yaw_of_its_link() -> None:
    wire = Wire()
    for _ in range(20):
        wire.tick()
    odometry = {topic.name: value for topic, value in wire.pilot.tick([], 0.0) if "odom" in topic.name}
    # Both are published on even ticks only.
    odometry |= {topic.name: value for topic, value in wire.pilot.tick([], 0.0) if "odom" in topic.name}
    yaws = []
    for name in ("uav/cog/odom", "uav/baselink/odom"):
        w, x, y, z = odometry[name]["pose.pose.orientation"]
        yaws.append(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))
    assert yaws[0] == pytest.approx(yaws[1], abs=0.01)
