"""How a robot comes down without a rotor or a joint's servo: its vectoring angles, found before take-off.

The others have to carry it, without torque. Whether they can is one question to `robots.equilibrium`, asked
of the robot without that rotor, in its nominal posture, with ever more lean. There is no time to bend: joints
turn at .5 rad/s, and a robot that has lost a rotor tilts by 15 degrees in .2 s. So rotors without which
there is no way down are named before take-off, and a posture in which there would be one.

A joint that nothing holds swings, as the tilted rotors of its links push past it; their thrusts swing along,
and the robot drifts off. Where near vectoring angles leave no torque in the joint, they are taken; where not,
and where a vectoring joint itself goes its own way, the others find theirs in flight (`balance`).
"""

from __future__ import annotations

import functools
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from skylimb.control.planning.vectoring import nominal_posture
from skylimb.control.supervisor.balance import RATE
from skylimb.control.supervisor.kept_ways import Ways, kept_or_found
from skylimb.control.supervisor.limits import Limits
from skylimb.robots.equilibrium import can_hold, hovers
from skylimb.robots.equilibrium_results import Held, Within
from skylimb.robots.model import Robot
from skylimb.robots.starts import golden_steps
from skylimb.symbolic import Array, abs, dot, max, where

LEANS = 0.01, 0.15, 0.3
"""Tilts of the measured link that are allowed, the least first, rad."""

ROOM = 0.05
"""Share of its range that has to be left to every thrust."""

NEAR, SLACK = 0.8, 1e-3
"""Greatest move of the vectoring angles for a limp joint, rad: what takes longer comes when it has swung far.
And the torque that may be left in it, N m."""

POSTURES, NEARER = 40, 4
"""Postures that are tried for one with a way down, evenly over the joints' travel, and how often the way to
the first one that has it is halved."""


class Descents(NamedTuple):
    """The ways down of a robot.

    Attributes:
        angles: vectoring angles without each of the rotors, rad, (nv,); None where there is no way down.
        limp: likewise without the servo of each shape joint.
    """

    angles: Ways = ()
    limp: Ways = ()

    def missing(self, left: Array) -> Any:
        """How many rotors are lost without which there is no way down; `left` is 0 of a lost one, (n,)."""
        none = np.array([float(angles is None) for angles in self.angles] or [0.0] * left.shape[0])
        return dot(none, where(left > 0.0, 0.0, 1.0))

    def unanswered(self, loose: Array) -> Array:
        """Those of the joints that nothing holds, (nq + nv,), for which no angles were found before."""
        known = np.zeros(loose.shape[0])
        known[: len(self.limp)] = [angles is not None for angles in self.limp]
        return loose * (1.0 - known)

    def followed(self, left: Array, loose: Array, here: Array, dt: float) -> Array:
        """Vectoring angles of a tick on their straight way to those without the part that is lost.

        Args:
            left: 0 of a rotor that is lost, (n,).
            loose: 1 of a joint that nothing holds, those of the shape first, (nq + nv,).
            here: vectoring angles of the last tick, rad, (nv,).
            dt: control period, s.
        """
        there = here
        for index, angles in enumerate(self.limp):
            if angles is not None:
                there = where(loose[index] > 0.5, angles, there)
        for index, angles in enumerate(self.angles):
            if angles is not None:
                there = where(left[index] > 0.0, there, angles)
        # All arrive together, as the lean is small along that way only.
        way = there - here
        return here + way * (RATE * dt / max(max(abs(way)), RATE * dt)) if here.shape[0] else here


NO_DESCENTS = Descents()


def descents_of(robot: Robot, purpose: str, limits: Limits) -> Descents:
    """The ways down that a supervisor needs: none where it does not look for lost rotors.

    Args:
        robot: any robot with rotors.
        purpose: of the vectoring angles in its nominal posture, as of `nominal_posture`.
        limits: of the supervisor.
    """
    return _descents(robot, purpose) if limits.losses else NO_DESCENTS


def unprotected(robot: Robot, purpose: str, limits: Limits) -> str:
    """The rotors whose loss is not protected, in words; arguments are those of `descents_of`."""
    if not limits.losses:
        return "all, as supervisor.losses is off"
    # Those of pairs come behind the robot's own.
    every = zip(robot.description.rotors, _descents(robot, purpose).angles, strict=robot.turned is None)
    return ", ".join(rotor.name for rotor, angles in every if angles is None) or "none"


@functools.lru_cache(maxsize=16)
def protecting_posture(robot: Robot, purpose: str, lost: int) -> np.ndarray | None:
    """Joint angles near to the nominal posture's in which the loss of a rotor could be outlived, rad, (nq,).

    None where none was found among those that are tried. It takes seconds.

    Args:
        robot: any robot with rotors.
        purpose: as of `descents_of`.
        lost: number of the rotor.
    """
    nominal, psi = nominal_posture(robot, purpose)
    low, high = robot.joint_limits()
    if not nominal.size:
        return None
    steps = np.outer(np.arange(1, POSTURES + 1), golden_steps(nominal.size)) % 1.0
    tried = np.vstack([nominal, low + steps * (high - low)])
    tried = tried[np.argsort(np.abs(tried - nominal).max(axis=1))]
    rest, widest = _others(robot, lost), Within(LEANS[-1], np.inf)

    def holds(q: np.ndarray) -> bool:
        found = hovers(rest, q, psi, widest)
        return any(isinstance(one, Held) and one.room >= ROOM for one in found)

    far = next((q for q in tried if holds(q)), None)
    near = nominal
    for _ in range(NEARER if far is not None else 0):
        half = 0.5 * (near + far)
        near, far = (near, half) if holds(half) else (half, far)
    return far


@functools.lru_cache(maxsize=16)
def _descents(robot: Robot, purpose: str) -> Descents:
    if robot.turned is not None:  # neither two nor three rotors can do without one
        return Descents((None,) * robot.pairs.n_rotors, (None,) * robot.n_joints)
    posture = nominal_posture(robot, purpose)

    def search() -> tuple[Ways, Ways]:
        rotors = tuple(_without(robot, lost, *posture) for lost in range(robot.n_rotors))
        return rotors, tuple(_slack(robot, joint, *posture) for joint in range(robot.n_joints))

    return Descents(*kept_or_found(robot, posture, (*LEANS, ROOM, NEAR, SLACK), search))


def _without(robot: Robot, lost: int, q: np.ndarray, psi: np.ndarray) -> np.ndarray | None:
    """Vectoring angles, by the shortest way from the given ones."""
    rest = _others(robot, lost)

    def held(lean: float) -> Held | None:
        found = can_hold(rest, q, psi, None, Within(lean, np.inf))
        return found if found and found.room >= ROOM else None

    # Where nothing is found with the most lean, nobody searches with less.
    widest = held(LEANS[-1])
    if widest is None:
        return None
    found = next(filter(None, map(held, LEANS[:-1])), widest)
    turn = found.vectoring_angles - psi
    turn -= 2.0 * np.pi * np.round(turn / (2.0 * np.pi))
    # What turns nothing but the rotor that is lost need not move.
    for joint, alone in enumerate(np.eye(len(psi))):
        still = rest.wrench_function(q, psi + turn - turn * alone) - rest.wrench_function(q, psi + turn)
        turn[joint] *= np.abs(still.full()).max() > 0.02
    return psi + turn


def _slack(robot: Robot, joint: int, q: np.ndarray, psi: np.ndarray) -> np.ndarray | None:
    """The nearest vectoring angles with which a joint needs no torque."""
    if not len(psi):
        return None
    known = robot.description
    torques = np.where(np.arange(robot.n_joints) == joint, SLACK, known.shape_servos.torque_limit)
    limp = Robot(replace(known, shape_servos=replace(known.shape_servos, torque_limit=torques)))
    found = can_hold(limp, q, psi, None, Within(LEANS[1], NEAR))
    return found.vectoring_angles if found and found.room >= ROOM else None


def _others(robot: Robot, lost: int) -> Robot:
    """The robot without a rotor."""
    rotors = robot.description.rotors
    return Robot(replace(robot.description, rotors=rotors[:lost] + rotors[lost + 1 :]))
