"""The gains of a live flight: which there are, which change in flight, and what they have become."""

from __future__ import annotations

from typing import Any, NamedTuple

from skylimb.base.packing import Layout
from skylimb.control.controller import Controller, is_configurable, is_traceable
from skylimb.flight.events import GainChange
from skylimb.flight.experiments.experiment import Experiment


class GainKeys(NamedTuple):
    """Keys of a controller's gains.

    Attributes:
        settable: those that may be set; none names a file.
        in_flight: those that can change without a new take-off.
    """

    settable: frozenset[str]
    in_flight: frozenset[str]


def gain_keys(controller: Controller) -> GainKeys:
    """The keys of a controller's gains; some milliseconds of work."""
    if not is_configurable(controller):
        return GainKeys(frozenset(), frozenset())
    settable = frozenset(
        ".".join((*table.path, name))
        for table in controller.key_tables()
        if table.given
        for name, _, info in table.rows
        if not info.key.file
    )
    flown = Layout(controller.gains()).slices if is_traceable(controller) else {}
    return GainKeys(settable, settable & flown.keys())


def settled_gains(experiment: Experiment, first: Experiment | None = None) -> dict[str, Any]:
    """What every gain that changes in flight comes to, without those that change in `first` as well."""
    before = {id(event) for event in first.events} if first else set()
    gains = (event for event in experiment.events if isinstance(event, GainChange))
    changes = sorted(gains, key=lambda change: change.time)
    return {change.key: change.value for change in changes if id(change) not in before}
