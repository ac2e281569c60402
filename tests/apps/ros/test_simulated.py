"""The robot that the lab's stack flies, without ROS: what it says besides its sensors, and for how long."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from skylimb.analysis.exchange import lab_topics as topics
from skylimb.analysis.exchange.frames import lab_link
from skylimb.analysis.exchange.lab_topics import Topic
from skylimb.analysis.exchange.messages import FourAxes, Gains, ServoTargets, ServoTorques, UavInfo
from skylimb.apps.ros.lab_config import read_lab_config
from skylimb.apps.ros.messages import Arrived
from skylimb.apps.ros.simulated import MAGNETIC_FIELD, VOLTS, Simulated
from skylimb.base.errors import ConfigError
from skylimb.base.rotations import rotation_from_quaternion
from skylimb.flight.drivers.hooks import moving
from skylimb.flight.experiments.experiment import load_experiment
from skylimb.flight.realtime.pacer import stepped
from skylimb.flight.takeoff import Takeoff, take_off
from wired import LAB

PERIOD, CELLS = 0.005, 6


def made(**more: Any) -> Takeoff:
    asked = {"controller_rate": 1000.0, "sensors.imu.on": True, "phases.hover": 0.1}
    return take_off("free_flight", ("pid",), set=asked | more)[0]


@pytest.fixture(scope="module")
def takeoff() -> Takeoff:
    return made()


class Bench:
    """A simulated robot on a clock of its own, and what it last said on each topic."""

    def __init__(self, takeoff: Takeoff, **more: Any) -> None:
        self.config = read_lab_config(
            [LAB / name for name in ("motor_info.yaml", "servo.yaml")], takeoff.robot
        )
        pacer = stepped(PERIOD)
        pacer.start()
        self.robot = Simulated(takeoff, lab_link(takeoff.robot), pacer, CELLS, self.config.servos, **more)
        self._pacer, self._k, self.said = pacer, 0, dict[str, Any]()

    def tick(self, count: int, *messages: tuple[Topic, Any]) -> None:
        for k in range(count):
            self._pacer.wait(self._k)
            now = self._pacer.time()
            heard = [Arrived(topic.name, value, "test", now) for topic, value in messages] if k == 0 else []
            self.said |= {topic.name: value for topic, value in self.robot.tick(heard, now)}
            self._k += 1

    def arm(self) -> None:
        self.tick(1, (topics.UAV_INFO, UavInfo(4, 17)), (topics.MOTOR_INFO, self.config.motors))
        self.tick(1, (topics.CONFIG, 0))


def test_the_board_says_its_terms_and_its_duties(takeoff: Takeoff) -> None:
    bench = Bench(takeoff)
    bench.tick(1)
    assert bench.said["motor_pwms"].duties == (1000,) * 4
    bench.arm()
    gains = Gains(((1000, 0, 200, 500, 0, 100, 300),) * 4)
    thrusts = (2.0, 3.0, 4.0, 5.0)
    bench.tick(40, (topics.GAINS, gains), (topics.FOUR_AXES, FourAxes((0.1, -0.1, 0.0), thrusts)))
    term = bench.said["rpy/pid"].motors[0]
    # It stands level, as its feet have it: by the roll and pitch of the controlled axes, which nobody said.
    spinal = bench.robot._spinal
    assert spinal.terms is not None
    p, i, d = 1e3 * spinal.terms[:, 0]
    np.testing.assert_allclose(term, [p[0], i[0], d[0], p[1], i[1], d[1], d[2]], atol=1.0)
    assert abs(term[0] - 100) < 60
    duties, volts = np.array(bench.said["motor_pwms"].duties), VOLTS * CELLS
    assert spinal.thrusts is not None
    assert bench.config.motors is not None
    expected = 2000.0 * np.array(bench.config.motors.duties(spinal.thrusts.tolist(), volts))
    np.testing.assert_allclose(duties, expected, atol=1.0)
    assert np.all(np.diff(duties) > 0)


@pytest.mark.parametrize(
    ("conversion", "polynomial"), [(0, (0.0, -5.342, 0.0976, 0.0, 0.0)), (1, (50.0, 20.0, -3.0, 0.2, 0.0))]
)
def test_duties_are_those_of_the_labs_table(takeoff: Takeoff, conversion: int, polynomial: Any) -> None:
    """The board's two ways back from a thrust; a lower voltage asks for more, up to the greatest duty."""
    motors = Bench(takeoff).config.motors
    assert motors is not None
    motors = replace(
        motors, conversion=conversion, motors=(replace(motors.motors[0], polynomial=polynomial),)
    )
    volts = motors.motors[0].voltage
    (duty,) = motors.duties((10.0,), volts)
    if conversion:
        x = 0.1 * 10.0
        assert 100.0 * duty == pytest.approx(sum(c * x**n for n, c in enumerate(polynomial)))
    else:
        percent = 100.0 * duty
        thrust = (polynomial[2] * percent**2 + polynomial[1] * percent) / 10.0
        assert thrust == pytest.approx(10.0)
    assert motors.duties((10.0,), 0.9 * volts)[0] > duty
    assert motors.duties((1e3,), volts) == (motors.max_pwm,)


def test_the_compass_shows_north_in_the_boards_axes(takeoff: Takeoff) -> None:
    bench = Bench(takeoff)
    bench.tick(3)
    imu = bench.said["imu"]
    x, y, z, w = imu.quaternion_xyzw
    R = np.asarray(rotation_from_quaternion(np.array([w, x, y, z])))
    # By the board's own filter, of noisy rates and forces, within some milliradians.
    np.testing.assert_allclose(R @ imu.magnetic_field, MAGNETIC_FIELD, atol=0.01)
    body = bench.robot._bodies.of(bench.robot.plant.truth())
    np.testing.assert_allclose(body.R_W_link @ imu.magnetic_field, MAGNETIC_FIELD, atol=1e-3)
    assert np.abs(R - body.R_W_link).max() < 0.01
    bench.tick(400)
    x, y, z, w = bench.said["imu"].quaternion_xyzw
    R = np.asarray(rotation_from_quaternion(np.array([w, x, y, z])))
    assert np.abs(R - bench.robot._bodies.of(bench.robot.plant.truth()).R_W_link).max() < 0.02


def test_a_servo_without_torque_is_limp_until_it_is_switched_on(takeoff: Takeoff) -> None:
    bench = Bench(takeoff)
    numbers, servos = bytes([0]), bench.config.servos
    assert servos is not None
    target = (topics.SERVO_TARGETS, ServoTargets(numbers, (servos.counts({"joint1": 0.6})[0],)))

    def joint() -> float:
        return float(bench.robot.plant.truth().joint_angles[0])

    bench.tick(200, (topics.SERVO_TORQUE, ServoTorques(numbers, bytes([0]))), target)
    assert joint() > 0.9  # where it stood, less what its spring held
    bench.tick(300, (topics.SERVO_TORQUE, ServoTorques(numbers, bytes([1]))))
    assert joint() == pytest.approx(0.6, abs=0.05)
    # Numbers of nobody are left alone.
    bench.tick(1, (topics.SERVO_TORQUE, ServoTorques(bytes([99]), bytes([0]))))
    with pytest.raises(ValueError, match="2 switches for 1 servos"):
        ServoTorques(numbers, bytes([1, 1]))


def test_it_stands_as_it_is_told(takeoff: Takeoff) -> None:
    bench = Bench(takeoff, start={"joint1": 0.3, "gimbal2": -0.2})
    bench.tick(20)
    truth = bench.robot.plant.truth()
    assert truth.joint_angles[0] == pytest.approx(0.3, abs=0.1)
    assert truth.vectoring_angles[1] == pytest.approx(-0.2, abs=0.1)
    for start, words in (
        ({"joint9": 0.1}, "joint of --start 'joint9'"),
        ({"joint1": 3.0}, "--start joint1=3.0 is no angle within -1.57 and 1.57 rad"),
        ({"gimbal1": np.inf}, "--start gimbal1=inf is no angle"),
        ({"joint1": "bent"}, "--start joint1=bent is no angle"),
    ):
        with pytest.raises(ConfigError, match=re.escape(words)):
            Bench(takeoff, start=start)


def test_it_has_no_end() -> None:
    """Longer than its mission: what the sensors' noise is laid out for comes again."""
    takeoff = made(**{"posture.waypoints": [], "trajectory.duration": 0.2, "phases.hover_end": 0.1})
    bench = Bench(takeoff)
    laps = 2 * len(takeoff.rows.ticks) // round(PERIOD / takeoff.period) + 10
    bench.tick(laps)
    assert bench.robot.over == ""
    assert np.isfinite(bench.said["imu"].gyro).all()


def test_a_surface_moves_on_behind_what_is_laid_out() -> None:
    surface = load_experiment(
        "paper", {"surface.sway_amplitude": 0.05, "surface.sway_frequency": 0.7}
    ).surface
    times = 0.01 * np.arange(50)
    motion = moving(surface, times)
    for k in (0, 49, 50, 51, 149, 3):
        np.testing.assert_allclose(motion(k), np.ravel(surface.motion(0.01 * k)), atol=1e-12)


def test_its_time_is_the_plants_and_stands_on_the_clock(takeoff: Takeoff) -> None:
    """However long a tick takes, and whatever the middleware's clock says meanwhile."""
    bench, plain = Bench(takeoff, slows=True), Bench(takeoff)
    stamps = []
    for stamp in (100.0, 103.0, 50.0, 50.0):
        said = {one.topic.name: one.value for one in bench.robot.tick([], stamp)}
        stamps.append(said["/clock"]["clock"])
        assert said.get("imu", bench).stamp == stamps[-1]
    np.testing.assert_allclose(stamps, 100.0 + PERIOD * np.arange(4), atol=1e-9)
    # Where nobody lives by it, stamps are the middleware's and there is no clock.
    said = {one.topic.name: one.value for one in plain.robot.tick([], 103.0)}
    assert said["imu"].stamp == 103.0
    assert "/clock" not in said


def test_a_board_that_turns_the_rotors_itself_commands_the_gimbals(takeoff: Takeoff) -> None:
    """`gimbal_dof` = 1: each rotor's force has two components, x and z."""
    bench = Bench(takeoff)
    bench.tick(1, (topics.GIMBAL_DOF, 3), (topics.GIMBAL_DOF, 1), (topics.GIMBAL_DOF, 2))
    bench.arm()
    forces = np.tile([-2.0, 2.0], 4)
    bench.tick(60, (topics.FOUR_AXES, FourAxes((0.0, 0.0, 0.0), tuple(forces.tolist()))))
    spinal = bench.robot._spinal
    assert spinal.gimbal_dof == 1
    assert spinal.thrusts is not None
    np.testing.assert_allclose(spinal.thrusts, np.full(4, np.hypot(2.0, 2.0)))
    np.testing.assert_allclose(spinal.gimbals, np.full(4, np.pi / 4), atol=1e-6)
    np.testing.assert_allclose(bench.robot._angles[3:], spinal.gimbals)  # set points of the servos
    # Once armed it is what it is, and four rotors of three components have no room on the board.
    assert spinal.with_gimbals(2) is spinal
