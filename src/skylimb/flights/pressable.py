"""Whether the robot can hold the force that a controller commands; where it cannot, no flight begins.

The model answers for the nominal posture at rest, within the rotors' thrusts, the experiment's tilt limit
and the moves of the vectoring angles that the controller makes. It is asked twice. A force along the contact
axis that fails there is out of reach of any gains. And a force along the surface's own normal, with the drag
of its friction to every side, has to leave something over for the flight: of flights that wanted more
than 60 % of what the model holds, half were lost and most of the others did not keep their force
(docs/scores.md has the count).
"""

from __future__ import annotations

import dataclasses
import functools
import warnings

import numpy as np

from skylimb.control.cascade import Cascade
from skylimb.control.controller import Controller
from skylimb.control.needs import Needs, needs_of
from skylimb.errors import ConfigError
from skylimb.events import GainChange
from skylimb.experiments.experiment import Experiment
from skylimb.missions.frame import contact_frame
from skylimb.planning.posture import posture_family
from skylimb.planning.press import greatest_push
from skylimb.planning.vectoring import vectoring_table
from skylimb.robots.model import Robot
from skylimb.spatial import rot_z

CALM_SHARE = 0.5
"""Of what can be held against slope and drag: up to here the force leaves enough over."""

MOST_SHARE = 0.6
"""Of the same: beyond this flights are lost."""


def require_pressable(experiment: Experiment, robot: Robot, controller: Controller) -> None:
    """Raise a `ConfigError` when the force that the controller commands cannot be held at rest."""
    needs = _hardest(experiment, controller)
    if not experiment.approach.contact or needs.force <= 0.0:
        return
    axis, tilt = tuple(experiment.contact_axis), experiment.terminations.tilt
    most = _most(robot, needs, axis, tilt)
    if most < needs.force:
        low = min(rotor.thrust_min for rotor in robot.description.rotors)
        high = max(rotor.thrust_max for rotor in robot.description.rotors)
        raise ConfigError(
            f"controller '{controller.name}' commands a force of {needs.force:g} N; in its nominal posture "
            f"{robot.name} can hold about {most:.1f} N along the contact axis, with thrusts of {low:g} .. "
            f"{high:g} N and tilted by at most {tilt:g} rad (terminations.tilt)"
        )


def require_reserve(experiment: Experiment, robot: Robot, controller: Controller) -> None:
    """Raise a `ConfigError` where the force leaves too little over; warn where it leaves little.

    The share of the force in what can be held against slope and drag decides: above `MOST_SHARE` it is
    refused, unless `approach.doubtful` is "fly"; above `CALM_SHARE` a warning says so.
    """
    needs, friction = _hardest(experiment, controller), float(getattr(experiment.surface, "friction", 0.0))
    if not experiment.approach.contact or needs.force <= 0.0 or friction <= 0.0:
        return
    enough = needs.force / CALM_SHARE
    held = held_against_drag(experiment, robot, needs, enough)
    if held >= enough:
        return
    refused = needs.force > MOST_SHARE * held
    slope = float(getattr(experiment.surface, "slope", 0.0))
    leaning = f" and a slope of {np.degrees(slope):.3g} degrees" if slope else ""
    shares = "60 % of that, flights are lost or do not keep it"
    words = (
        f"a force of {needs.force:g} N is {'too much' if refused else 'doubtful'}: at a friction of "
        f"{friction:g}{leaning} {robot.name} can hold about {held:.1f} N at rest while the pen is dragged to "
        f"every side. Above {shares if refused else 'half of that, not every preset keeps its force'}; "
        f"{(MOST_SHARE if refused else CALM_SHARE) * held:.1f} N and less"
    )
    if not refused or experiment.approach.doubtful == "fly":
        warnings.warn(f"{words} are safer", UserWarning, stacklevel=2)
        return
    raise ConfigError(f'{words} take off; approach.doubtful = "fly" flies {needs.force:g} N all the same')


def held_against_drag(experiment: Experiment, robot: Robot, needs: Needs, most: float) -> float:
    """The greatest force up to `most` that can be held at rest with slope and drag to every side, N."""
    axis, tilt = tuple(experiment.contact_axis), experiment.terminations.tilt
    friction = float(getattr(experiment.surface, "friction", 0.0))
    surface = tuple(experiment.surface.R_WS.ravel())
    return _most_dragged(robot, dataclasses.replace(needs, force=most), axis, tilt, friction, surface)


def _hardest(experiment: Experiment, controller: Controller) -> Needs:
    """What the controller needs, with the greatest force that it commands, also once gains have changed."""
    needs = needs_of(controller)
    if not isinstance(controller, Cascade):
        return needs
    changes = (event for event in experiment.events if isinstance(event, GainChange))
    changed = (controller.force_with(change.key, change.value) for change in changes)
    return dataclasses.replace(needs, force=max((needs.force, *changed)))


@functools.lru_cache(maxsize=64)
def _most(robot: Robot, needs: Needs, axis: tuple[float, float, float], tilt: float) -> float:
    """The greatest force up to the commanded one that the robot can hold, N."""
    q, psi, direction = _posture(robot, needs, axis)
    return greatest_push(robot, q, psi, direction, needs.force, tilt, needs.moves)


@functools.lru_cache(maxsize=64)
def _most_dragged(
    robot: Robot,
    needs: Needs,
    axis: tuple[float, float, float],
    tilt: float,
    friction: float,
    surface: tuple[float, ...],
) -> float:
    """The greatest force up to the commanded one that can be held with the drag of friction to each side, N.

    Args:
        robot: that pushes.
        needs: of its controller, with the force.
        axis: contact axis of the mission, which gives the heading.
        tilt: the greatest, rad.
        friction: coefficient.
        surface: rotation R_WS row by row; its first column is the normal, into the surface.
    """
    q, psi, _ = _posture(robot, needs, axis)
    into, *along = (rot_z(-contact_frame(axis).heading) @ np.reshape(surface, (3, 3))).T
    most = needs.force
    for side in (sign * friction * one for one in along for sign in (1.0, -1.0)):
        push = into + side
        # `greatest_push` wants a unit direction; its answer is the whole push, of which a part presses.
        size = float(np.linalg.norm(push))
        whole = greatest_push(robot, q, psi, push / size, most * size, tilt, needs.moves)
        most = min(most, whole / size)
    return most


def _posture(
    robot: Robot, needs: Needs, axis: tuple[float, float, float]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Angles of the nominal posture, and the contact axis seen in the tip link's heading."""
    family = posture_family(robot)
    theta = family.theta_nominal
    q = np.asarray(family.joint_angles(theta), dtype=float)
    psi = np.asarray(vectoring_table(robot, needs.vectoring).angles(theta), dtype=float)
    frame = contact_frame(axis)
    return q, psi, rot_z(-frame.heading) @ frame.contact
