"""Writes the friction of the place where the tip is into the model, once a control tick.

What the friction is there is written once, in symbols: Python evaluates it (`PairFriction`), and the native
driver compiles the C that CasADi makes of it.
"""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING, NamedTuple

import casadi as ca
import numpy as np

from skylimb.base.bound_function import BoundFunction
from skylimb.simulation.contact_keys import PAIR_NAME
from skylimb.simulation.surfaces.friction_map import static_excess
from skylimb.simulation.surfaces.surface import Surface
from skylimb.symbolic import clip, dot, floor

if TYPE_CHECKING:
    import mujoco

_MOST_CELLS = 1000  # along one direction of the look-up table


class FrictionTable(NamedTuple):
    """Friction and adhesion of a surface sampled once, so that an update in flight is a look-up.

    Attributes:
        frictions: coefficients in cells over the surface's `size`, (along u, along v).
        adhesions: N, the same.
        numbers: what `friction_function` takes: the surface's origin (W, m), the axis along which it moves,
            its axes w, u and v (W, 3 each), half of its extent along u and v (m), counts of cells along them,
            and ratio and speed of `static_excess`, (21,).
        stiffness: N/m.
    """

    frictions: np.ndarray
    adhesions: np.ndarray
    numbers: np.ndarray
    stiffness: float


def friction_table(surface: Surface) -> FrictionTable:
    """Sample a surface at half its friction map's own blending width, or a thousandth of its size."""
    pitch = 0.5 * surface.friction_map.blend if surface.friction_map else np.inf
    cells = [min(_MOST_CELLS, max(1, math.ceil(extent / pitch))) for extent in surface.size]
    middles = [
        ((np.arange(n) + 0.5) / n - 0.5) * extent for n, extent in zip(cells, surface.size, strict=True)
    ]
    frictions, adhesions = surface.sliding_friction(*np.meshgrid(*middles, indexing="ij"))
    axes = (surface.position, surface.motion_axis, *surface.R_WS.T)
    half, slip = 0.5 * np.array(surface.size), (surface.static_ratio, surface.static_speed)
    numbers = np.concatenate([*axes, half, frictions.shape, slip])
    return FrictionTable(frictions, adhesions, numbers, surface.stiffness)


@functools.cache
def friction_function() -> ca.Function:
    """The cell of a friction table that the tip is over, and what its slip speed makes of the friction there.

    Of the table's numbers and of a tick: the tip's place and velocity (3 each, W),
    displacement and speed of the surface (`Surface.motion`). It gives the cell's index in the flat tables,
    and a factor on the friction there.
    """
    numbers, now = ca.SX.sym("numbers", 21), ca.SX.sym("now", 8)
    origin, axis, w, u, v, half, cells, stribeck = ca.vertsplit(numbers, [0, 3, 6, 9, 12, 15, 17, 19, 21])
    tip, velocity, displacement, speed = ca.vertsplit(now, [0, 3, 6, 7, 8])
    place = tip - origin - displacement * axis
    cell_u, cell_v = (
        clip(floor((0.5 + 0.5 * dot(place, along) / half[k]) * cells[k]), 0.0, cells[k] - 1.0)
        for k, along in enumerate((u, v))
    )
    slip = velocity - speed * axis
    across = dot(slip, w)
    # Slip is the tip's motion against the wall within the wall's flat plane.
    factor = static_excess(dot(slip, slip) - across * across, stribeck[0], stribeck[1])
    return ca.Function(
        "friction", [numbers, now], [ca.vertcat(cell_u * cells[1] + cell_v, factor)], {"cse": True}
    )


class PairFriction:
    """Friction and adhesion of one contact pair that follow the tip over a surface."""

    def __init__(self, model: mujoco.MjModel, surface: Surface) -> None:
        pair, table = model.pair(PAIR_NAME).id, friction_table(surface)
        self._friction, self._adhesion = model.pair_friction[pair], model.pair_adhesion[pair : pair + 1]
        self._gap, self._stiffness = model.pair_gap[pair : pair + 1], table.stiffness
        # Lists: an update has a microsecond or two.
        self._frictions, self._adhesions = table.frictions.ravel().tolist(), table.adhesions.ravel().tolist()
        self._now, self._found = np.zeros(8), np.zeros(2)
        self._bound = BoundFunction(friction_function(), [table.numbers, self._now], [self._found])

    def update(
        self,
        tip: tuple[float, ...] | np.ndarray,
        velocity: tuple[float, ...] | np.ndarray = (0.0, 0.0, 0.0),
        displacement: float = 0.0,
        wall_speed: float = 0.0,
    ) -> float:
        """Write friction and adhesion for a tip at `tip` (W, m) at `velocity` (W, m/s); returns the first.

        `displacement` (m) and `wall_speed` (m/s) are `Surface.motion` at this time.
        """
        now = self._now
        now[0:3], now[3:6], now[6], now[7] = tip, velocity, displacement, wall_speed
        self._bound.evaluate()
        cell, factor = self._found.tolist()
        friction = self._frictions[int(cell)] * factor
        self._friction[0] = self._friction[1] = friction
        adhesion = self._adhesions[int(cell)]
        if adhesion != self._adhesion[0]:
            self._adhesion[0], self._gap[0] = adhesion, adhesion / self._stiffness
        return friction
