"""The gains of a live flight: which there are, which change in flight, and what they have become."""

from __future__ import annotations

from typing import Any

from skylimb.control.controller import is_configurable, is_traceable
from skylimb.experiments.experiment import Experiment
from skylimb.packing import Layout
from skylimb.studio.live_flight import LiveFlight


def gain_keys(flight: LiveFlight) -> list[str]:
    """Keys of the gains of a flight's controller that may be set; none names a file."""
    controller = flight.takeoff.controller
    if not is_configurable(controller):
        return []
    return [
        ".".join((*table.path, name))
        for table in controller.key_tables()
        if table.given
        for name, _, info in table.rows
        if not info.key.file
    ]


def changes_in_flight(flight: LiveFlight, key: str) -> bool:
    """Whether a gain can change without a new take-off."""
    controller = flight.takeoff.controller
    return is_traceable(controller) and key in Layout(controller.gains()).slices and flight.time < flight.end


def settled_gains(experiment: Experiment, first: Experiment | None = None) -> dict[str, Any]:
    """What every gain that changes in flight comes to, without those that change in `first` as well."""
    before = {id(change) for change in first.gain_changes} if first else set()
    changes = sorted(experiment.gain_changes, key=lambda change: change.time)
    return {change.key: change.value for change in changes if id(change) not in before}
