"""What people do to the surface in flight, as entries of the experiment."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

from skylimb.experiments.experiment import Experiment
from skylimb.simulation.surface_changes import SurfaceChange

BLEND = 0.2
"""How long a surface takes to a new place, s."""

_POSE = ("position", "slope", "pitch", "roll")
_MATERIAL = ("friction", "stiffness")


def surface_keys_in_flight(experiment: Experiment) -> dict[str, Any]:
    """Keys of the surface that can change in flight, and what they come to with all changes so far."""
    surface = experiment.surface
    names = () if surface.friction_varies else _MATERIAL if surface.moves else (*_POSE, *_MATERIAL)
    found = {name: getattr(surface, name) for name in names}
    for change in sorted(experiment.surface_changes, key=lambda change: change.time):
        found |= {name: getattr(change, name) for name in names if getattr(change, name) is not None}
    return {f"surface.{name}": value for name, value in found.items()}


def surface_change(
    time: float,
    position: Sequence[float] | None = None,
    tilt: Sequence[float] | None = None,
    friction: float | None = None,
    stiffness: float | None = None,
    present: bool | None = None,
) -> SurfaceChange:
    """A change of the surface that begins at `time` (s).

    Args:
        time: since take-off, s.
        position: of the surface's origin, W, m, (3,).
        tilt: slope and pitch, rad, and roll where there is a third number.
        friction: Coulomb coefficient.
        stiffness: N/m.
        present: false takes the surface away.
    """
    angles = dict(zip(("slope", "pitch", "roll"), map(float, tilt or ()), strict=False))
    given = {"position": None if position is None else tuple(map(float, position)), "friction": friction}
    return SurfaceChange(time=time, **given, stiffness=stiffness, present=present, blend=BLEND, **angles)  # type: ignore[arg-type]


def with_surface(experiment: Experiment, change: SurfaceChange) -> Experiment:
    """The experiment with one more change; what one of the same moment says otherwise is replaced."""
    last = experiment.surface_changes[-1:]
    if last and (last[0].time, last[0].blend) == (change.time, change.blend):
        names = (*_POSE, *_MATERIAL, "present")
        newer = {name: getattr(change, name) for name in names if getattr(change, name) is not None}
        merged = dataclasses.replace(last[0], **newer)
        return dataclasses.replace(experiment, surface_changes=(*experiment.surface_changes[:-1], merged))
    return dataclasses.replace(experiment, surface_changes=(*experiment.surface_changes, change))
