"""The supervisor's tick: detect, look up, act, clip.

    measurement -> before: belief, bits, table, reference -> controller -> after: command or another, limits

It may hand the controller another measurement and another reference, and command in its place. Both halves
are pure, on numbers and on symbols: the same lines fly in simulation, on a robot and as exported C. A robot
of two or three rotors is watched as its robot of pairs (`control.thrust_and_angle`).
"""

from __future__ import annotations

from typing import Any

from skylimb.base.packing import chosen
from skylimb.control.allocation.rotor_lag import time_constants
from skylimb.control.estimation.gates import BEYOND, numbers
from skylimb.control.estimation.prediction import moved
from skylimb.control.estimation.records import Measurement
from skylimb.control.missions.reference import Reference
from skylimb.control.records import Command
from skylimb.control.supervisor.belief import believed
from skylimb.control.supervisor.bits import bits_of
from skylimb.control.supervisor.descents import Descents
from skylimb.control.supervisor.limits import Limits
from skylimb.control.supervisor.records import Flags, Sight, Watch, sound
from skylimb.control.supervisor.reserve import instead
from skylimb.control.supervisor.retreat import aimed, turned_to
from skylimb.control.supervisor.table import CUT, DESCEND, RETREAT, TABLE
from skylimb.control.thrust_and_angle import as_pairs, from_pairs, with_angles, without_angles
from skylimb.robots.model import Robot
from skylimb.symbolic import clip, stack, where, within

LEAST_SHARE = 0.3
"""Of its thrust, that a rotor is believed to have while the controller flies."""


def before(
    robot: Robot,
    limits: Limits,
    descents: Descents,
    watch: Watch,
    measured: Measurement,
    reference: Reference,
    dt: float,
) -> tuple[Watch, Sight]:
    """Look, and decide what the controller is given.

    Args:
        robot: the model.
        limits: when the supervisor acts.
        descents: for the loss of each rotor.
        watch: what is remembered.
        measured: as it came, whatever it is.
        reference: of the mission.
        dt: control period, s.
    """
    as_measured, as_asked, pairs = measured, reference, robot.pairs
    measured, reference = without_angles(robot, measured), without_angles(robot, reference)
    watch, belief = believed(pairs, limits, sound(pairs, watch), measured, dt)
    found = bits_of(limits, descents, watch, belief)
    mode = TABLE.decided(watch.mode, found)
    watch, flown, aims = aimed(watch, mode, reference, limits.floor, dt)
    near = turned_to(pairs, belief.body, flown)
    # Who flies by an IMU knows its heading, while the model's goes astray.
    known = within(mode, RETREAT - 0.5, CUT) * (1.0 - belief.stale * belief.speaks)
    flown = chosen(known > 0.5, near, flown)
    clocks = watch.clocks._replace(mode=where(mode == watch.mode, watch.clocks.mode + dt, 0.0))
    asks = watch.started * within(mode, 0.0, DESCEND - 0.5) * within(watch.flags.late, 0.0, 0.5) * aims
    bits = stack(*(found[name] for name in TABLE.bits))
    seen = with_angles(robot, belief.measurement, as_measured)
    flown = with_angles(robot, flown, as_asked)
    sight = Sight(seen, flown, asks, belief.body, belief.faults, bits)
    return watch._replace(mode=mode, clocks=clocks), sight


def after(
    robot: Robot,
    limits: Limits,
    descents: Descents,
    watch: Watch,
    sight: Sight,
    wanted: Command,
    whole: Any,
    dt: float,
) -> tuple[Watch, Command, Any]:
    """Take the controller's command, or another one in its place; within limits in any case.

    Args:
        robot: the model.
        limits: when the supervisor acts.
        descents: for the loss of each rotor.
        watch: of `before`.
        sight: of `before`.
        wanted: what the controller commands.
        whole: 1 where nothing else that it made is no number.
        dt: control period, s.

    Returns:
        What is remembered, the command, and 1 where it is the controller's.
    """
    pairs, wanted = robot.pairs, as_pairs(robot, wanted)
    seen, asked = without_angles(robot, sight.measurement), without_angles(robot, sight.reference)
    sight = sight._replace(measurement=seen, reference=asked)
    made = sight.asks * whole * within(stack(*wanted), -BEYOND, BEYOND)
    clocks = watch.clocks._replace(without=where(made > 0.5, 0.0, watch.clocks.without + 1.0))
    watch = watch._replace(clocks=clocks)
    own = wanted
    if limits.losses:
        # What the controller believes to be made of its command is made, as far as the rotor can.
        own = wanted._replace(thrusts=wanted.thrusts / clip(watch.loss.left, LEAST_SHARE, 1.0))
    command = chosen(made > 0.5, own, instead(pairs, limits, descents, watch, sight, dt))
    bounds = pairs.thrust_limits(), pairs.joint_limits(), pairs.vectoring_limits()
    parts = zip(command, watch.command, bounds, strict=True)
    command = Command(*(clip(numbers(part, last), *limit) for part, last, limit in parts))
    prediction = moved(
        watch.prediction,
        sight.body,
        command.thrusts,
        where(within(watch.mode, DESCEND, CUT) > 0.5, watch.loss.left, 1.0 + 0.0 * watch.loss.left),
        limits.latency + watch.late.late,
        time_constants(pairs, limits.rotor_lag + watch.late.slow),
        dt,
    )
    watch = watch._replace(flags=Flags(), prediction=prediction, command=command)
    return watch, from_pairs(robot, command), made
