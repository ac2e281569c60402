"""Whether the robot can hold the force that a controller commands; where it cannot, no flight begins.

The model answers for the nominal posture at rest, within the rotors' thrusts, the experiment's tilt limit
and the moves of the vectoring angles that the controller makes. A force that fails there is out of reach of
any gains. One that passes may still be missed; where friction's drag is too much, a warning says so.
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
from skylimb.experiments.experiment import Experiment
from skylimb.missions.frame import contact_frame
from skylimb.planning.posture import posture_family
from skylimb.planning.press import can_push, greatest_push
from skylimb.planning.vectoring import vectoring_table
from skylimb.robots.model import Robot
from skylimb.spatial import rot_z


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


def warn_of_friction(experiment: Experiment, robot: Robot, controller: Controller) -> None:
    """Warn where the force could be held, but not with friction's drag to every side."""
    needs, friction = _hardest(experiment, controller), float(getattr(experiment.surface, "friction", 0.0))
    if not experiment.approach.contact or needs.force <= 0.0 or friction <= 0.0:
        return
    if not _drags(robot, needs, tuple(experiment.contact_axis), experiment.terminations.tilt, friction):
        warnings.warn(
            f"a force of {needs.force:g} N is doubtful: at a friction of {friction:g} {robot.name} cannot "
            "hold it in its nominal posture while the pen is dragged to every side",
            UserWarning,
            stacklevel=2,
        )


def _hardest(experiment: Experiment, controller: Controller) -> Needs:
    """What the controller needs, with the greatest force that it commands, also once gains have changed."""
    needs = needs_of(controller)
    if not isinstance(controller, Cascade):
        return needs
    changed = (controller.force_with(change.key, change.value) for change in experiment.gain_changes)
    return dataclasses.replace(needs, force=max((needs.force, *changed)))


@functools.lru_cache(maxsize=64)
def _most(robot: Robot, needs: Needs, axis: tuple[float, float, float], tilt: float) -> float:
    """The greatest force up to the commanded one that the robot can hold, N."""
    q, psi, direction = _posture(robot, needs, axis)
    if can_push(robot, q, psi, needs.force * direction, tilt, needs.moves):
        return needs.force
    return greatest_push(robot, q, psi, direction, needs.force, tilt, needs.moves)


@functools.lru_cache(maxsize=64)
def _drags(
    robot: Robot, needs: Needs, axis: tuple[float, float, float], tilt: float, friction: float
) -> bool:
    """Whether the force can be held with the drag of friction to each side."""
    q, psi, direction = _posture(robot, needs, axis)
    frame = contact_frame(axis)
    turn = rot_z(-frame.heading)
    sides = [sign * turn @ side for side in (frame.sliding_u, frame.sliding_v) for sign in (1.0, -1.0)]
    return all(
        can_push(robot, q, psi, needs.force * (direction + friction * side), tilt, needs.moves)
        for side in sides
    )


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
