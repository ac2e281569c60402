"""How a flight pressed, how well it kept to the normal force that it was commanded, and what kept it from it.

What was commanded says `skylimb.analysis.scores.commanded_force`; why a law presses as it does it logs as
`press_reason`. Errors are taken over the sliding period while a force is commanded. A pen that is off the
surface presses with nothing, and that counts.
"""

from __future__ import annotations

import numpy as np

from skylimb.analysis.recording.run import Run
from skylimb.analysis.scores.commanded_force import force_is_commanded, wanted_force, while_pressing
from skylimb.analysis.scores.force_limits import limited_by
from skylimb.analysis.scores.score import FORCE, Score, Tolerance, metric
from skylimb.analysis.scores.signals import (
    contact_axis,
    held_means,
    in_contact,
    in_phase,
    moving_mean,
    recorded,
    while_sliding,
)
from skylimb.base.signals import FORCE_REFERENCE

FORCE_WINDOW, SPREAD_WINDOW, PEAK_WINDOW = 0.2, 0.005, 0.010
"""Seconds over which the force is averaged: before its slow deviation is taken, slower than a pen's chatter;
before its spread, which has the chatter in it; and before its peak, as a single sample of a stiff contact
says little.
"""

TOUCH_TIME = 1.0
"""Seconds from the first touch on that count as the touch."""


def _wanted(run: Run) -> float:
    """The mean commanded force, N."""
    during = while_pressing(run.log)
    return float(np.mean(wanted_force(run.log)[during])) if during.any() else 0.0


def _required(run: Run) -> bool:
    """A force whose truth has a gap is not kept: nobody knows what it was there."""
    return force_is_commanded(run.log) or bool(while_pressing(run.log).any())


def _missed_mean(run: Run) -> str:
    wanted, because = _wanted(run), limited_by(run.metrics["force_limits"])
    mean = wanted + run.metrics["force_error_mean"]
    if FORCE_REFERENCE not in run.log:
        because = "the controller says of no force that it commands it"
    because = f" ({because})" if because else ""
    return f"the mean force is {mean:.2f} of {wanted:.2f} N, {{value}} off, {{bound}} allowed{because}"


def _missed_swing(run: Run) -> str:
    return f"the force swings by {{value}} of {_wanted(run):.2f} N, {{bound}} allowed"


def _missed_spread(run: Run) -> str:
    return f"the force hammers: it spreads by {{value}} of {_wanted(run):.2f} N, {{bound}} allowed"


def _missed_peak(run: Run) -> str:
    return f"the force hammers: a blow goes {{value}} of {_wanted(run):.2f} N beyond it, {{bound}} allowed"


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
    sliding, normal = in_phase(run.log, "slide"), recorded(run.log, "contact_force_normal")
    force, short = normal[sliding], held_means(run.log.time.values, normal, sliding, PEAK_WINDOW)
    return {"mean": float(np.mean(force)), "std": float(np.std(force)), "peak": float(short.max())}


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
        "spread": Score(
            f"Standard deviation of the error of the {1e3 * SPREAD_WINDOW:g} ms mean of the normal force "
            "(truth)",
            "N",
            smaller_is_better=True,
            group=FORCE,
            row=f"error of its {1e3 * SPREAD_WINDOW:g} ms mean, standard deviation",
            ranked=False,
            tolerance=Tolerance("force_spread", _missed_spread, per=_wanted, required=_required),
        ),
        "peak": Score(
            f"Greatest excess of the {1e3 * PEAK_WINDOW:g} ms mean of the normal force (truth) over the "
            "commanded one",
            "N",
            smaller_is_better=True,
            group=FORCE,
            row=f"greatest excess of its {1e3 * PEAK_WINDOW:g} ms mean",
            ranked=False,
            tolerance=Tolerance("force_peak", _missed_peak, per=_wanted, required=_required),
        ),
    }
)
def force_error(run: Run) -> dict[str, float]:
    """The error of the normal force (truth) against the commanded one; no numbers where none is commanded.

    The mean is negative for a force too small. The root mean square is that of the 0.2 s mean of the error:
    what bias and slow swings make together, without chatter. The spread is how widely its 5 ms mean
    strays, chatter and all, whatever the bias is.
    """
    log, during = run.log, while_pressing(run.log)
    if not during.any():
        return dict.fromkeys(("mean", "percent", "rms", "spread", "peak"), np.nan)
    time, wanted = log.time.values, wanted_force(log)
    error = log.contact_force_normal.values - wanted
    slow, fast, short = (
        held_means(time, error, during, window) for window in (FORCE_WINDOW, SPREAD_WINDOW, PEAK_WINDOW)
    )
    mean = float(np.mean(error[during]))
    return {
        "mean": mean,
        "percent": 100.0 * abs(mean) / float(np.mean(wanted[during])),
        "rms": float(np.sqrt(np.mean(slow**2))),
        "spread": float(np.std(fast)),
        "peak": max(float(short.max()), 0.0),
    }
