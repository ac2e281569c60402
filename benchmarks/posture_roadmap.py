"""Ways between postures; through other postures where the straight way leaves too little.

Vectoring angles depend on the way by which a posture was reached. So a place on the map is a posture together
with the branch of its vectoring angles, and an edge is a straight way that was rehearsed from there
(`rehearse`). Edges are rehearsed when the search comes to them, and kept.
"""

from __future__ import annotations

import functools
import heapq
import math
from typing import NamedTuple

import casadi as ca
import numpy as np

from skylimb.base.rotations import wrapped
from skylimb.control.planning.joint_torque import joint_torque_function
from skylimb.control.planning.tip_pose import link_distances
from skylimb.control.planning.vectoring_step import TILTED, first_vectoring, plan_vectoring, settled_vectoring
from skylimb.robots.model import Robot

_SAME = 0.15
"""Vectoring angles in one posture that are closer than this are of one branch, rad."""


_NEIGHBOURS = 10
"""Nearest postures that a way may lead on to."""

_PLACES = 100
"""Places that a search looks on from before it gives up."""


HELD = 0.8
"""Greatest share of a servo's torque on a way; the rest bends the joints, and is for control."""

_APART = 0.02
"""Greatest change of a joint angle between two plans on a straight way, rad."""


class Rehearsal(NamedTuple):
    """What a flight through some postures would plan, one row a posture.

    Attributes:
        joint_angles: q, rad, (k, nq).
        vectoring_angles: psi, rad, (k, nv).
        margins: torque that is left, N m, (k,); see `Planned.margin`.
        tilts: of the hover, rad, (k,).
        servos: greatest share of their torque that the shape joints' servos give (`joint_torque`), (k,).
    """

    joint_angles: np.ndarray
    vectoring_angles: np.ndarray
    margins: np.ndarray
    tilts: np.ndarray
    servos: np.ndarray

    def leaves(self, least: float) -> bool:
        """Whether every row leaves a margin (N m), and the servos of the joints enough to bend them."""
        return bool(np.all(self.margins >= least) and np.all(self.servos <= HELD))


def rehearse(robot: Robot, postures: np.ndarray, before: np.ndarray) -> Rehearsal:
    """The plans for postures (k, nq), one after another from the angles `before` (nv,), rad.

    Args:
        robot: of four rotors or more.
        postures: q, as they are commanded from plan to plan, rad.
        before: psi in the first of them, rad.
    """
    plans, angles = [], np.asarray(before, dtype=float)
    for q in postures:
        plans.append(plan_vectoring(robot, q, angles))
        angles = plans[-1].angles
    return Rehearsal(
        np.asarray(postures, dtype=float),
        np.array([plan.angles for plan in plans]).reshape(len(plans), robot.n_vectoring),
        np.array([plan.margin for plan in plans]),
        np.array([plan.tilt for plan in plans]),
        np.array([held_share(robot, q, plan.angles) for q, plan in zip(postures, plans, strict=True)]),
    )


def straight_way(begin: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Postures (k, nq) from one to another, all joints together, as densely as a flight plans, rad."""
    begin, end = np.asarray(begin, dtype=float), np.asarray(end, dtype=float)
    count = 1 + int(np.ceil(np.max(np.abs(end - begin), initial=0.0) / _APART))
    share = np.linspace(0.0, 1.0, count + 1)[1:, None]
    return (1.0 - share) * begin + share * end


def held_share(robot: Robot, joint_angles: np.ndarray, vectoring_angles: np.ndarray) -> float:
    """The greatest share of its torque that a servo of the shape joints gives in hover."""
    torque = joint_torque_function(robot)(joint_angles, vectoring_angles).full().ravel()
    return float(np.max(np.abs(torque) / robot.description.shape_servos.torque_limit, initial=0.0))


class Place(NamedTuple):
    """A posture of the map by its index, and the branch of its vectoring angles by its own."""

    posture: int
    branch: int


class Roadmap:
    """Postures, and the ways between them that a robot can fly.

    Attributes:
        robot: whose.
        postures: q of each, rad, (k, nq); the first is the nominal one.
        least: margin that every way leaves, N m.
        clearance: least distance between links that are not joined, m.
    """

    def __init__(
        self,
        robot: Robot,
        postures: np.ndarray,
        least: float,
        clearance: float = 0.0,
    ) -> None:
        self.robot, self.least, self.clearance = robot, least, clearance
        self.postures = np.vstack([robot.nominal_posture(), postures])
        self._branches: list[list[np.ndarray]] = [[] for _ in self.postures]
        self._edges: dict[tuple[Place, int], Place | None] = {}
        self.start = self._place(0, first_vectoring(robot).angles)

    def way(self, begin: Place, end: int) -> list[Place] | None:
        """The shortest way from a place to a posture, with both of its ends; None where there is none.

        A way's length is the sum of the greatest turn of a joint on each edge, as time is, and a little for
        each stop.
        """
        best: dict[Place, float] = {begin: 0.0}
        before: dict[Place, Place] = {}
        queue = [(self._distance(begin.posture, end), begin)]
        for _ in range(_PLACES):
            if not queue:
                break
            estimate, place = heapq.heappop(queue)
            if place.posture == end:
                return self._traced(before, place)
            if estimate > best[place] + self._distance(place.posture, end) + 1e-9:
                continue  # a shorter way to it was found meanwhile
            # The straight way to the end is tried first; only where it fails others are looked at.
            for k in [end] if self.edge(place, end) else self._near(place.posture):
                reached = self.edge(place, k)
                if reached is None:
                    continue
                length = best[place] + self._distance(place.posture, k)
                if length < best.get(reached, math.inf) - 1e-12:
                    best[reached], before[reached] = length, place
                    heapq.heappush(queue, (length + self._distance(k, end), reached))
        return None

    def edge(self, begin: Place, end: int) -> Place | None:
        """Where the straight way to a posture ends; None where it cannot be flown."""
        key = (begin, end)
        if key not in self._edges:
            self._edges[key] = self._rehearsed(begin, end)
        return self._edges[key]

    def _near(self, posture: int) -> list[int]:
        """The nearest other postures."""
        away = np.max(np.abs(self.postures - self.postures[posture]), axis=1)
        return [int(k) for k in np.argsort(away)[1 : _NEIGHBOURS + 1]]

    def vectoring_angles(self, place: Place) -> np.ndarray:
        """Psi there, rad, (nv,)."""
        return self._branches[place.posture][place.branch]

    def _rehearsed(self, begin: Place, end: int) -> Place | None:
        way = straight_way(self.postures[begin.posture], self.postures[end])
        if not keeps_clear(self.robot, way, self.clearance):
            return None
        flown = rehearse(self.robot, way, self.vectoring_angles(begin))
        settled = settled_vectoring(self.robot, self.postures[end], flown.vectoring_angles[-1])
        tilted = self.robot.n_vectoring > 0 and flown.tilts.max() > TILTED
        held = held_share(self.robot, self.postures[end], settled.angles) <= HELD
        enough = flown.leaves(self.least) and settled.margin >= self.least and held
        if tilted or not enough:
            return None
        return self._place(end, settled.angles)

    def _place(self, posture: int, angles: np.ndarray) -> Place:
        known = self._branches[posture]
        for index, other in enumerate(known):
            if np.max(np.abs(wrapped(angles - other)), initial=0.0) < _SAME:
                return Place(posture, index)
        known.append(angles)
        return Place(posture, len(known) - 1)

    def _distance(self, one: int, other: int) -> float:
        return 0.1 + float(np.max(np.abs(self.postures[one] - self.postures[other]))) if one != other else 0.0

    @staticmethod
    def _traced(before: dict[Place, Place], place: Place) -> list[Place]:
        way = [place]
        while way[-1] in before:
            way.append(before[way[-1]])
        return way[::-1]


def keeps_clear(robot: Robot, postures: np.ndarray, clearance: float) -> bool:
    """Whether links that are not joined stay apart by a distance (m) in all of some postures (k, nq)."""
    if clearance <= 0.0 or robot.n_joints == 0:
        return True
    least = _least_distance(robot)
    return all(float(least(q)) > clearance for q in postures)


@functools.lru_cache(maxsize=16)
def _least_distance(robot: Robot) -> ca.Function:
    """Q -> the least distance between points of links that are not joined, m; infinite without any."""
    q = ca.SX.sym("q", robot.n_joints)
    distances = link_distances(robot, q)
    least = ca.mmin(distances) if distances.numel() else ca.SX(ca.inf)
    return ca.Function("least", [q], [least], {"cse": True})
