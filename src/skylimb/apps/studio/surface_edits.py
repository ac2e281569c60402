"""What people do to the surface in flight, as entries of the experiment."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

from skylimb.apps.studio.changes import with_events
from skylimb.base.errors import ConfigError
from skylimb.flight.events import SurfaceChange
from skylimb.flight.events.surface import MATERIAL_KEYS, POSE_KEYS
from skylimb.flight.experiments.experiment import Experiment
from skylimb.simulation.surfaces import Surface

DURATION = 0.2
"""How long a surface takes to a new place, s."""


def surface_keys_in_flight(experiment: Experiment) -> dict[str, Any]:
    """Keys of the surface that can change in flight, and what they come to with all changes so far."""
    surface = experiment.surface
    fixed = surface.friction_varies or surface.turns or surface.many
    names = () if fixed else MATERIAL_KEYS if surface.moves else (*POSE_KEYS, *MATERIAL_KEYS)
    found = {name: getattr(surface, name) for name in names}
    for change in sorted(_changes(experiment), key=lambda change: change.time):
        found |= {name: value for name, value in change.changed.items() if name in names}
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
        time, friction=friction, stiffness=stiffness, present=present, duration=DURATION, **pose
    )


def with_surface(experiment: Experiment, change: SurfaceChange) -> Experiment:
    """The experiment with one more change; what one of the same moment says otherwise is replaced."""
    last = _changes(experiment)[-1:]
    if last and (last[0].time, last[0].duration) == (change.time, change.duration):
        return with_events(experiment, dataclasses.replace(last[0], **change.changed), without=last)
    return with_events(experiment, change)


def _changes(experiment: Experiment) -> list[SurfaceChange]:
    return [event for event in experiment.events if isinstance(event, SurfaceChange)]
