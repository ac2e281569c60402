"""A surface that is moved, tilted, taken away or made of something else in flight.

What the engine knows of a surface are a few numbers of its compiled model: place and attitude of a geom,
friction and compliance of a contact pair. They are written before a tick's physics, the same numbers for
every driver. The moved surface stands still at every tick: it pushes the tip away, but its speed neither
drags the tip along nor enters the contact's damper.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Annotated, NamedTuple

import mujoco
import numpy as np

from skylimb.errors import ConfigError
from skylimb.keys import Key, configuration
from skylimb.simulation.contact import PAIR_NAME, pair_compliance
from skylimb.simulation.surfaces import Surface
from skylimb.simulation.surfaces.placement import surface_rotation
from skylimb.simulation.surfaces.surface import GEOM
from skylimb.spatial import quaternion_from_rotation

if TYPE_CHECKING:
    from skylimb.simulation.plant import Plant

_Vector = tuple[float, float, float]

_AWAY = 1000.0  # m by which a surface that was taken away lies behind its place
_POSE = ("position", "slope", "pitch", "roll")


@configuration
class SurfaceChange:
    """What becomes of the surface in flight; what is left out stays as it is."""

    time: Annotated[float, Key("s", "time since take-off at which the change begins", low=0.0, high=1e5)]
    position: Annotated[_Vector | None, Key("m", "where its origin moves to, W", low=-100.0, high=100.0)] = (
        None
    )
    slope: Annotated[float | None, Key("rad", "its new slope", low=-1.4, high=1.4)] = None
    pitch: Annotated[float | None, Key("rad", "its new pitch", low=-1.4, high=1.4)] = None
    roll: Annotated[float | None, Key("rad", "its new roll", low=-3.2, high=3.2)] = None
    friction: Annotated[float | None, Key("", "its new Coulomb coefficient", low=0.0, high=10.0)] = None
    stiffness: Annotated[float | None, Key("N/m", "its new normal stiffness", low=50.0, high=1e6)] = None
    present: Annotated[
        bool | None, Key("", "false takes it away, true brings it back; at once, without a blend")
    ] = None
    blend: Annotated[float, Key("s", "how long the change takes; 0 for a jump", low=0.0, high=1e4)] = 0.2

    def check(self) -> None:
        """Refuse a change of nothing."""
        if all(getattr(self, name) is None for name in _CHANGES):
            raise ConfigError(
                f"a change of the surface at {self.time:g} s changes nothing: give {_CHANGES[0]}, ..."
            )

    @property
    def moves(self) -> bool:
        """Whether the surface is somewhere else afterwards."""
        return any(getattr(self, name) is not None for name in _POSE)


_CHANGES = (*_POSE, "friction", "stiffness", "present")


class SurfaceState(NamedTuple):
    """What can change of a surface, as a row of a table.

    Attributes:
        position: its origin, W, m, (3,).
        slope: rad.
        pitch: rad.
        roll: rad.
        friction: Coulomb coefficient.
        stiffness: N/m.
        present: 1, or 0 where it is taken away.
    """

    position: np.ndarray
    slope: float
    pitch: float
    roll: float
    friction: float
    stiffness: float
    present: float


_COLUMNS = {
    "position": slice(0, 3),
    "slope": slice(3, 4),
    "pitch": slice(4, 5),
    "roll": slice(5, 6),
    "friction": slice(6, 7),
    "stiffness": slice(7, 8),
    "present": slice(8, 9),
}


def state_of(row: np.ndarray) -> SurfaceState:
    """A row of `surface_table` by name."""
    return SurfaceState(row[0:3], *map(float, row[3:9]))


def require_surface_changes(
    changes: Sequence[SurfaceChange], surface: Surface, model: mujoco.MjModel
) -> None:
    """Raise a `ConfigError` unless this surface can be changed like that in flight."""
    if changes and (surface.turns or surface.many):
        raise ConfigError(f"surface_changes: a surface of kind '{surface.kind}' cannot change in flight")
    if changes and model.npair > 1:
        raise ConfigError("surface_changes are written for one ball: not with a foot, plant.foot")
    for change in changes:
        at = f"surface_changes at {change.time:g} s"
        if change.moves and surface.moves:
            raise ConfigError(
                f"{at}: a surface that moves by itself cannot be moved or tilted in flight as well"
            )
        if surface.friction_varies:
            named = next(
                (name for name in (*_POSE, "friction", "stiffness") if getattr(change, name) is not None), ""
            )
            if named:
                why = "a friction_map" if surface.friction_map else "a static_ratio"
                raise ConfigError(
                    f"{at}: {named} cannot change in flight on a surface with {why}; present can"
                )
        if change.stiffness is not None:
            contact = dataclasses.replace(surface.contact, stiffness=change.stiffness)
            try:
                pair_compliance(model, contact)
            except ConfigError as error:
                raise ConfigError(f"{at}: {error}") from None


def surface_table(changes: Sequence[SurfaceChange], surface: Surface, times: np.ndarray) -> np.ndarray:
    """What the surface is at every tick, a `SurfaceState` a row, (ticks, 9).

    A change begins at what the surface is at its time, and comes to its new values as a smooth step.

    Args:
        changes: in any order.
        surface: as it is before take-off.
        times: of every tick that the flight may have, s.
    """
    first = np.array(
        [
            *surface.position,
            surface.slope,
            surface.pitch,
            surface.roll,
            surface.friction,
            surface.stiffness,
            1.0,
        ]
    )
    table = np.tile(first, (len(times), 1))
    ordered = sorted(changes, key=lambda change: change.time)
    for name, columns in _COLUMNS.items():
        own = [change for change in ordered if getattr(change, name) is not None]
        begins = [int(np.searchsorted(times, change.time - 1e-9)) for change in own]
        # Up to the next change of the same, which reads there where it begins.
        ends = [*begins[1:], len(times) - 1] if own else []
        for change, begin, end in zip(own, begins, ends, strict=True):
            if begin >= len(times):
                break
            rows = table[begin : end + 1, columns]
            blend = 0.0 if name == "present" else change.blend
            since = times[begin : end + 1] - change.time
            part = np.clip(since / blend, 0.0, 1.0) if blend > 0.0 else np.ones(len(since))
            part = (part * part * (3.0 - 2.0 * part))[:, None]
            before, after = rows[0].copy(), np.ravel(np.asarray(getattr(change, name), dtype=float))
            # Written so that it is the new value to the bit in the end.
            rows[:] = (1.0 - part) * before + part * after
    return table


class SurfaceWriter:
    """Writes what a surface is into a model: place and attitude of its geom, friction and compliance.

    Args:
        plant: with a model that belongs to one flight alone, into which nothing has been written yet.
    """

    NUMBERS = 11
    """Of `numbers`: place (3) and quaternion (4) of the geom, friction, both of solref, gap."""

    def __init__(self, plant: Plant) -> None:
        model, surface = plant.model, plant.surface
        self._model, self._surface = model, surface
        self._geom, self._pair = model.geom(GEOM).id, model.pair(PAIR_NAME).id
        # The engine takes a short cut for a geom that stands as its body does.
        model.geom_sameframe[self._geom] = 0
        self._first = surface_table((), surface, np.zeros(1))[0]
        self._numbers = np.concatenate(
            [
                model.geom_pos[self._geom],
                model.geom_quat[self._geom],
                model.pair_friction[self._pair, :1],
                model.pair_solref[self._pair],
                model.pair_gap[self._pair : self._pair + 1],
            ]
        )
        turned, origin = surface.R_WS.T, np.asarray(surface.position, dtype=float)
        if surface.moves:  # its body stands where the surface is, and its geom in the body's axes
            turned, origin = np.eye(3), np.zeros(3)
        self._place = turned @ (self._numbers[0:3] - origin)
        self._attitude = _product(quaternion_from_rotation(turned), self._numbers[3:7])

    def numbers(self, row: np.ndarray) -> np.ndarray:
        """The model's numbers of one row of the table, (11,)."""
        if np.array_equal(row, self._first):
            return self._numbers
        surface, now = self._surface, state_of(row)
        found = self._numbers.copy()
        R = surface_rotation(surface.contact_axis, now.slope, now.pitch, now.roll)
        if not np.array_equal(row[0:6], self._first[0:6]):
            found[0:3] = now.position + R @ self._place
            found[3:7] = _product(quaternion_from_rotation(R), self._attitude)
        if now.present < 1.0:
            behind = np.array([1.0, 0.0, 0.0]) if surface.moves else R[:, 0]
            found[0:3] += _AWAY * behind
        found[7] = now.friction
        if now.stiffness != surface.stiffness:
            contact = dataclasses.replace(surface.contact, stiffness=now.stiffness)
            found[8:11] = pair_compliance(self._model, contact)
        return found

    def write(self, numbers: np.ndarray) -> None:
        """Write the numbers of a row into the model."""
        model, geom, pair = self._model, self._geom, self._pair
        model.geom_pos[geom], model.geom_quat[geom] = numbers[0:3], numbers[3:7]
        if self._surface.friction_varies:  # what the place has is written there
            return
        model.pair_friction[pair, :2] = numbers[7]
        model.pair_solref[pair], model.pair_gap[pair] = numbers[8:10], numbers[10]

    def all_numbers(self, table: np.ndarray) -> np.ndarray:
        """The model's numbers at every tick, (ticks, 11)."""
        new = np.concatenate([[True], np.any(table[1:] != table[:-1], axis=1)])
        found = np.array([self.numbers(row) for row in table[new]])
        return found[np.cumsum(new) - 1]


def surface_act(writer: SurfaceWriter, table: np.ndarray) -> Callable[[int], None]:
    """A function that writes what the surface is at tick k, where that is not what it wrote last.

    Args:
        writer: into the flight's model.
        table: what the surface is at every tick (`surface_table`).
    """
    new = np.concatenate([[True], np.any(table[1:] != table[:-1], axis=1)])
    begun = False

    def write(k: int) -> None:
        nonlocal begun
        if new[k] or not begun:
            writer.write(writer.numbers(table[k]))
            begun = True

    return write


def _product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Product of two quaternions, as the engine computes it."""
    found = np.zeros(4)
    mujoco.mju_mulQuat(found, np.asarray(a, dtype=float), np.asarray(b, dtype=float))
    return found
