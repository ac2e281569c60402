"""How well a flight kept to the normal force that it was commanded, and what kept it from that force.

A controller that commands a force logs it as `contact_force_reference` (N, 0 while no touch is wanted), and
what it presses with at the moment as `contact_force_target`: less where it eases the press. Everything here
is taken over the sliding period while a force is commanded. A pen that is off the surface presses with
nothing, and that counts.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from skylimb.analysis.signals import in_contact, in_phase, moving_mean

FORCE_WINDOW = 0.2
"""Seconds over which the force is averaged before its deviation is taken: slower than a pen's chatter."""

EASED = 0.98
"""The press counts as eased where the target is below this share of the commanded force."""

AT_LIMIT = 0.98
"""Share of its limit from which the integral of the force error counts as limited."""

TANK_LOW = 0.25
"""Share of its energy below which the tank makes the integral fade."""

_PATH_MOVES, _STICKS = 0.01, 0.1
"""A pen sticks that slides slower than this share of its path's speed, where that is at least so many m/s."""

_ROTOR_EDGE = 1e-3
"""A thrust counts as limited this close to its limit, as a share of its range."""


class Limit(NamedTuple):
    """Something that can keep a force from being reached: its name in the data, and in words."""

    name: str
    words: str


LIMITS = (
    Limit("eased", "pressed less because the pen lagged its path"),
    Limit("off_surface", "off the surface"),
    Limit("sticking", "stuck by friction"),
    Limit("rotors", "a rotor at its thrust limit"),
    Limit("integral", "the force integral at its limit"),
    Limit("tank", "the integral faded, its energy tank nearly empty"),
)
"""What is looked for, in the order in which it is told."""


def commanded(log: xr.Dataset) -> np.ndarray:
    """The samples of the sliding period at which a force is commanded: booleans, (time,)."""
    if not {"contact_force_reference", "contact_force_normal"} <= set(log.variables):
        return np.zeros(log.sizes["time"], dtype=bool)
    return in_phase(log, "slide") & (log.contact_force_reference.values > 0.0)


def force_scores(log: xr.Dataset) -> dict[str, float]:
    """The error of the normal force (truth) against the commanded one; empty where none is commanded.

    Returns:
        `force_error_mean` (N, negative for a force too small), `force_error_percent` (its size in % of the
        mean commanded force) and `force_error_rms` (N, of the 0.2 s mean of the error: what bias and slow
        swings make together, without chatter).
    """
    during = commanded(log)
    if not during.any():
        return {}
    wanted = log.contact_force_reference.values[during]
    error = log.contact_force_normal.values[during] - wanted
    slow = moving_mean(log.time.values[during], error, FORCE_WINDOW)
    return {
        "force_error_mean": float(np.mean(error)),
        "force_error_percent": 100.0 * abs(float(np.mean(error))) / float(np.mean(wanted)),
        "force_error_rms": float(np.sqrt(np.mean(slow**2))),
    }


def force_limits(log: xr.Dataset) -> dict[str, float]:
    """What kept the force from what was commanded, as data; empty where no force is commanded.

    Returns:
        The share of the time in which each of `LIMITS` held, as far as the log can tell; and `error_eased`,
        the part of the mean error that the law chose itself by pressing less (N). The rest of the mean error
        is what it did not reach.
    """
    during = commanded(log)
    if not during.any():
        return {}
    found = {name: float(np.mean(held[during])) for name, held in _held(log).items()}
    if "contact_force_target" in log:
        chosen = (log.contact_force_target - log.contact_force_reference).values
        found["error_eased"] = float(np.mean(np.where(in_contact(log), chosen, 0.0)[during]))
    return found


def _held(log: xr.Dataset) -> dict[str, np.ndarray]:
    """At which samples each of `LIMITS` held, (time,) each; those that the log cannot tell are left out."""
    touching = in_contact(log)
    held = {"off_surface": ~touching} if "contact" in log else {}
    if "contact_force_target" in log:
        target, wanted = log.contact_force_target.values, log.contact_force_reference.values
        held["eased"] = touching & (target < EASED * wanted)
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
    if "contact_force_integral_share" in log:
        held["integral"] = log.contact_force_integral_share.values > AT_LIMIT
    if "energy_tank_share" in log:
        held["tank"] = log.energy_tank_share.values < TANK_LOW
    return {limit.name: held[limit.name] for limit in LIMITS if limit.name in held}


TOLD_FROM = 0.05
"""Share of the time from which a limit is told in words."""


def limited_by(limits: Mapping[str, Any]) -> str:
    """The limits in words, the most lasting first; empty where none lasted.

    Args:
        limits: as `force_limits` gives them.
    """
    lasting = [each for each in LIMITS if limits.get(each.name, 0.0) >= TOLD_FROM]
    lasting.sort(key=lambda each: -limits[each.name])
    return ", ".join(f"{each.words} {100.0 * limits[each.name]:.0f} % of the time" for each in lasting)
