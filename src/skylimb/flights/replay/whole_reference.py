"""References that a log holds whole: of a flight whose way nobody knew before it, as its user steered it."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from skylimb.missions.frame import contact_frame
from skylimb.missions.mission import Mission
from skylimb.missions.reference import Reference
from skylimb.signals import Signal

_PREFIX = "whole_reference_"
_FIELDS = Reference._fields[:-1]

REFERENCE_SIGNALS = {
    f"{_PREFIX}{name}": Signal("", "", f"{name.replace('_', ' ')} of the reference", "reference")
    for name in _FIELDS
}


def reference_signals(reference: Reference) -> dict[str, Any]:
    """Every entry of a reference but `ahead`, by the name of its signal."""
    return {
        name: np.asarray(getattr(reference, field), dtype=float)
        for name, field in zip(REFERENCE_SIGNALS, _FIELDS, strict=True)
    }


def whole_mission(log: xr.Dataset, period: float) -> Mission | None:
    """The mission of a log with whole references, one row for every tick; None for any other log."""
    if not all(name in log.variables for name in REFERENCE_SIGNALS):
        return None
    entries = [np.asarray(log[name].values, dtype=float) for name in REFERENCE_SIGNALS]
    named: dict[str, Any] = dict(zip(_FIELDS, entries, strict=True))
    reference = Reference(**named)
    axis = np.asarray(reference.contact_axis)[0]
    frame = contact_frame((float(axis[0]), float(axis[1]), float(axis[2])))
    count = len(log.time)
    touched = bool(np.any(reference.touch))
    phase = np.zeros(count, dtype=int)
    return Mission(np.arange(count) * period, reference, phase, frame, entries[11], touched)
