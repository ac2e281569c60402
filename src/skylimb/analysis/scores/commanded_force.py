"""The normal force that a flight was to press with, at every sample of its log.

Where the experiment commands a force (`trajectory.force`), the log has it as `contact_force_commanded`, which
no law can write, and that is what a flight is held to. Where it commands none, the law's own word stands
(`contact_force_reference`, N, 0 while no touch is wanted).

A press cannot come and go at once. So at both ends of a stroke the law's own ramp counts, but only between
the commanded force and a straight ramp over `RAMP`: a law that says it commands less is held to that ramp,
and past it to the whole force. A law that says nothing has no ramp, and a touch that is lost amid a stroke
has none.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from skylimb.analysis.scores.signals import in_phase, stretches
from skylimb.base.signals import FORCE_COMMANDED, FORCE_REFERENCE

if TYPE_CHECKING:
    import xarray as xr

RAMP = 2.0
"""Seconds after the beginning of a stroke, and before its end, in which a law may command less."""


def wanted_force(log: xr.Dataset) -> np.ndarray:
    """The normal force that is wanted at each sample, N, (time,); 0 where none is."""
    unsaid = np.full(log.sizes["time"], np.nan)
    own = log[FORCE_REFERENCE].values if FORCE_REFERENCE in log else unsaid
    if FORCE_COMMANDED not in log:
        return np.nan_to_num(own)
    commanded = np.nan_to_num(log[FORCE_COMMANDED].values)
    ramped = np.clip(np.where(np.isnan(own), commanded, own), commanded * slowest_ramp(log), commanded)
    return np.where(commanded > 0.0, ramped, np.nan_to_num(own))


def force_is_commanded(log: xr.Dataset) -> bool:
    """Whether the experiment commands a force while the pen slides."""
    if FORCE_COMMANDED not in log:
        return False
    return bool((np.nan_to_num(log[FORCE_COMMANDED].values)[in_phase(log, "slide")] > 0.0).any())


def while_pressing(log: xr.Dataset) -> np.ndarray:
    """At which samples of the sliding period a force is wanted, (time,); none without truth."""
    if "contact_force_normal" not in log:
        return np.zeros(log.sizes["time"], dtype=bool)
    return in_phase(log, "slide") & (wanted_force(log) > 0.0)


def slowest_ramp(log: xr.Dataset) -> np.ndarray:
    """Which share of the commanded force the slowest ramp has reached, (time,)."""
    share, time = np.ones(log.sizes["time"]), log.time.values
    for begin, end in stretches(in_phase(log, "slide")):
        within = np.minimum(time[begin:end] - time[begin], time[end - 1] - time[begin:end])
        share[begin:end] = np.clip(within / RAMP, 0.0, 1.0)
    return share
