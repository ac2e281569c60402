"""What kept the force from what was commanded: parts of the time and of the mean error, and their words."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from skylimb.analysis.scores.commanded_force import wanted_force, while_pressing
from skylimb.analysis.scores.signals import flag_names, in_contact

if TYPE_CHECKING:
    import xarray as xr

_PATH_MOVES, _STICKS = 0.01, 0.1
"""A pen sticks that slides slower than this share of its path's speed, where that is at least so many m/s."""

_ROTOR_EDGE = 1e-3
"""A thrust counts as limited this close to its limit, as a share of its range."""


WORDS = {
    "searching": "searching the surface",
    "off_surface": "off the surface",
    "loading": "the press was growing after a touch",
    "unloading": "the press was going before the pen left",
    "eased_for_lag": "the press was eased while the pen lagged its path",
    "saturated": "the law at its limits",
    "waiting": "waiting for a calm force",
    "sticking": "stuck by friction",
    "rotors": "a rotor at its thrust limit",
    "none": "for no reason that is known",
}
"""Why the force is not what is commanded, in words. At each moment the first one counts that holds, in this
order: a search, by the law's own word (`press_reason`); no touch; the law's other reasons; friction and
rotors as the simulation saw them.
"""


def force_limits(log: xr.Dataset) -> dict[str, dict[str, float]]:
    """What kept the force from what was commanded, as data; empty where no force is commanded.

    Returns:
        By the names of `WORDS`, as far as the log can tell: `share` of the time, and `error`, the part of the
        mean error (N) that came up in it. Shares add up to 1, parts to the mean error.
    """
    during = while_pressing(log)
    if not during.any():
        return {}
    error = (log.contact_force_normal.values - wanted_force(log))[during]
    free, found = np.ones(len(error), dtype=bool), {}
    for name, held in _held(log).items():
        here = free & held[during]
        free &= ~here
        found[name] = {"share": float(np.mean(here)), "error": float(np.mean(np.where(here, error, 0.0)))}
    return found


def _held(log: xr.Dataset) -> dict[str, np.ndarray]:
    """At which samples each of `WORDS` held, (time,) each; those that the log cannot tell are left out."""
    held = {name: log.press_reason.values == value for name, value in flag_names(log, "press_reason").items()}
    held.pop("as_commanded", None)
    touching = in_contact(log)
    if "contact" in log:
        held["off_surface"] = ~touching
    if {"slip_speed", "tip_position_reference"} <= set(log.variables):
        speed = np.linalg.norm(
            np.gradient(log.tip_position_reference.values, log.time.values, axis=0), axis=1
        )
        slip = np.nan_to_num(log.slip_speed.values)
        held["sticking"] = touching & (speed > _PATH_MOVES) & (slip < _STICKS * speed)
    if "thrust_limits" in log.attrs and "thrusts_command" in log:
        low, high = np.asarray(json.loads(log.attrs["thrust_limits"]), dtype=float)
        edge, thrusts = _ROTOR_EDGE * (high - low), log.thrusts_command.values
        held["rotors"] = ((thrusts < low + edge) | (thrusts > high - edge)).any(axis=1)
    held["none"] = np.ones(log.sizes["time"], dtype=bool)
    return {name: held[name] for name in WORDS if name in held}


NAMED_FROM = 0.1
"""Part of the mean error from which its reason is named in words."""


def limited_by(limits: Mapping[str, Mapping[str, float]]) -> str:
    """What made the mean error in words, the most of it first; what worked against it is no reason for it.

    Args:
        limits: as `force_limits` gives them.
    """
    whole = sum(each["error"] for each in limits.values())
    parts = {name: each["error"] / whole for name, each in limits.items() if whole and name != "none"}
    named = sorted((name for name in parts if parts[name] >= NAMED_FROM), key=lambda name: -parts[name])
    return ", ".join(
        f"{WORDS[name]} {100.0 * limits[name]['share']:.0f} % of the time: {limits[name]['error']:+.2f} N"
        for name in named
    )
