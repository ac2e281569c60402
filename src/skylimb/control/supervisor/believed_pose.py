"""Whether the measured pose is believed at a tick, and how old what is believed is."""

from __future__ import annotations

from typing import Any, NamedTuple

from skylimb.control.estimation.gates import over, pose_fault, relocked, same_pose
from skylimb.control.estimation.lateness import UNSEEN
from skylimb.control.estimation.records import Measurement
from skylimb.control.estimation.twist_check import TwistCheck, check_twist
from skylimb.control.supervisor.limits import Limits
from skylimb.control.supervisor.records import Clocks, Watch
from skylimb.symbolic import clip, max, where, within

FRAMES = 2.0
"""Usual ways from one pose to the next for which none has to come: one frame may be missed."""

USUAL, LONGEST = 0.1, 0.05
"""Share of the newest way in the usual one, and the longest that is learnt from, s."""


class BelievedPose(NamedTuple):
    """What is believed of a pose.

    Attributes:
        measurement: with the pose as measured, or the model's in its place.
        fault: of the pose, a number as in `gates.FAULTS`.
        good: 1 where it is the measured one.
        changed: 1 where that is another one than before.
        stale: 1 where no pose was believed for too long.
        started: 1 once one was.
        clocks: of this tick, as far as they are of poses.
        twist: whether velocity and rates fit the poses.
    """

    measurement: Measurement
    fault: Any
    good: Any
    changed: Any
    stale: Any
    started: Any
    clocks: Clocks
    twist: TwistCheck


def believe_pose(
    limits: Limits, watch: Watch, measured: Measurement, predicted: Measurement, dt: float
) -> BelievedPose:
    """The pose as measured where that is near to what the model says, or where a row of them agrees.

    Args:
        limits: of what is believed.
        watch: of the tick before, and what the world around says of this one.
        measured: at this tick.
        predicted: what the model says that it should be.
        dt: control period, s.
    """
    clocks = watch.clocks
    # The gate widens while no pose comes, not while a row of them jumps: that would believe it in the end.
    fault = pose_fault(limits, measured, predicted, clocks.unseen - clocks.strange, watch.started)
    fault, strange = relocked(
        limits, fault, clocks.strange, measured, watch.before, predicted, clocks.unseen, dt
    )
    kept = same_pose(measured, watch.before)
    same = where(kept > 0.5, clocks.same + dt, 0.0)
    frozen = over(same, limits.frozen_after)
    new = within(fault, 0.0, 0.5) * (1.0 - frozen) * watch.flags.pose
    # A pose that stays as it is was not seen since it came.
    unseen = where(new > 0.5, 0.0, max(clocks.unseen + dt, frozen * same))
    came = clip(clocks.unseen + dt, 0.0, LONGEST)
    usual = where(new > 0.5, clocks.usual + USUAL * (came - clocks.usual), clocks.usual)
    stale = over(unseen, max(limits.stale_after, FRAMES * usual))
    # An old pose is good until it is stale, as frames come more slowly than ticks.
    good = within(fault, 0.0, 0.5) * (1.0 - stale)
    back = where(stale * watch.started > 0.5, 0.0, clocks.back + dt)
    sane, changed = within(fault, 0.0, 0.5), good * (1.0 - kept)
    twist, velocity, rates = check_twist(
        limits, watch.twist, measured, watch.before, predicted, sane, changed, watch.started, dt
    )
    sensed = measured._replace(velocity=velocity, angular_velocity=rates)
    pose = {
        name: where(good > 0.5, getattr(sensed, name), getattr(predicted, name))
        for name in Measurement._fields[:4]
    }
    # Where the pose is the model's, no frame is seen: who has an IMU goes on by that.
    age = where(good * within(measured.capture_age, 0.0, UNSEEN) > 0.5, measured.capture_age, UNSEEN)
    started = where(watch.started + new > 0.5, 1.0, 0.0)
    clocks = clocks._replace(unseen=unseen, usual=usual, back=back, same=same, strange=strange)
    believed = measured._replace(capture_age=age, **pose)
    return BelievedPose(believed, fault, good, changed, stale, started, clocks, twist)
