"""How a flight pressed, how well it kept to the normal force that it was commanded, and what kept it from it.

A controller that commands a force logs it as `contact_force_reference` (N, 0 while no touch is wanted), and
what it presses with at the moment as `contact_force_target`: less where it eases the press. Errors and limits
are taken over the sliding period while a force is commanded. A pen that is off the surface presses with
nothing, and that counts.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from skylimb.analysis.recording.run import Run
from skylimb.analysis.scores.score import FORCE, Score, Tolerance, metric
from skylimb.analysis.scores.signals import (
    contact_axis,
    in_contact,
    in_phase,
    moving_mean,
    recorded,
    while_sliding,
)

if TYPE_CHECKING:
    import xarray as xr

FORCE_WINDOW = 0.2
"""Seconds over which the force is averaged before its deviation is taken: slower than a pen's chatter."""

PEAK_WINDOW = 0.010
"""Seconds over which the force is averaged before its peak is taken:

a single sample of a stiff contact says little.
"""

TOUCH_TIME = 1.0
"""Seconds from the first touch on that count as the touch."""

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
"""What is looked for, in the order in which words name them."""


def commanded(log: xr.Dataset) -> np.ndarray:
    """The samples of the sliding period at which a force is commanded: booleans, (time,)."""
    if not {"contact_force_reference", "contact_force_normal"} <= set(log.variables):
        return np.zeros(log.sizes["time"], dtype=bool)
    return in_phase(log, "slide") & (log.contact_force_reference.values > 0.0)


def _wanted(run: Run) -> float:
    """The mean commanded force, N."""
    during = commanded(run.log)
    return float(np.mean(run.log.contact_force_reference.values[during])) if during.any() else 0.0


def _missed_mean(run: Run) -> str:
    wanted, because = _wanted(run), limited_by(run.metrics["force_limits"])
    mean = wanted + run.metrics["force_error_mean"]
    because = f" ({because})" if because else ""
    return f"the mean force is {mean:.2f} of {wanted:.2f} N, {{value}} off, {{bound}} allowed{because}"


def _missed_swing(run: Run) -> str:
    return f"the force swings by {{value}} of {_wanted(run):.2f} N, {{bound}} allowed"


@metric(unit="N", group=FORCE, row="estimated in {signed}, median")
def estimated_force_median(run: Run) -> float:
    """Median estimated force in {signed}."""
    force = while_sliding(run.log, "external_force_estimate")
    return float(np.median(contact_axis(run.log).along(force)))


@metric(
    keys={
        "mean": Score("Mean normal contact force (truth)", "N", group=FORCE, row="normal (truth), mean"),
        "std": Score(
            "Standard deviation of the normal force (truth)",
            "N",
            smaller_is_better=True,
            group=FORCE,
            row="normal (truth), standard deviation",
        ),
        "peak": Score(
            f"Peak of the {1e3 * PEAK_WINDOW:g} ms mean of the normal force (truth)",
            "N",
            smaller_is_better=True,
            group=FORCE,
            row=f"normal (truth), peak of its {1e3 * PEAK_WINDOW:g} ms mean",
        ),
    }
)
def contact_force_normal(run: Run) -> dict[str, float]:
    """The normal contact force."""
    force = while_sliding(run.log, "contact_force_normal")
    peak = np.max(moving_mean(while_sliding(run.log, "time"), force, PEAK_WINDOW))
    return {"mean": float(np.mean(force)), "std": float(np.std(force)), "peak": float(peak)}


@metric(
    unit="N",
    smaller_is_better=True,
    group=FORCE,
    row="the same at the first touch",
    ranked=False,
    meaning=f"Peak of the {1e3 * PEAK_WINDOW:g} ms mean of the normal force at the first touch",
)
def touch_force_peak(run: Run) -> float:
    """Peak of the normal force at the first touch."""
    force, touching = recorded(run.log, "contact_force_normal"), in_contact(run.log)
    if not touching.any():
        return np.nan
    time, begin = run.log.time.values, run.log.time.values[np.argmax(touching)]
    first = (time >= begin) & (time < begin + TOUCH_TIME)
    return float(np.max(moving_mean(time[first], force[first], PEAK_WINDOW)))


@metric(
    keys={
        "mean": Score(
            "Mean error of the normal force (truth) against the commanded one",
            "N",
            group=FORCE,
            row="error against the commanded force, mean",
        ),
        "percent": Score(
            "Size of that mean error, of the commanded force",
            "%",
            smaller_is_better=True,
            group=FORCE,
            row="size of that mean error, of the commanded force",
            ranked=False,
            tolerance=Tolerance("force", _missed_mean, per=100.0),
        ),
        "rms": Score(
            f"Root mean square error of the {FORCE_WINDOW:g} s mean of the normal force (truth)",
            "N",
            smaller_is_better=True,
            group=FORCE,
            row=f"error of its {FORCE_WINDOW:g} s mean, root mean square",
            ranked=False,
            tolerance=Tolerance("force_swing", _missed_swing, per=_wanted),
        ),
    }
)
def force_error(run: Run) -> dict[str, float]:
    """The error of the normal force (truth) against the commanded one; no numbers where none is commanded.

    The mean is negative for a force too small. The root mean square is that of the 0.2 s mean of the error:
    what bias and slow swings make together, without chatter.
    """
    log, during = run.log, commanded(run.log)
    if not during.any():
        return dict.fromkeys(("mean", "percent", "rms"), np.nan)
    wanted = log.contact_force_reference.values[during]
    error = log.contact_force_normal.values[during] - wanted
    slow = moving_mean(log.time.values[during], error, FORCE_WINDOW)
    return {
        "mean": float(np.mean(error)),
        "percent": 100.0 * abs(float(np.mean(error))) / float(np.mean(wanted)),
        "rms": float(np.sqrt(np.mean(slow**2))),
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


NAMED_FROM = 0.05
"""Share of the time from which a limit is named in words."""


def limited_by(limits: Mapping[str, Any]) -> str:
    """The limits in words, the most lasting first; empty where none lasted.

    Args:
        limits: as `force_limits` gives them.
    """
    lasting = [each for each in LIMITS if limits.get(each.name, 0.0) >= NAMED_FROM]
    lasting.sort(key=lambda each: -limits[each.name])
    return ", ".join(f"{each.words} {100.0 * limits[each.name]:.0f} % of the time" for each in lasting)
