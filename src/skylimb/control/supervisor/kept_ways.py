"""Ways down that were found once, in the user's cache: their search takes seconds, in each process anew.

An entry's name is a digest of all that the search depends on: a robot with another mass finds its own. What
is read is what was found, to the last bit.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
from collections.abc import Callable, Sequence

import numpy as np

from skylimb.base.cache import cache_folder, keep, kept
from skylimb.control.planning.vectoring_digest import robot_digest
from skylimb.robots.model import Robot

Ways = tuple[np.ndarray | None, ...]
"""Vectoring angles without each of some parts, rad, (nv,); None where there is no way down."""

VERSION = 1
"""Counts up when the search changes: what another one found is not used."""


def kept_or_found(
    robot: Robot,
    posture: tuple[np.ndarray, np.ndarray],
    constants: Sequence[float],
    search: Callable[[], tuple[Ways, Ways]],
) -> tuple[Ways, Ways]:
    """Ways down without each rotor and without each shape joint's servo, from the cache or a search.

    Args:
        robot: any robot with rotors.
        posture: joint and vectoring angles from which the robot comes down, rad, (nq,) and (nv,).
        constants: of the search.
        search: finds them.
    """
    try:
        cached = cache_folder() / "descents" / f"{_digest(robot, posture, constants)}.json"
    except ImportError:  # the core alone keeps nothing
        return search()
    content = kept(cached)
    if content is not None:
        rotors, joints = json.loads(content)
        return _arrays(rotors), _arrays(joints)
    found = search()
    # Without a cache everything works, only slower.
    with contextlib.suppress(OSError):
        keep(cached, json.dumps([_lists(ways) for ways in found]).encode())
    return found


def _digest(robot: Robot, posture: tuple[np.ndarray, np.ndarray], constants: Sequence[float]) -> str:
    torques = np.broadcast_to(robot.description.shape_servos.torque_limit, robot.n_joints)
    numbers = [part.tolist() for part in (*posture, torques)]
    text = json.dumps([VERSION, list(constants), robot_digest(robot), numbers])
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def _lists(ways: Ways) -> list[list[float] | None]:
    return [None if angles is None else angles.tolist() for angles in ways]


def _arrays(ways: list[list[float] | None]) -> Ways:
    return tuple(None if angles is None else np.array(angles) for angles in ways)
