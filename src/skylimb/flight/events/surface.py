"""A surface that is moved, tilted, taken away or made of something else in flight.

What the engine knows of a surface are a few numbers of its compiled model: place and attitude of a geom,
friction and compliance of a contact pair. They are written before a tick's physics, the same numbers for
every driver. The moved surface stands still at every tick: it pushes the tip away, but its speed neither
drags the tip along nor enters the contact's damper.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

import numpy as np

from skylimb.base.errors import ConfigError
from skylimb.base.keys import Key, brief, configuration, refused
from skylimb.base.rotations import quaternion_from_rotation, quaternion_product
from skylimb.flight.events.event import Change, Event, EventContext, ModelRows, Place, write_changes
from skylimb.simulation.contact_keys import PAIR_NAME
from skylimb.simulation.surface_state import COLUMNS, POSE, first_row, state_of
from skylimb.simulation.surfaces import Surface
from skylimb.simulation.surfaces.geom import GEOM
from skylimb.simulation.surfaces.placement import surface_rotation

if TYPE_CHECKING:
    from skylimb.simulation.plant import Plant

_Vector = tuple[float, float, float]

_AWAY = 1000.0  # m by which a surface that was taken away lies behind its place
POSE_KEYS = ("position", "slope", "pitch", "roll")
"""What says where a surface is and how it leans."""

MATERIAL_KEYS = ("friction", "stiffness")
"""What says of what it is made."""

_CHANGES = (*POSE_KEYS, *MATERIAL_KEYS, "present")


@configuration
class SurfaceChange(Event):
    """The surface becomes another; what is left out stays as it is."""

    kind: Literal["surface"] = field(default="surface", kw_only=True)
    position: Annotated[_Vector | None, Key("m", "where its origin moves to, W", low=-100.0, high=100.0)] = (
        None
    )
    slope: Annotated[float | None, Key("rad", "its new slope", low=-1.4, high=1.4)] = None
    pitch: Annotated[float | None, Key("rad", "its new pitch", low=-1.4, high=1.4)] = None
    roll: Annotated[float | None, Key("rad", "its new roll", low=-3.2, high=3.2)] = None
    friction: Annotated[float | None, Key("", "its new Coulomb coefficient", low=0.0, high=10.0)] = None
    stiffness: Annotated[float | None, Key("N/m", "its new normal stiffness", low=50.0, high=1e6)] = None
    present: Annotated[
        bool | None, Key("", "false takes it away, true brings it back; at once, whatever the duration")
    ] = None
    duration: Annotated[float, Key("s", "how long the change takes; 0: a jump", low=0.0, high=1e4)] = field(
        default=0.2, kw_only=True
    )

    on: ClassVar[Literal["controller", "plant"]] = "plant"

    def check(self) -> None:
        """Refuse a change of nothing."""
        super().check()
        if not self.changed:
            raise refused(self, "time", f"changes nothing: give {', '.join(_CHANGES[:-1])} or {_CHANGES[-1]}")

    @property
    def changed(self) -> dict[str, Any]:
        """What becomes otherwise, with its new value."""
        return {name: getattr(self, name) for name in _CHANGES if getattr(self, name) is not None}

    @property
    def moves(self) -> bool:
        """Whether the surface is somewhere else afterwards, or gone."""
        return bool(self.changed.keys() & {*POSE_KEYS, "present"})

    @property
    def words(self) -> str:
        """What becomes of it."""
        gone = {True: "back", False: "away"}
        said = [
            gone[bool(value)] if name == "present" else f"{name} to {brief(value)}"
            for name, value in self.changed.items()
        ]
        return f"surface {', '.join(said)}"

    def require(self, context: EventContext) -> None:
        """The surface may change like this, and the time step can carry its new stiffness."""
        surface, changed = context.surface, self.changed
        if surface.turns or surface.many:
            raise ConfigError(f"{self}: a surface of kind '{surface.kind}' cannot change in flight")
        if context.touches != "ball":
            raise ConfigError(
                f"{self} is written for one ball: not with a {context.touches}, plant.{context.touches}"
            )
        if surface.moves and changed.keys() & set(POSE_KEYS):
            raise ConfigError(
                f"{self}: a surface that moves by itself cannot be moved or tilted in flight as well"
            )
        air = context.plant.air if context.plant is not None else None
        if self.moves and air is not None and (air.loss or air.pull):
            raise ConfigError(
                f"{self}: {self.words}; but a surface that rotors feel (plant.wall_loss, plant.wall_pull) "
                "stays where it is"
            )
        named = next((name for name in changed if name != "present"), "")
        if surface.friction_varies and named:
            why = "a friction_map" if surface.friction_map else "a static_ratio"
            raise ConfigError(f"{self}: {named} cannot change in flight on a surface with {why}; present can")
        if self.stiffness is not None and context.plant is not None:
            try:
                context.plant.compliance(self.stiffness)
            except ConfigError as error:
                raise ConfigError(f"{self}: {error}") from None

    @classmethod
    def effect(cls, events: Sequence[SurfaceChange], context: EventContext, times: np.ndarray) -> ModelRows:
        """The engine's numbers of the surface at every tick."""
        assert context.plant is not None
        return model_rows(context.plant, surface_table(events, context.surface, times))


def surface_table(changes: Sequence[SurfaceChange], surface: Surface, times: np.ndarray) -> np.ndarray:
    """What the surface is at every tick, a `SurfaceState` a row, (ticks, 9).

    A change begins at what the surface is at its time, and comes to its new values as a smooth step.

    Args:
        changes: in any order.
        surface: as it is before take-off.
        times: of every tick that the flight may have, s.
    """
    table = np.tile(first_row(surface), (len(times), 1))
    for name, columns in COLUMNS.items():
        alike = [
            Change(one.time, 0.0 if name == "present" else one.duration, np.ravel(np.asarray(value, float)))
            for one in changes
            if (value := getattr(one, name)) is not None
        ]
        write_changes(table, columns, alike, times, smooth=True)
    return table


def model_rows(plant: Plant, table: np.ndarray) -> ModelRows:
    """The engine's numbers of a surface at every tick.

    Args:
        plant: as it is before take-off.
        table: what its surface is at every tick.
    """
    model = plant.model
    geom, pair = model.geom(GEOM).id, model.pair(PAIR_NAME).id
    places = [Place("geom_pos", geom, 3, 0), Place("geom_quat", geom, 4, 3)]
    if not plant.surface.friction_varies:  # what the place has is written there
        places += [
            Place("pair_friction", pair, 2, 7),
            Place("pair_solref", pair, 2, 9),
            Place("pair_gap", pair, 1, 11),
        ]
    surface = plant.surface
    first = np.concatenate([np.ravel(getattr(model, p.field)[p.row])[: p.entries] for p in places])
    initial, turned, origin = first_row(surface), surface.R_WS.T, np.asarray(surface.position, dtype=float)
    if surface.moves:  # its body stands where the surface is, and its geom in the body's axes
        turned, origin = np.eye(3), np.zeros(3)
    place = turned @ (first[0:3] - origin)
    attitude = quaternion_product(quaternion_from_rotation(turned), first[3:7])

    def numbers(row: np.ndarray) -> np.ndarray:
        """Place (3) and quaternion (4), friction (2), solref (2) and gap of a row."""
        if np.array_equal(row, initial):
            return first
        now, found = state_of(row), first.copy()
        R = surface_rotation(surface.contact_axis, now.slope, now.pitch, now.roll)
        if not np.array_equal(row[POSE], initial[POSE]):
            found[0:3] = now.position + R @ place
            found[3:7] = quaternion_product(quaternion_from_rotation(R), attitude)
        if now.present < 1.0:
            behind = np.array([1.0, 0.0, 0.0]) if surface.moves else R[:, 0]
            found[0:3] += _AWAY * behind
        if surface.friction_varies:
            return found
        found[7:9] = now.friction
        if now.stiffness != surface.stiffness:
            found[9:12] = plant.compliance(now.stiffness)
        return found

    new = np.concatenate([[True], np.any(table[1:] != table[:-1], axis=1)])
    found = np.array([numbers(row) for row in table[new]])
    return ModelRows(tuple(places), found[np.cumsum(new) - 1])
