"""What is believed at a tick: the measurement, or in its place what the model shows."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from skylimb.base.packing import chosen
from skylimb.control.estimation.gates import (
    BEYOND,
    angle_fault,
    over,
    pose_fault,
    relocked,
    same_pose,
)
from skylimb.control.estimation.lateness import lateness
from skylimb.control.estimation.momentum_observer import ObserverState
from skylimb.control.estimation.prediction import differenced, parted, seen, shown
from skylimb.control.estimation.records import BodyState, Imu, Measurement
from skylimb.control.estimation.rotor_loss import Loss, Seen, look
from skylimb.control.estimation.servos import watch_servos
from skylimb.control.late_gains import MOST
from skylimb.control.supervisor.limits import Limits
from skylimb.control.supervisor.records import Watch
from skylimb.control.supervisor.table import CUT, DESCEND
from skylimb.robots.model import Robot
from skylimb.symbolic import Array, abs, clip, max, stack, where, within

UNSEEN = 1e6
"""Age of a frame that is not seen, s."""

LATE = 0.03
"""Age beyond the assumed latency at which a frame says nothing of the rotors any more, s."""

FASTER = 1.5
"""Speed of a joint that nothing holds, in those of its servo."""

DOUBT = 0.012
"""Age beside the believed one at which latency is looked at in contact, s."""

FRAMES = 2.0
"""Usual ways from one pose to the next for which none has to come: one frame may be missed."""

USUAL, LONGEST = 0.1, 0.05
"""Share of the newest way in the usual one, and the longest that is learnt from, s."""

SETTLED, SHAKEN = 0.1, 0.3
"""Time for which a pose that comes back shakes the robot, s."""


class Belief(NamedTuple):
    """What a look comes to.

    Attributes:
        measurement: that is believed.
        body: state of {C} by it.
        faults: of pose and of angles, numbers as in `gates.FAULTS`.
        stale: 1 where the pose is the model's.
        speaks: 1 where there is an IMU that has said anything new of late.
        lost: what rotors seem to have lost.
        astray: 1 where a joint is not where its servo should have turned it.
    """

    measurement: Measurement
    body: BodyState
    faults: Array
    stale: Any
    speaks: Any
    lost: Seen
    astray: Any


def believed(
    robot: Robot, limits: Limits, watch: Watch, measured: Measurement, dt: float
) -> tuple[Watch, Belief]:
    """Look at a measurement; its time goes on, and what is known goes into the prediction."""
    told, clocks, prediction = watch.told, watch.clocks, watch.prediction
    # Joints: their angles, or those that were believed last.
    angles = stack(measured.joint_angles, measured.vectoring_angles)
    wrong = angle_fault(limits, angles - prediction.angles)
    felt = within(wrong, 0.0, 0.5) * told.joints
    angles = where(felt > 0.5, angles, prediction.angles)
    prediction, speeds = differenced(prediction, angles, dt)
    q, psi = parted(angles, robot.n_joints)
    # Pose: as measured where that is near to what the model says, or where a row of them agrees.
    predicted = shown(prediction, robot.at(q, psi), robot.n_joints, speeds)
    # The gate widens while no pose comes, not while a row of them jumps: that would believe it in the end.
    fault = pose_fault(limits, measured, predicted, clocks.unseen - clocks.strange, watch.started)
    fault, strange = relocked(
        limits, fault, clocks.strange, measured, watch.before, predicted, clocks.unseen, dt
    )
    same = where(same_pose(measured, watch.before) > 0.5, clocks.same + dt, 0.0)
    frozen = over(same, limits.frozen_after)
    new = within(fault, 0.0, 0.5) * (1.0 - frozen) * told.pose
    # A pose that stays as it is was not seen since it came.
    unseen = where(new > 0.5, 0.0, max(clocks.unseen + dt, frozen * same))
    unfelt = where(felt > 0.5, 0.0, clocks.unfelt + dt)
    came = clip(clocks.unseen + dt, 0.0, LONGEST)
    usual = where(new > 0.5, clocks.usual + USUAL * (came - clocks.usual), clocks.usual)
    stale = over(unseen, max(limits.stale_after, FRAMES * usual))
    # An old pose is good until it is stale, as frames come more slowly than ticks.
    good = within(fault, 0.0, 0.5) * (1.0 - stale)
    back = where(stale * watch.started > 0.5, 0.0, clocks.back + dt)
    pose = {
        name: where(good > 0.5, getattr(measured, name), getattr(predicted, name))
        for name in Measurement._fields[:4]
    }
    # Where the pose is the model's, no frame is seen: who has an IMU goes on by that.
    age = where(good * within(measured.capture_age, 0.0, UNSEEN) > 0.5, measured.capture_age, UNSEEN)
    imu, unheard, speaks = _heard(limits, measured.imu, watch.before.imu, clocks.unheard + dt)
    measured = measured._replace(imu=imu)
    belief = measured._replace(joint_angles=q, vectoring_angles=psi, capture_age=age, **pose)
    prediction, body = seen(robot, prediction, belief, speeds, stale, dt)
    # Joints and rotors: where servos should have turned them, and what the loss of one rotor would explain.
    servos, astray, loose = watch.servos, 0.0, watch.loose
    late, loss, lost = watch.late, watch.loss, Seen(0.0 * watch.loss.left, 0.0, 0.0, 0.0)
    if limits.losses:
        commanded = stack(watch.command.joint_angles, watch.command.vectoring_angles)
        servos, each = watch_servos(robot, servos, commanded, angles, prediction.thrusts, dt)
        # Servos give way where thrusts change fast: without a rotor, as a pose comes back, or far too late.
        calm = within(watch.loss.left, 1.0, np.inf) * over(back, SHAKEN)
        each = each * calm * within(late.late, 0.0, MOST)
        astray = max(each) if each.shape[0] else 0.0
        loose = _loose(robot, watch, each, speeds)
        # A robot that swings, as frames are older than its model assumes, or that bends where nobody sent it,
        # looks like one without a rotor; so does one whose pose has just come back.
        timely = within(measured.capture_age, 0.0, limits.latency + late.late + LATE)
        fresh = good * timely * (1.0 - astray) * over(back, SETTLED)
        behind = limits.latency + late.late
        found, lost = look(loss, prediction.observer, body, prediction.thrusts, behind, fresh, dt)
        descending = within(watch.mode, DESCEND, CUT)
        settled = good * _tells_latency(limits, watch, measured, lost) * over(back, SETTLED)
        said, torque = measured.capture_age - limits.latency, prediction.delay.wrenches[0][3:6]
        late = lateness(
            late, body, torque, limits.latency, limits.rotor_lag, said, settled, watch.asked.touch, dt
        )
        loss, observer = _given_up(limits, loss, found, lost, descending, prediction.observer, body)
        prediction = prediction._replace(observer=observer)
    watch = watch._replace(
        started=where(watch.started + new > 0.5, 1.0, 0.0),
        clocks=clocks._replace(
            unseen=unseen,
            usual=usual,
            back=back,
            unfelt=unfelt,
            unheard=unheard,
            same=same,
            strange=strange,
        ),
        before=measured,
        prediction=prediction,
        loss=loss,
        servos=servos,
        loose=loose,
        late=late,
    )
    return watch, Belief(belief, body, stack(fault, wrong), 1.0 - good, speaks, lost, astray)


def _tells_latency(limits: Limits, watch: Watch, measured: Measurement, lost: Seen) -> Any:
    """1 where the robot's turning says how late it is measured.

    A touch or a lost rotor turns the robot otherwise than it is told to, at any latency: in contact, and with
    a rotor that has lost too little to break the flight off, the stamps have to say that it has changed.
    """
    changed = over(abs(measured.capture_age - limits.latency - watch.late.late), DOUBT)
    asked = where(changed + within(watch.asked.touch, 0.0, 0.5) > 0.5, 1.0, 0.0)
    most = where(changed > 0.5, limits.lossy, 0.0)
    return asked * within(lost.lost, 0.0, most) * within(watch.loss.left, 1.0 - most, np.inf)


def _loose(robot: Robot, watch: Watch, astray: Array, speeds: Array) -> Array:
    """Joints that are astray, those of the shape if they are faster than a servo turns them: it has let go.

    The first ones are kept.
    """
    if not astray.shape[0]:
        return watch.loose
    least = np.zeros(robot.n_joints + robot.n_vectoring)
    least[: robot.n_joints] = FASTER * robot.description.shape_servos.speed_limit
    known = within(watch.mode, DESCEND, CUT) * over(max(watch.loose), 0.5)
    return where(known > 0.5, watch.loose, astray * where(abs(speeds) >= least, 1.0, 0.0))


def _given_up(
    limits: Limits,
    last: Loss,
    found: Loss,
    lost: Seen,
    descending: Any,
    observer: ObserverState,
    body: BodyState,
) -> tuple[Loss, ObserverState]:
    """A rotor that is lost has nothing left, and what its thrust seemed to be was no push.

    A loss for which the flight is broken off is believed at once: it may be felt for that moment only. Once a
    robot descends, what is felt is the descent: nobody looks any more.
    """
    dead = over(lost.sure, limits.dead)
    gone = dead * (1.0 - descending)
    left = where(over(lost.lost, limits.lossy) > 0.5, 1.0 - lost.shares, found.left)
    left = where(descending > 0.5, last.left, where(dead * lost.shares > limits.dead, 0.0, left))
    force = where(gone > 0.5, body.R_WC @ found.mean[:3], observer.force)
    torque = where(gone > 0.5, found.mean[3:], observer.torque)
    return found._replace(left=left), observer._replace(force=force, torque=torque)


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
