"""What has failed on the robot: rotors that lost thrust, servos that gave way, frames that come later."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from skylimb.control.estimation.gates import over
from skylimb.control.estimation.lateness import lateness, stamped
from skylimb.control.estimation.momentum_observer import ObserverState
from skylimb.control.estimation.records import BodyState
from skylimb.control.estimation.rotor_loss import Loss, Seen, look
from skylimb.control.estimation.servos import watch_servos
from skylimb.control.supervisor.believed_pose import BelievedPose
from skylimb.control.supervisor.limits import Limits
from skylimb.control.supervisor.records import Watch
from skylimb.control.supervisor.suited_gains import MOST
from skylimb.control.supervisor.table import CUT, DESCEND
from skylimb.robots.model import Robot
from skylimb.symbolic import Array, abs, max, stack, where, within

LATE = 0.03
"""Age beyond the assumed latency at which a frame says nothing of the rotors any more, s."""

FASTER = 1.5
"""Speed of a joint that nothing holds, in those of its servo."""

DOUBT = 0.012
"""Age beside the believed one at which latency is looked at in contact, s."""

SETTLED, SHAKEN = 0.1, 0.3
"""Time for which a pose that comes back shakes the robot, s."""


class Health(NamedTuple):
    """What the robot lacks at a tick.

    Attributes:
        lost: what rotors seem to have lost.
        astray: 1 where a joint is not where its servo should have turned it.
    """

    lost: Seen
    astray: Any


def unexamined(watch: Watch, age: Any, pose: BelievedPose, dt: float) -> tuple[Watch, Health]:
    """Where nobody looks: all is as it was, and nothing is lost; frames are as late as their stamps say.

    Args:
        watch: of this tick, as far as it is known.
        age: of the frame that is seen, as its stamp says, s.
        pose: that is believed.
        dt: control period, s.
    """
    said, late = stamped(watch.stamped, age, pose.good, dt)
    watch = watch._replace(late=watch.late._replace(late=late), stamped=said)
    return watch, Health(Seen(0.0 * watch.loss.left, 0.0, 0.0, 0.0), 0.0)


def examined(
    robot: Robot,
    limits: Limits,
    watch: Watch,
    age: Any,
    pose: BelievedPose,
    body: BodyState,
    speeds: Array,
    dt: float,
) -> tuple[Watch, Health]:
    """Joints and rotors: where servos should have turned them, and what the loss of one rotor would explain.

    Args:
        robot: the model.
        limits: of what is believed.
        watch: of the tick before, with the prediction of this one.
        age: of the frame that is seen, as its stamp says, s.
        pose: that is believed.
        body: state of {C} by what is believed.
        speeds: of shape and vectoring angles, rad/s.
        dt: control period, s.
    """
    late, prediction, back = watch.late, watch.prediction, pose.clocks.back
    commanded = stack(watch.command.joint_angles, watch.command.vectoring_angles)
    servos, each = watch_servos(robot, watch.servos, commanded, prediction.angles, prediction.thrusts, dt)
    # Servos give way where thrusts change fast: without a rotor, as a pose comes back, or far too late.
    calm = within(watch.loss.left, 1.0, np.inf) * over(back, SHAKEN)
    each = each * calm * within(late.late, 0.0, MOST)
    astray = max(each) if each.shape[0] else 0.0
    loose = _loose(robot, watch, each, speeds)
    strayed = _strayed(robot, watch, each * (1.0 - loose))
    # A robot that swings, as frames are older than its model assumes, or that bends where nobody sent it,
    # looks like one without a rotor; so does one whose pose has just come back, or whose twist is the model's
    # as what is seen of it does not fit the poses.
    behind = limits.latency + late.late
    timely = within(age, 0.0, behind + LATE)
    good = pose.good * within(watch.twist.wrong, 0.0, 0.5)
    fresh = good * timely * (1.0 - astray) * over(back, SETTLED)
    found, lost = look(watch.loss, prediction.observer, body, prediction.thrusts, behind, fresh, dt)
    descending = within(watch.mode, DESCEND, CUT)
    settled = good * _tells_latency(limits, watch, age, lost) * over(back, SETTLED)
    said, torque = age - limits.latency, prediction.delay.wrenches[0][3:6]
    late = lateness(
        late, body, torque, limits.latency, limits.rotor_lag, said, settled, watch.asked.touch, dt
    )
    loss, observer = _given_up(limits, watch.loss, found, lost, descending, prediction.observer, body)
    prediction = prediction._replace(observer=observer)
    watch = watch._replace(
        prediction=prediction, loss=loss, servos=servos, loose=loose, strayed=strayed, late=late
    )
    return watch, Health(lost, astray)


def _tells_latency(limits: Limits, watch: Watch, age: Any, lost: Seen) -> Any:
    """1 where the robot's turning says how late it is measured.

    A touch or a lost rotor turns the robot otherwise than commanded, at any latency: in contact, and with
    a rotor that has lost too little to break the flight off, the stamps have to say that it has changed.
    """
    changed = over(abs(age - limits.latency - watch.late.late), DOUBT)
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


def _strayed(robot: Robot, watch: Watch, astray: Array) -> Any:
    """1 where a joint of the shape is astray; the arm stays another one as long as the robot descends."""
    if not robot.n_joints:
        return watch.strayed
    known = within(watch.mode, DESCEND, CUT) * watch.strayed
    return where(known > 0.5, 1.0, max(astray[: robot.n_joints]))


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
