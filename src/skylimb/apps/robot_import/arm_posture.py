"""How an arm stands: its tip foremost, clear of rotors, its tool level, free to move, far from its limits."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import numpy as np

from skylimb.control.planning.tip_pose import tip_jacobian, tip_position
from skylimb.robots.hover import find_hover
from skylimb.robots.model import Robot
from skylimb.robots.starts import golden_steps
from skylimb.robots.touch import can_touch

_DRAWS, _POLISHED = 256, 4
"""Postures that are looked at, and the best of them that are made better."""
_ALONG = np.linspace(0.0, 1.0, 6)[:, None]
_STEPS = (0.3, 0.1, 0.03, 0.01)
"""Changes of one joint that are tried on the way, rad."""
_ROOM, _CLEAR, _MOBILE, _TRAVEL = 0.1, 0.15, 0.1, 0.4
"""What is enough: tip before all else (m), links from rotors' discs (m), least motion of the tip by the
joints (m/rad), distance from a limit (rad)."""
_ASIDE, _SLOPE, _BENT = 0.05, 0.5, 4.0
"""What is much: tip beside the heading (m), slope of the tool (rad), joints from zero (rad)."""


def arm_posture(robot: Robot) -> np.ndarray | None:
    """The best posture that a search finds and that hovers, q (nq,), rad; None where no tip is foremost.

    Postures are spread evenly over the limits, the same every time; a few are made better joint by joint.
    """
    low, high = (np.clip(limit, -math.pi, math.pi) for limit in robot.joint_limits())
    room = np.minimum(0.1, 0.25 * (high - low))
    low, high = low + room, high - room
    steps = np.outer(np.arange(_DRAWS), golden_steps(robot.n_joints)) % 1.0
    drawn = [np.clip(np.zeros(robot.n_joints), low, high), *(low + (high - low) * steps)]
    worth = _worth(robot, low, high)
    drawn.sort(key=worth, reverse=True)
    best = sorted((_polished(worth, q, low, high) for q in drawn[:_POLISHED]), key=worth, reverse=True)
    hovering = (q for q in best if worth(q) > 0.0 and find_hover(robot, q))
    return next(hovering, None)


def _worth(robot: Robot, low: np.ndarray, high: np.ndarray) -> Callable[[np.ndarray], float]:
    psi = robot.description.vectoring_start
    width = np.minimum(_TRAVEL, 0.5 * (high - low))

    def worth(q: np.ndarray) -> float:
        touch = can_touch(robot, q, psi, np.array([1.0, 0.0, 0.0]))
        if not touch:
            return touch.room
        _, aside, _ = tip_position(robot, q, psi)
        ahead, _, up = robot.tool(q, psi)[0][:, 1]
        slope = math.atan2(up, max(ahead, 1e-9))
        moved = np.linalg.svd(tip_jacobian(robot, q, psi), compute_uv=False)
        # What binds counts: a product has no use for more of one when another is short.
        return (
            min(touch.room / _ROOM, 1.0)
            * min(_from_discs(robot, q, psi) / _CLEAR, 1.0)
            * math.exp(-((aside / _ASIDE) ** 2) - (slope / _SLOPE) ** 2 - float(q @ q) / _BENT**2)
            * min(float(moved[min(robot.n_joints, 3) - 1]) / _MOBILE, 1.0)
            * float(np.prod(np.minimum((np.minimum(q - low, high - q) + 0.1) / width, 1.0)))
        )

    return worth


def _from_discs(robot: Robot, q: np.ndarray, psi: np.ndarray) -> float:
    """Least distance between the arm's links and a rotor's disc, m."""
    ends, poses = robot.skeleton(q, psi)[1:], robot.link_poses(q, psi)
    points = np.concatenate([one + _ALONG * (other - one) for one, other in itertools.pairwise(ends)])
    found = []
    for rotor in robot.description.rotors:
        place, R = poses[rotor.link]
        local = (points - place - R @ rotor.xyz) @ R @ rotor.R
        beside = np.maximum(np.hypot(local[:, 0], local[:, 1]) - (rotor.radius or 0.0), 0.0)
        found.append(float(np.hypot(beside, local[:, 2]).min()))
    return min(found)


def _polished(
    worth: Callable[[np.ndarray], float], q: np.ndarray, low: np.ndarray, high: np.ndarray
) -> np.ndarray:
    """A posture made better joint by joint until no step of any size does."""
    held = worth(q)
    for step in _STEPS:
        better = True
        while better:
            moves = [np.clip(q + sign * step * e, low, high) for e in np.eye(len(q)) for sign in (1.0, -1.0)]
            worths = [worth(move) for move in moves]
            best = int(np.argmax(worths))
            better = worths[best] > held + 1e-9
            if better:
                q, held = moves[best], worths[best]
    return q
