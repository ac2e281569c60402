"""How a flight pressed, how well it kept to the normal force that it was commanded, and what kept it from it.

What was commanded says `skylimb.analysis.scores.commanded_force`; why a law presses as it does it logs as
`press_reason`. Errors are taken over the sliding period while a force is commanded. A pen that is off the
surface presses with nothing, and that counts.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from skylimb.analysis.recording.run import Run
from skylimb.analysis.scores.commanded_force import force_is_commanded, wanted_force, while_pressing
from skylimb.analysis.scores.score import FORCE, Score, Tolerance, metric
from skylimb.analysis.scores.signals import (
    contact_axis,
    flag_names,
    in_contact,
    moving_mean,
    recorded,
    while_sliding,
)
from skylimb.base.signals import FORCE_REFERENCE

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


def _wanted(run: Run) -> float:
    """The mean commanded force, N."""
    during = while_pressing(run.log)
    return float(np.mean(wanted_force(run.log)[during])) if during.any() else 0.0


def _required(run: Run) -> bool:
    return force_is_commanded(run.log)


def _missed_mean(run: Run) -> str:
    wanted, because = _wanted(run), limited_by(run.metrics["force_limits"])
    mean = wanted + run.metrics["force_error_mean"]
    if FORCE_REFERENCE not in run.log:
        because = "the controller says of no force that it commands it"
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
            tolerance=Tolerance("force", _missed_mean, per=100.0, required=_required),
        ),
        "rms": Score(
            f"Root mean square error of the {FORCE_WINDOW:g} s mean of the normal force (truth)",
            "N",
            smaller_is_better=True,
            group=FORCE,
            row=f"error of its {FORCE_WINDOW:g} s mean, root mean square",
            ranked=False,
            tolerance=Tolerance("force_swing", _missed_swing, per=_wanted, required=_required),
        ),
    }
)
def force_error(run: Run) -> dict[str, float]:
    """The error of the normal force (truth) against the commanded one; no numbers where none is commanded.

    The mean is negative for a force too small. The root mean square is that of the 0.2 s mean of the error:
    what bias and slow swings make together, without chatter.
    """
    log, during = run.log, while_pressing(run.log)
    if not during.any():
        return dict.fromkeys(("mean", "percent", "rms"), np.nan)
    wanted = wanted_force(log)[during]
    error = log.contact_force_normal.values[during] - wanted
    slow = moving_mean(log.time.values[during], error, FORCE_WINDOW)
    return {
        "mean": float(np.mean(error)),
        "percent": 100.0 * abs(float(np.mean(error))) / float(np.mean(wanted)),
        "rms": float(np.sqrt(np.mean(slow**2))),
    }


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
