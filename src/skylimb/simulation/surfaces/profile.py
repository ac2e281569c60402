"""Straight and round pieces in the (u, w) plane, drawn out along v: cylinders, steps, ridges, ramps.

Each piece has an exact distance and normal, and the nearest one touches. A hollow that is narrower than the
tip would have to touch it in two places, which the collision function cannot say: `tightest_hollow` lets
such a pair be refused.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from skylimb.base.errors import ConfigError
from skylimb.simulation.surfaces.shape import NativeShape, c_of_touch
from skylimb.symbolic import where

_STRAIGHT, _OUTWARD, _INWARD = 0.0, 1.0, 2.0
_SEAM = 1e-12
"""m by which pieces overlap, so that nothing falls between them."""

_NOWHERE = 1e9
"""Distance, m, of a point for which there is no closest one."""


@dataclass(frozen=True)
class Piece:
    """A straight or round piece.

    Attributes:
        kind: 0 straight, 1 round and bulging toward the robot, 2 round and hollow.
        at: (u, w) of a straight piece's start, or of an arc's centre, m.
        direction: unit (du, dw) along a straight piece, or from the centre to the arc's middle.
        extent: length of a straight piece, or radius of an arc, m.
        half_angle: of an arc, rad.
    """

    kind: float
    at: tuple[float, float]
    direction: tuple[float, float]
    extent: float
    half_angle: float = 0.0

    @property
    def ends(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Its first and last point (u, w), in the order of growing u."""
        (u, w), (du, dw) = self.at, self.direction
        if self.kind == _STRAIGHT:
            return (u, w), (u + self.extent * du, w + self.extent * dw)
        c, s = math.cos(self.half_angle), math.sin(self.half_angle)
        sides = [(u + self.extent * (c * du - q * dw), w + self.extent * (c * dw + q * du)) for q in (-s, s)]
        first, last = sorted(sides)
        return first, last


def straight(start: tuple[float, float], end: tuple[float, float]) -> Piece:
    """The straight piece between two points (u, w), u growing."""
    du, dw = end[0] - start[0], end[1] - start[1]
    length = math.hypot(du, dw)
    return Piece(_STRAIGHT, start, (du / length, dw / length), length)


def arc(centre: tuple[float, float], radius: float, half_angle: float, middle: tuple[float, float]) -> Piece:
    """An arc around `centre`; it bulges when its middle lies toward the robot, and is hollow otherwise."""
    kind = _OUTWARD if middle[1] < 0 else _INWARD
    return Piece(kind, centre, middle, radius, half_angle)


def polyline(
    points: list[tuple[float, float]], edge_radius: float, fillet_radius: float
) -> tuple[Piece, ...]:
    """Pieces along points (u, w) with u growing.

    Bulging corners are rounded by `edge_radius` and hollow ones by `fillet_radius` (m, 0 for a sharp corner).
    """
    pieces: list[Piece] = []
    start = points[0]
    for before, corner, after in zip(points, points[1:], points[2:], strict=False):
        t1, t2 = straight(before, corner).direction, straight(corner, after).direction
        turn = math.atan2(t1[0] * t2[1] - t1[1] * t2[0], t1[0] * t2[0] + t1[1] * t2[1])
        radius = edge_radius if turn > 0 else fillet_radius
        trim = radius * math.tan(0.5 * abs(turn))
        room = min(math.dist(start, corner), math.dist(corner, after))
        if trim >= room:
            raise ConfigError(
                f"surface: a corner at u = {corner[0]:.4g} m cannot be rounded by {radius:g} m: that takes "
                f"{trim:.3g} m of its neighbours, which have {room:.3g} m"
            )
        end = (corner[0] - trim * t1[0], corner[1] - trim * t1[1])
        pieces.append(straight(start, end))
        pieces.append(corner_arc(end, t1, t2, radius, turn))
        start = (corner[0] + trim * t2[0], corner[1] + trim * t2[1])
    pieces.append(straight(start, points[-1]))
    return tuple(pieces)


def corner_arc(
    begin: tuple[float, float], t1: tuple[float, float], t2: tuple[float, float], radius: float, turn: float
) -> Piece:
    """The arc from `begin`, along `t1`, until it runs along `t2`, `turn` (rad) later; its radius may be 0."""
    n1, n2 = (t1[1], -t1[0]), (t2[1], -t2[0])
    length = math.hypot(n1[0] + n2[0], n1[1] + n2[1])
    middle = ((n1[0] + n2[0]) / length, (n1[1] + n2[1]) / length)
    if turn > 0:  # w grows away from the robot, so a turn toward +w goes around a bulging corner
        centre = (begin[0] - radius * n1[0], begin[1] - radius * n1[1])
        return Piece(_OUTWARD, centre, middle, radius, 0.5 * abs(turn))
    centre = (begin[0] + radius * n1[0], begin[1] + radius * n1[1])
    return Piece(_INWARD, centre, (-middle[0], -middle[1]), radius, 0.5 * abs(turn))


@dataclass(frozen=True)
class Profile(NativeShape):
    """A shape of pieces, without end along v.

    Attributes:
        pieces: in the order of growing u.
    """

    pieces: tuple[Piece, ...]

    def height(self, u: ArrayLike, v: ArrayLike) -> np.ndarray:
        """The surface's w (m) at (u, v); NaN where there is none."""
        u, v = np.broadcast_arrays(np.asarray(u, dtype=float), np.asarray(v, dtype=float))
        w = np.full(u.shape, np.nan)
        for piece in self.pieces:
            (first, _), (last, _) = piece.ends
            here = np.isnan(w) & (u >= first - 1e-12) & (u <= last + 1e-12)
            offset = u[here] - piece.at[0]
            if piece.kind == _STRAIGHT:
                w[here] = piece.at[1] + offset * piece.direction[1] / piece.direction[0]
            else:
                sign = -1.0 if piece.kind == _OUTWARD else 1.0
                w[here] = piece.at[1] + sign * np.sqrt(np.maximum(piece.extent**2 - offset**2, 0.0))
        return w

    def unrolled(self, u: ArrayLike) -> np.ndarray:
        """Length along the surface, m, from u = 0 to each u."""
        return self._length(np.asarray(u, dtype=float)) - self._length(np.zeros(()))

    def _length(self, u: np.ndarray) -> np.ndarray:
        """Length from the first end to each u."""
        total = np.zeros(u.shape)
        for piece in self.pieces:
            (first, _), (last, _) = piece.ends
            until = np.clip(u, first, last)
            if piece.kind == _STRAIGHT:
                total += (until - first) / piece.direction[0]
            elif piece.extent > 0.0:
                angles = [
                    np.arcsin(np.clip((x - piece.at[0]) / piece.extent, -1.0, 1.0)) for x in (until, first)
                ]
                total += piece.extent * (angles[0] - angles[1])
        return total

    def landmarks(self) -> np.ndarray:
        """(n,) growing u, m, of the pieces' ends and of points along the arcs, fit for drawing."""
        ends = [end[0] for piece in self.pieces for end in piece.ends]
        for piece in self.pieces:
            if piece.kind != _STRAIGHT:
                ends += np.linspace(piece.ends[0][0], piece.ends[1][0], 9)[1:-1].tolist()
        ends = np.sort(ends)
        return ends[np.concatenate([[True], np.diff(ends) > 1e-6])]

    @property
    def tightest_hollow(self) -> float:
        """Smallest radius of a hollow, m: 0 for a sharp hollow corner, infinite if there is no hollow."""
        return min((piece.extent for piece in self.pieces if piece.kind == _INWARD), default=math.inf)

    @property
    def numbers(self) -> np.ndarray:
        """Six of each piece: place, direction, extent and the cosine of its half angle."""
        return np.ravel([[*p.at, *p.direction, p.extent, math.cos(p.half_angle)] for p in self.pieces])

    @property
    def source(self) -> str:
        """The closest of the pieces, which are of these kinds."""
        return _source(tuple(piece.kind for piece in self.pieces))


@functools.lru_cache(maxsize=64)
def _source(kinds: tuple[float, ...]) -> str:
    numbers, point = ca.SX.sym("numbers", 6 * len(kinds)), ca.SX.sym("point", 3)
    best, normal_u, normal_w = ca.SX(_NOWHERE), ca.SX(0.0), ca.SX(0.0)
    for index, kind in enumerate(kinds):
        u, w, *piece = ca.vertsplit(numbers[6 * index : 6 * index + 6])
        here, nu, nw, distance = _touch(kind, point[1] - u, point[0] - w, piece)
        # A piece seen from behind lies beyond the one in front of it, so the nearest is the right one, from
        # either side.
        here = ca.logic_and(here, ca.fabs(distance) < ca.fabs(best))
        best, normal_u, normal_w = (
            where(here, new, old) for new, old in ((distance, best), (nu, normal_u), (nw, normal_w))
        )
    found = ca.vertcat(normal_w, normal_u, 0.0, best)
    return c_of_touch(ca.Function("shape", [numbers, point], [ca.densify(found)], {"cse": True}))


def _touch(kind: float, du: Any, dw: Any, piece: list[Any]) -> tuple[Any, Any, Any, Any]:
    """Whether a piece is the closest of its line or circle to a point; outward normal and signed distance.

    Args:
        kind: of the piece.
        du: from the piece's place to the point, m.
        dw: the same along w.
        piece: direction (2), extent and cosine of the half angle.
    """
    tu, tw, extent, cosine = piece
    if kind == _STRAIGHT:
        along = du * tu + dw * tw
        # u grows along the piece and the outside is where w is smaller.
        return ca.logic_and(along >= -_SEAM, along <= extent + _SEAM), tw, -tu, du * tw + dw * -tu
    length = ca.sqrt(du * du + dw * dw)
    nu, nw = du / length, dw / length
    here = ca.logic_and(length >= 1e-12, nu * tu + nw * tw >= cosine - _SEAM)
    side = 1.0 if kind == _OUTWARD else -1.0
    return here, side * nu, side * nw, side * (length - extent)
