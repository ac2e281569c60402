"""What people do to the surface in flight, as entries of the experiment."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Any

from skylimb.apps.studio.changes import settled, with_events
from skylimb.base.errors import ConfigError
from skylimb.flight.events import SurfaceChange
from skylimb.flight.events.surface import MATERIAL_KEYS, POSE_KEYS
from skylimb.flight.experiments.experiment import Experiment
from skylimb.simulation.surfaces import Surface

DURATION = 0.2
"""How long a surface takes to a new place, s."""


def surface_now(experiment: Experiment, until: float = math.inf) -> dict[str, Any]:
    """What the surface comes to with all its changes that have begun by `until` (s), by the event's names."""
    surface = experiment.surface
    found = {name: getattr(surface, name) for name in (*POSE_KEYS, *MATERIAL_KEYS)} | {"present": True}
    for change in settled(SurfaceChange, experiment, until):
        found |= change.changed
    return found


def surface_keys_in_flight(surface: Surface) -> tuple[str, ...]:
    """Keys of an experiment's surface that can change in flight."""
    fixed = surface.friction_varies or surface.turns or surface.many
    names = () if fixed else MATERIAL_KEYS if surface.moves else (*POSE_KEYS, *MATERIAL_KEYS)
    return tuple(f"surface.{name}" for name in names)


def surface_change(
    time: float,
    experiment: Experiment,
    moved: Sequence[float | None] | None = None,
    tilt: Sequence[float | None] | None = None,
    **material: Any,
) -> SurfaceChange:
    """A change of the surface that begins at `time` (s).

    Args:
        time: since take-off, s.
        experiment: with all changes so far.
        moved: how far its origin is to be from where it was at take-off, W, m, (3,); a None stays as it is.
        tilt: slope and pitch on top of those at take-off, rad; and roll where there is a third number.
        material: friction, stiffness, and whether it is present.

    Raises:
        ConfigError: when a value cannot be.
    """
    surface, now = experiment.surface, surface_now(experiment, time)
    pose: dict[str, Any] = {}
    for name, more in zip(("slope", "pitch", "roll"), tilt or (), strict=False):
        if more is not None:
            pose[name] = round(getattr(surface, name) + float(more), 9)
    if moved is not None:
        if len(moved) != 3:
            raise ConfigError(f"position has {len(moved)} numbers; it takes three")
        entries = zip(surface.position, moved, now["position"], strict=True)
        pose["position"] = tuple(here if more is None else round(at + more, 9) for at, more, here in entries)
    return SurfaceChange(time, duration=DURATION, **pose, **material)


def with_surface(experiment: Experiment, change: SurfaceChange) -> Experiment:
    """The experiment with one more change; what one of the same moment says otherwise is replaced."""
    last = settled(SurfaceChange, experiment, change.time)[-1:]
    if last and (last[0].time, last[0].duration) == (change.time, change.duration):
        return with_events(experiment, dataclasses.replace(last[0], **change.changed), without=last)
    return with_events(experiment, change)
