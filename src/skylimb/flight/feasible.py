"""Can the robot hover, can it touch, can it do this task? Where it cannot, no flight begins.

- **Hover**: every nominal posture of the flight is held (`robots.equilibrium`) with `posture.margin` left.
- **Touch**: the tip is foremost along the contact axis.
- **This task**: the nominal posture holds the force that the controller commands, along the contact axis.
- **Reaction**: the attitude's loop is not too fast for rotors that work against their own change of speed.

A force along the surface's own normal, with the drag of its friction to every side, has to leave something
over for the flight: of flights that want more than 60 % of what the model holds, most do not keep their
force, and with earlier gains half were lost (docs/reports/scores.md has the count). Nobody knows slope and
friction of the surface before the flight, so what is believed of them is asked: the usual friction on a
surface across the contact axis refuses, the greatest friction and lean that are not ruled out warn.
"""

from __future__ import annotations

import dataclasses
import functools
import warnings
from typing import NamedTuple

import numpy as np

from skylimb.base.errors import ConfigError
from skylimb.base.rotations import rot_z
from skylimb.control.cascade import Cascade
from skylimb.control.controller import Controller
from skylimb.control.missions.frame import contact_frame
from skylimb.control.missions.posture import posture_plan
from skylimb.control.needs import Needs, needs_of
from skylimb.control.planning.hover_margins import hover_margins_function
from skylimb.control.planning.posture_limits import nearest_posture
from skylimb.control.planning.posture_path import PostureConfig
from skylimb.control.planning.vectoring import ONLINE, nominal_posture
from skylimb.control.planning.vectoring_step import RATE, planned_along
from skylimb.flight.events import GainChange
from skylimb.flight.experiments.experiment import Experiment
from skylimb.flight.reaction_check import require_slow_enough
from skylimb.robots.equilibrium import can_hold, greatest_push
from skylimb.robots.equilibrium_results import Held, Limit, NotHeld, Within
from skylimb.robots.hover import cannot_hover
from skylimb.robots.model import Robot
from skylimb.robots.touch import can_touch

DOUBTFUL_SHARE = 0.5
"""Of what can be held against slope and drag: up to here the force leaves enough over."""

REFUSED_SHARE = 0.6
"""Of the same: beyond this most flights do not keep their force, and earlier gains have lost the robot."""

Direction = tuple[float, ...]
"""In the level frame whose x axis is the heading, (3,)."""

_ROUNDING = 1e-9
"""Share of a force that is none."""

_SAME = 1e-3
"""Postures closer than this in every joint are one, rad."""


def require_feasible(experiment: Experiment, robot: Robot, controller: Controller) -> None:
    """Raise a `ConfigError` for what the robot cannot hold: its postures, and the controller's force.

    The vectoring angles are those that the flight begins with, or goes through; a controller that plans them
    in flight is rehearsed. A force counts with what events make of it. One that leaves too little over is
    refused as well: above `REFUSED_SHARE` of what can be held on the surface that is believed, unless
    `approach.doubtful` is "fly". Above `DOUBTFUL_SHARE` on the worst that is not ruled out a warning says so.

    Args:
        experiment: to fly.
        robot: as it is described.
        controller: of the flight.
    """
    robot = robot.pairs
    posture, tilt = experiment.posture, experiment.terminations.tilt
    # A configuration made in Python may hold lists.
    fixed = dataclasses.replace(posture, waypoints=tuple(tuple(way) for way in posture.waypoints))
    _require_hover(fixed, robot, needs_of(controller).vectoring, tilt)
    require_slow_enough(experiment, robot, controller)
    needs = hardest_needs(experiment, controller)
    if not experiment.approach.contact:
        return
    (along,) = _seen_from_the_tip(experiment, contact_frame(experiment.contact_axis).contact)
    _require_touch(robot, needs.vectoring, along)
    if needs.force > 0.0:
        _require_force(robot, controller.name, needs, along, tilt)
        _require_reserve(experiment, robot, needs)


@functools.lru_cache(maxsize=64)
def _require_hover(posture: PostureConfig, robot: Robot, purpose: str, tilt: float) -> None:
    """Once for all flights that differ in nothing else."""
    plan = posture_plan(posture, robot, purpose)
    times = np.arange(0.0, plan.duration + 1.0 / RATE, 1.0 / RATE)
    q, psi = plan.joint_angles(times), plan.vectoring_angles(times)
    if purpose == ONLINE:
        psi = planned_along(robot, q, psi[0])
    margins, across, shares = (
        part.full() for part in hover_margins_function(robot).map(len(times))(q.T, psi.T)
    )
    least = np.nan_to_num(margins.min(axis=0), nan=-np.inf)
    plain = (least >= posture.margin) & (np.hypot(*across) <= np.sin(min(tilt, 0.5 * np.pi)))
    plain &= np.all(np.abs(shares) <= 1.0, axis=0)
    within = Within(tilt, margin=posture.margin)
    # What least-norm thrusts do not hold is asked properly, the worst first.
    for row in sorted(np.flatnonzero(~plain).tolist(), key=lambda row: least[row]):
        found = can_hold(robot, q[row], psi[row], None, within)
        if isinstance(found, NotHeld):
            when = f", {times[row]:.1f} s after posture.waypoints begin" if plan.duration > 0.0 else ""
            raise ConfigError(_refused_hover(robot, (q[row], psi[row]), found, posture.margin, when))
    if np.any(least < 0.0):
        warnings.warn(
            f"'{robot.name}' hovers, but not with least-norm thrusts, of which control laws make a frame; "
            f"at q = {np.round(q[int(np.argmin(least))], 3).tolist()} rad these are beyond their limits",
            UserWarning,
            stacklevel=2,
        )


def _refused_hover(
    robot: Robot, where: tuple[np.ndarray, np.ndarray], found: NotHeld, least: float, when: str = ""
) -> str:
    q, psi = where
    nearest = nearest_posture(robot, q, psi, least)
    if nearest is None:
        instead = "no posture near it leaves more"
    elif np.allclose(nearest, q, atol=_SAME):
        instead = "other vectoring angles leave it there, so come to it another way"
    else:
        instead = f"the nearest posture that leaves it is {np.round(nearest, 3).tolist()} rad"
    asked = f", of {least:g} N m (posture.margin)" if least > 0.0 else ""
    return f"{cannot_hover(robot, q, found)}{asked}{when}; {instead}"


@functools.lru_cache(maxsize=64)
def _require_touch(robot: Robot, purpose: str, along: Direction) -> None:
    found = can_touch(robot, *nominal_posture(robot, purpose), np.array(along))
    if not found:
        raise ConfigError(
            f"'{robot.name}' cannot touch a surface across its contact axis in its nominal posture: {found}"
        )


def _require_force(robot: Robot, controller: str, needs: Needs, along: Direction, tilt: float) -> None:
    found = _most(robot, needs, along, tilt)
    if found and found.force >= (1.0 - _ROUNDING) * needs.force:
        return
    most = f"{robot.name} can hold about {found.force:.4g} N" if found else f"{robot.name} holds nothing"
    raise ConfigError(
        f"controller '{controller}' commands a force of {needs.force:g} N; in its nominal posture "
        f"{most} along the contact axis: {found.limit or found} is in the way"
    )


def _require_reserve(experiment: Experiment, robot: Robot, needs: Needs) -> None:
    """Refused where it is too much on the surface that is believed, doubtful on the worst not ruled out."""
    approach = experiment.approach
    usual, most = approach.believed_friction
    for share, friction, lean in (
        (REFUSED_SHARE, usual, 0.0),
        (DOUBTFUL_SHARE, most, approach.believed_lean),
    ):
        held = pressed_against_drag(experiment, robot, needs, needs.force / share, friction, lean)
        if held.force >= (1.0 - _ROUNDING) * needs.force / share:
            continue
        refused = share == REFUSED_SHARE
        leaning = f" that leans by {np.degrees(lean):.3g} degrees" if lean else ""
        words = (
            f"a force of {needs.force:g} N is {'too much' if refused else 'doubtful'}: with a friction of "
            f"{friction:g} {'as believed' if refused else f'on a surface{leaning}, which is not ruled out'}, "
            f"{robot.name} can hold about {held.force:.1f} N at rest while the pen is dragged to every side "
            f"({held.limit} ends it); {share * held.force:.1f} N and less"
        )
        if refused and approach.doubtful != "fly":
            raise ConfigError(
                f'{words} take off; approach.doubtful = "fly" flies {needs.force:g} N all the same'
            )
        warnings.warn(f"{words} are safer", UserWarning, stacklevel=2)
        return


class Pressed(NamedTuple):
    """The greatest force along the normal that is held while the pen is dragged, N, and what ends it."""

    force: float
    limit: Limit | None


def pressed_against_drag(
    experiment: Experiment, robot: Robot, needs: Needs, most: float, friction: float, lean: float
) -> Pressed:
    """The greatest force up to `most` that can be held at rest on a surface that leans and drags to any side.

    A surface that leans to the side to which it drags turns the push by both angles.

    Args:
        experiment: with contact axis and limit of tilt.
        robot: that pushes.
        needs: of its controller.
        most: N.
        friction: of the surface.
        lean: of its normal from the contact axis, rad.

    Raises:
        ConfigError: the robot cannot rest there with any force.
    """
    frame = contact_frame(experiment.contact_axis)
    into, *across = _seen_from_the_tip(experiment, frame.contact, frame.sliding_u, frame.sliding_v)
    turned = lean + np.arctan(friction)
    ways = {
        tuple((np.cos(turned) * np.array(into) + sign * np.sin(turned) * np.array(way)).tolist())
        for way in across
        for sign in (1.0, -1.0)
    }
    needs = dataclasses.replace(needs, force=most)
    size = float(np.hypot(1.0, friction))
    return _most_dragged(robot, needs, tuple(sorted(ways)), size, experiment.terminations.tilt)


def _seen_from_the_tip(experiment: Experiment, *ways: np.ndarray) -> list[Direction]:
    """Directions of W in the level frame whose x axis is the heading, as it is in the nominal posture."""
    heading = contact_frame(experiment.contact_axis).heading + experiment.approach.heading
    return [tuple((rot_z(-heading) @ way).tolist()) for way in ways]


def hardest_needs(experiment: Experiment, controller: Controller) -> Needs:
    """What the controller needs, with the greatest force that path, gains and changed gains command."""
    needs, asked = needs_of(controller), experiment.trajectory.force
    if asked and not needs.force:
        warnings.warn(
            f"controller '{controller.name}' commands no force, so it does not follow trajectory.force = "
            f"{list(asked)} N; following and drawing do",
            UserWarning,
            stacklevel=2,
        )
    elif asked:
        return dataclasses.replace(needs, force=max(asked))
    if not isinstance(controller, Cascade):
        return needs
    changes = (event for event in experiment.events if isinstance(event, GainChange))
    changed = (controller.force_with(change.key, change.value) for change in changes)
    return dataclasses.replace(needs, force=max((needs.force, *changed)))


@functools.lru_cache(maxsize=64)
def _most(robot: Robot, needs: Needs, along: Direction, tilt: float) -> Held | NotHeld:
    """The greatest force up to the commanded one that the robot can hold."""
    posture = nominal_posture(robot, needs.vectoring)
    return greatest_push(robot, *posture, np.array(along), Within(tilt, needs.moves), needs.force)


@functools.lru_cache(maxsize=64)
def _most_dragged(
    robot: Robot, needs: Needs, ways: tuple[Direction, ...], size: float, tilt: float
) -> Pressed:
    """The greatest force up to the commanded one with which the robot can push each way, N.

    Args:
        robot: that pushes.
        needs: of its controller, with the force.
        ways: of the whole push, unit vectors.
        size: of the whole push for 1 N of force.
        tilt: the greatest, rad.
    """
    most, within = Pressed(needs.force, None), Within(tilt, needs.moves)
    posture = nominal_posture(robot, needs.vectoring)
    for way in ways:
        found = greatest_push(robot, *posture, np.array(way), within, most.force * size)
        if isinstance(found, NotHeld):
            raise ConfigError(f"'{robot.name}' cannot do this task: pressing and dragged aside, {found}")
        if found.force < (1.0 - _ROUNDING) * most.force * size:
            most = Pressed(found.force / size, found.limit)
    return most
