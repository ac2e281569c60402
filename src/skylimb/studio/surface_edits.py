"""What people do to the surface in flight, as entries of the experiment."""

from __future__ import annotations

from typing import Any

from skylimb.experiments.experiment import Experiment


def surface_keys_in_flight(experiment: Experiment, time: float) -> dict[str, Any]:
    """Keys of the surface that can change in flight, and what they are at `time` (s)."""
    return {}
