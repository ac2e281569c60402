"""What is believed at a tick: the measurement, or in its place what the model shows."""

from __future__ import annotations

from typing import Any, NamedTuple

from skylimb.base.packing import chosen
from skylimb.control.estimation.body_state import body_state, seen_from
from skylimb.control.estimation.gates import BEYOND, angle_fault, over
from skylimb.control.estimation.prediction import differenced, parted, seen, shown
from skylimb.control.estimation.records import BodyState, Imu, Measurement
from skylimb.control.supervisor.believed_pose import believe_pose
from skylimb.control.supervisor.health import Health, examined, unexamined
from skylimb.control.supervisor.limits import Limits
from skylimb.control.supervisor.records import Watch
from skylimb.control.supervisor.table import CUT, DESCEND, RETREAT
from skylimb.robots.model import Robot
from skylimb.symbolic import Array, max, stack, where, within


class Belief(NamedTuple):
    """What a look comes to.

    Attributes:
        measurement: that is believed.
        body: state of {C} by it.
        faults: of pose and of angles, numbers as in `gates.FAULTS`.
        stale: 1 where the pose is the model's.
        speaks: 1 where there is an IMU that has said anything new of late.
        health: what the robot lacks.
    """

    measurement: Measurement
    body: BodyState
    faults: Array
    stale: Any
    speaks: Any
    health: Health


def believed(
    robot: Robot, limits: Limits, watch: Watch, measured: Measurement, dt: float
) -> tuple[Watch, Belief]:
    """Look at a measurement; its time goes on, and what is known goes into the prediction."""
    # Joints: their angles, or those that were believed last.
    angles = stack(measured.joint_angles, measured.vectoring_angles)
    # The gate widens while no angles come, not while a row of them jumps.
    missing, ways = watch.clocks.untold, angles - watch.prediction.angles
    wrong = angle_fault(limits, ways, robot.n_joints, missing, watch.felt)
    felt = within(wrong, 0.0, 0.5) * watch.flags.joints
    angles = where(felt > 0.5, angles, watch.prediction.angles)
    prediction, speeds = differenced(watch.prediction, angles, dt)
    q, psi = parted(angles, robot.n_joints)

    # Body: its pose, or the model's, and what an IMU says.
    predicted = shown(prediction, robot.at(q, psi), robot.n_joints, speeds)
    pose = believe_pose(limits, watch, measured, predicted, dt)
    imu, unheard, speaks = _heard(limits, measured.imu, watch.before.imu, watch.clocks.unheard + dt)
    measured = measured._replace(imu=imu)
    belief = pose.measurement._replace(imu=imu, joint_angles=q, vectoring_angles=psi)
    body = body_state(robot, belief, speeds)
    if limits.losses:
        watch, body = _upright(watch, body)
    # Friction is that of a mission: who is broken off leaves the surface.
    touches = watch.asked.touch * within(watch.mode, 0.0, RETREAT - 0.5)
    poses = stack(1.0 - pose.stale, pose.changed)
    prediction = seen(prediction, belief, body, speeds, touches * watch.asked.contact_axis, poses, dt)

    # What has failed on it.
    watch, age = watch._replace(prediction=prediction), measured.capture_age
    watch, health = (
        examined(robot, limits, watch, age, pose, body, speeds, dt)
        if limits.losses
        else unexamined(watch, age, pose, dt)
    )
    unfelt = where(felt > 0.5, 0.0, watch.clocks.unfelt + dt)
    untold = where(watch.flags.joints > 0.5, 0.0, watch.clocks.untold + dt)
    watch = watch._replace(
        started=pose.started,
        felt=where(watch.felt + felt > 0.5, 1.0, 0.0),
        clocks=pose.clocks._replace(unfelt=unfelt, untold=untold, unheard=unheard),
        twist=pose.twist,
        before=measured,
    )
    faults = stack(pose.fault, wrong)
    return watch, Belief(belief, body, faults, 1.0 - pose.good, speaks, health)


def _upright(watch: Watch, body: BodyState) -> tuple[Watch, BodyState]:
    """A robot whose vectoring angles make up for a part that is lost or astray keeps the axes that it had."""
    lost = max(stack(watch.strayed, watch.loose, where(watch.loss.left > 0.0, 0.0, 1.0)))
    keeps = lost * within(watch.mode, DESCEND, CUT)
    axes = where(keeps > 0.5, watch.axes, body.model.R_root_C)
    return watch._replace(axes=axes), chosen(keeps > 0.5, seen_from(body, axes), body)


def _heard(limits: Limits, said: Imu | None, last: Imu | None, silent: Any) -> tuple[Imu | None, Any, Any]:
    """What an IMU says, or said last; since when it says nothing new; and 1 where that is not for long.

    Args:
        limits: when it counts as silent.
        said: by it at this tick; None where there is none.
        last: likewise, at the tick before.
        silent: since when, where this tick brings nothing new, s.
    """
    if said is None or last is None:
        return last, 0.0, 0.0
    heard = chosen(within(stack(*said), -BEYOND, BEYOND) > 0.5, said, last)
    unheard = where(within(stack(*heard) - stack(*last), 0.0, 0.0) > 0.5, silent, 0.0)
    return heard, unheard, 1.0 - over(unheard, limits.deaf_after)
