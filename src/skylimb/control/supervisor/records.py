"""What the loop says to the supervisor, what it remembers, and what its first half hands to the second."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from skylimb.base.packing import Layout
from skylimb.control.estimation.gates import numbers, over
from skylimb.control.estimation.lateness import Lateness, Stamped
from skylimb.control.estimation.prediction import Prediction, initial_prediction
from skylimb.control.estimation.records import BodyState, Measurement, zero_measurement
from skylimb.control.estimation.rotor_loss import Loss, initial_loss
from skylimb.control.estimation.servos import Servos, initial_servos
from skylimb.control.estimation.twist_check import TwistCheck
from skylimb.control.missions.reference import Reference, zero_reference
from skylimb.control.records import Command
from skylimb.robots.model import Robot
from skylimb.symbolic import Array, within

MOST = 1e12
"""No number that is remembered is larger, but for those of a memory that somebody wrote into."""


class Flags(NamedTuple):
    """What the world around says at a tick; whoever flies writes it into the state.

    Attributes:
        pose: 1 where the pose is newer than the one before, as its stamp says.
        joints: 1 where the joint angles are.
        late: 1 where this tick came too late to ask the controller.
        land: 1 where the flight is to be broken off.
        stop: 1 where the motors are to stop.
    """

    pose: Any = 1.0
    joints: Any = 1.0
    late: Any = 0.0
    land: Any = 0.0
    stop: Any = 0.0


class Clocks(NamedTuple):
    """What time has passed.

    Attributes:
        mode: in this mode, s.
        broken: since the flight was broken off, s.
        unseen: since a pose was believed, s.
        usual: from one believed pose to the next, as they come, s.
        back: since the pose was the model's, s.
        unfelt: since joint angles were believed, s.
        untold: since any came, s.
        unheard: since the IMU that the controller goes by said anything new, s.
        same: since the measured pose changed, s.
        strange: for which poses that jump have agreed with one another, s.
        without: ticks since the controller commanded.
    """

    mode: Any = 0.0
    broken: Any = 0.0
    unseen: Any = 0.0
    usual: Any = 0.05
    back: Any = 1e3
    unfelt: Any = 0.0
    untold: Any = 0.0
    unheard: Any = 0.0
    same: Any = 0.0
    strange: Any = 0.0
    without: Any = 0.0


class Watch(NamedTuple):
    """What the supervisor remembers.

    Attributes:
        flags: of the tick to come.
        mode: number of the mode.
        started: 1 once a pose was believed.
        felt: 1 once joint angles were.
        clocks: since when.
        twist: whether velocity and rates fit the poses.
        before: measurement of the last tick, as it came.
        prediction: for the next one.
        loss: which rotor has lost thrust.
        servos: where they should have turned the joints.
        loose: 1 for each joint that its servo holds no more, shape and vectoring together, (n_joints + nv,).
        strayed: 1 where a shape joint goes elsewhere than it is sent, by its servo: it has not let go.
        axes: of the measured link, in which it is level, as they were before a part was lost, (3, 3).
        late: how late measurements are.
        stamped: what their stamps alone say of that.
        command: that was given last.
        asked: last reference of the mission, at which the flight was broken off.
    """

    flags: Flags
    mode: Any
    started: Any
    felt: Any
    clocks: Clocks
    twist: TwistCheck
    before: Measurement
    prediction: Prediction
    loss: Loss
    servos: Servos
    loose: Array
    strayed: Any
    axes: Array
    late: Lateness
    stamped: Stamped
    command: Command
    asked: Reference


class Sight(NamedTuple):
    """What `before` hands over: to the controller its measurement and reference, to `after` the rest.

    Attributes:
        measurement: that is believed.
        reference: that is to be flown.
        asks: 1 where the controller is asked.
        body: state of {C} by that measurement.
        faults: of pose and of angles, numbers as in `gates.FAULTS`.
        bits: of the table, by its order.
    """

    measurement: Measurement
    reference: Reference
    asks: Any
    body: BodyState
    faults: Array
    bits: Array


def initial_watch(robot: Robot, imu: bool = False) -> Watch:
    """Before the first tick: nothing is known, and the least is commanded.

    Args:
        robot: the model.
        imu: whether the controller works on what an IMU measures; else nobody gets it.
    """
    robot = robot.pairs
    low, psi = robot.thrust_limits()[0], np.clip(np.zeros(robot.n_vectoring), *robot.vectoring_limits())
    q = np.clip(robot.nominal_posture(), *robot.joint_limits())
    return Watch(
        flags=Flags(),
        mode=0.0,
        started=0.0,
        felt=0.0,
        clocks=Clocks(),
        twist=TwistCheck(),
        before=zero_measurement(robot.n_joints, robot.n_vectoring, imu),
        prediction=initial_prediction(robot, low),
        loss=initial_loss(robot.n_rotors),
        servos=initial_servos(robot),
        loose=np.zeros(robot.n_joints + robot.n_vectoring),
        strayed=0.0,
        axes=np.eye(3),
        late=Lateness(),
        stamped=Stamped(),
        command=Command(low, q, psi),
        asked=zero_reference(robot.n_joints, robot.n_vectoring),
    )


def sound(robot: Robot, watch: Watch) -> Watch:
    """What is remembered; numbers of a memory that was spoilt begin anew."""
    first = initial_watch(robot, watch.before.imu is not None)
    memory, flags = Layout(first), watch.flags
    found = memory.unpack(numbers(memory.pack(watch), memory.pack(first), MOST))
    # A flag is no memory: a number that is none says that nothing is new, and stops the motors.
    new = (within(one, 0.5, MOST) for one in (flags.pose, flags.joints))
    return found._replace(
        flags=Flags(*new, *(over(one, 0.5) for one in (flags.late, flags.land, flags.stop)))
    )
