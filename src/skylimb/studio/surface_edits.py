"""What people do to the surface in flight, as entries of the experiment."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

from skylimb.errors import ConfigError
from skylimb.experiments.experiment import Experiment
from skylimb.simulation.surface_changes import SurfaceChange
from skylimb.simulation.surfaces import Surface

BLEND = 0.2
"""How long a surface takes to a new place, s."""

_POSE = ("position", "slope", "pitch", "roll")
_MATERIAL = ("friction", "stiffness")


def surface_keys_in_flight(experiment: Experiment) -> dict[str, Any]:
    """Keys of the surface that can change in flight, and what they come to with all changes so far."""
    surface = experiment.surface
    fixed = surface.friction_varies or surface.turns or surface.many
    names = () if fixed else _MATERIAL if surface.moves else (*_POSE, *_MATERIAL)
    found = {name: getattr(surface, name) for name in names}
    for change in sorted(experiment.surface_changes, key=lambda change: change.time):
        found |= {name: getattr(change, name) for name in names if getattr(change, name) is not None}
    return {f"surface.{name}": value for name, value in found.items()}


def surface_change(
    time: float,
    surface: Surface,
    moved: Sequence[float] | None = None,
    tilt: Sequence[float] | None = None,
    friction: float | None = None,
    stiffness: float | None = None,
    present: bool | None = None,
) -> SurfaceChange:
    """A change of the surface that begins at `time` (s).

    Args:
        time: since take-off, s.
        surface: as it was at take-off.
        moved: how far its origin is to be from where it was then, W, m, (3,).
        tilt: slope and pitch on top of those that it had then, rad; and roll where there is a third number.
        friction: Coulomb coefficient.
        stiffness: N/m.
        present: false takes the surface away.

    Raises:
        ConfigError: when a value cannot be.
    """
    pose: dict[str, Any] = {}
    for name, more in zip(("slope", "pitch", "roll"), tilt or (), strict=False):
        pose[name] = round(getattr(surface, name) + float(more), 9)
    if moved is not None:
        if len(moved) != 3:
            raise ConfigError(f"position has {len(moved)} numbers; it takes three")
        pose["position"] = tuple(round(a + float(b), 9) for a, b in zip(surface.position, moved, strict=True))
    return SurfaceChange(
        time=time, friction=friction, stiffness=stiffness, present=present, blend=BLEND, **pose
    )


def with_surface(experiment: Experiment, change: SurfaceChange) -> Experiment:
    """The experiment with one more change; what one of the same moment says otherwise is replaced."""
    last = experiment.surface_changes[-1:]
    if last and (last[0].time, last[0].blend) == (change.time, change.blend):
        names = (*_POSE, *_MATERIAL, "present")
        newer = {name: getattr(change, name) for name in names if getattr(change, name) is not None}
        merged = dataclasses.replace(last[0], **newer)
        return dataclasses.replace(experiment, surface_changes=(*experiment.surface_changes[:-1], merged))
    return dataclasses.replace(experiment, surface_changes=(*experiment.surface_changes, change))
