"""The bits of the table: sizes and times that are beyond their limits. What is no number is beyond all."""

from __future__ import annotations

from math import sin
from typing import Any

from skylimb.control.estimation.gates import over
from skylimb.control.supervisor.belief import Belief
from skylimb.control.supervisor.descents import Descents
from skylimb.control.supervisor.limits import Limits
from skylimb.control.supervisor.records import Watch
from skylimb.control.supervisor.retreat import DESCENT
from skylimb.control.supervisor.suited_gains import MOST
from skylimb.control.supervisor.table import DESCEND
from skylimb.symbolic import max, norm, where, within


def bits_of(limits: Limits, descents: Descents, watch: Watch, belief: Belief) -> dict[str, Any]:
    """1 or 0 of every bit, by its name in the table.

    Args:
        limits: when the supervisor acts.
        descents: for the loss of each rotor.
        watch: that knows the belief, in the mode of the tick before.
        belief: of this tick.
    """
    flags, clocks = watch.flags, watch.clocks
    # By its IMU a robot finds back and down for a while.
    blind = clocks.unseen - belief.speaks * limits.imu_for
    unseen = over(clocks.unseen, limits.retreat_after) * watch.started
    fresh = within(belief.stale, 0.0, 0.5) * watch.started
    way = max(watch.asked.position[2] - limits.floor, 0.0)
    # Of the link that is measured: {C} turns with the vectoring angles, far where a rotor is lost.
    lean = norm(belief.measurement.quaternion[1:3])  # sine of half its angle
    return {
        "stop": over(flags.stop, 0.5),
        "land": where(belief.speaks * unseen + over(flags.land, 0.5) > 0.5, 1.0, 0.0),
        "lost": over(blind, limits.cut_after) * watch.started,
        "blind": over(blind, limits.retreat_after) * watch.started,
        "stale": belief.stale,
        "dead": over(belief.health.lost.sure, limits.dead),
        "doomed": over(belief.health.lost.sure, limits.dead) * descents.missing(watch.loss.left),
        "lossy": over(belief.health.lost.lost, limits.lossy),
        "pushed": belief.health.lost.pushed,
        "astray": over(belief.health.astray, 0.5) * watch.started,
        "behind": over(watch.late.late, MOST),
        "numb": over(clocks.unfelt, limits.retreat_after),
        "deaf": over(clocks.unheard, limits.deaf_after) * watch.started,
        "silent": over(clocks.without, float(limits.overruns)),
        "late": where(over(flags.late, 0.5) + over(clocks.without, 0.0) > 0.5, 1.0, 0.0),
        "spent": over(clocks.mode - way / DESCENT, limits.descend_for) * within(watch.mode, DESCEND, DESCEND),
        # How far a pose leans that is the model's is nothing to stop rotors for.
        "unfit": over(watch.twist.wrong, 0.5),
        "upset": over(lean, sin(0.5 * limits.upset_at)) * fresh,
    }
