"""References that a log holds whole: of a flight whose way nobody knew before it, as its user steered it."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from skylimb.base.packing import flattened
from skylimb.base.signals import Signal
from skylimb.control.missions.frame import contact_frame
from skylimb.control.missions.mission import Mission
from skylimb.control.missions.reference import Reference

_PREFIX = "whole_reference_"
_FIELDS = Reference._fields[:-1]
_AHEAD = f"{_PREFIX}ahead"

_ENTRIES = {
    f"{_PREFIX}{name}": Signal("", "", f"{name.replace('_', ' ')} of the reference", "reference")
    for name in _FIELDS
}

REFERENCE_SIGNALS = {
    **_ENTRIES,
    _AHEAD: Signal("", "", "the references ahead, all entries of one after those of another", "reference"),
}


def reference_signals(reference: Reference) -> dict[str, Any]:
    """Every entry of a reference, by the name of its signal; those ahead as one row, where there are any."""
    signals = {
        name: np.asarray(getattr(reference, field), dtype=float)
        for name, field in zip(_ENTRIES, _FIELDS, strict=True)
    }
    if reference.ahead:
        signals[_AHEAD] = flattened(reference.entries[len(_FIELDS) :])
    return signals


def recorded_ahead(log: xr.Dataset, preview: int) -> np.ndarray | None:
    """The references ahead that were flown, packed as `pack_rows` does, (ticks, preview, width).

    Args:
        log: with whole references.
        preview: how many references ahead the controller wants.

    Returns:
        None where the log has none, or another number of them.
    """
    if _AHEAD not in log.variables or not preview:
        return None
    values = np.asarray(log[_AHEAD].values, dtype=float)
    width = sum(int(np.prod(log[name].shape[1:], dtype=int)) for name in _ENTRIES)
    return values.reshape(len(values), preview, width) if values.shape[1] == preview * width else None


def whole_mission(log: xr.Dataset, period: float) -> Mission | None:
    """The mission of a log with whole references, one row for every tick; None for any other log."""
    if not all(name in log.variables for name in _ENTRIES):
        return None
    entries = (np.asarray(log[name].values, dtype=float) for name in _ENTRIES)
    named: dict[str, Any] = dict(zip(_FIELDS, entries, strict=True))
    return mission_of_rows(Reference(**named), np.zeros(len(log.time), dtype=int), period)


def mission_of_rows(reference: Reference, phase: np.ndarray, period: float) -> Mission:
    """A mission with a row a tick: references and phase of each, (k, ...) and (k,)."""
    frame = contact_frame(tuple(np.asarray(reference.contact_axis)[0].tolist()))
    touched = bool(np.any(reference.touch))
    times = np.arange(len(phase)) * period
    return Mission(times, period, reference, phase, frame, reference.tip_position, touched)
