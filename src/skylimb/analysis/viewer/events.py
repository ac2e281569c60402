"""What happened to a flight, as a page shows it: marks along the time, and arrows for pushes."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import xarray as xr

from skylimb.analysis.scores.signals import HappenedEvent, events_of
from skylimb.analysis.viewer.packing import packed


def packed_events(model: mujoco.MjModel, log: xr.Dataset, samples: np.ndarray) -> dict[str, Any]:
    """The events of a flight for a page.

    Args:
        model: of the scene.
        log: of the flight.
        samples: of the log, at which the page knows where things are.

    Returns:
        `events`: number (from 1), kind, time and duration (s) and words of each, and of a push with a force
        also `push`: the force (N, W), the link's name and body, and the point in its axes (m); without a link
        it acts at the centre of gravity. `cog`: that centre at the samples, W, m; None where not needed.
    """
    found = [
        {
            "number": number,
            "kind": event.kind,
            "time": event.time,
            "duration": event.duration,
            "words": event.words,
            "push": _push(model, event),
        }
        for number, event in enumerate(events_of(log), 1)
    ]
    central = any(each["push"] and not each["push"]["link"] for each in found)
    return {"events": found, "cog": packed(log.cog_position.values[samples]) if central else None}


def _push(model: mujoco.MjModel, event: HappenedEvent) -> dict[str, Any] | None:
    if event.kind != "push" or not any(event.table["force"]):
        return None
    link = event.table["link"]
    return {
        "force": event.table["force"],
        "link": link,
        "body": int(model.body(link).id) if link else None,
        "point": event.table["point"],
    }
