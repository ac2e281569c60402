"""How well the external force was estimated, held against what really pushed: touch and pushes.

What is estimated counts from the end of the tare on, as an estimator takes its bias off there. A touch counts
as felt once the estimate has been above `TOUCH` for `LASTS`, which is what the contact laws ask for.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from skylimb.analysis.recording.run import Run
from skylimb.analysis.scores.score import Score, metric
from skylimb.analysis.scores.signals import (
    NoNumberError,
    contact_axis,
    events_of,
    in_contact,
    in_phase,
    moving_mean,
    phase_names,
    recorded,
    spans,
)

if TYPE_CHECKING:
    import xarray as xr

TOUCH, LASTS = 0.5, 0.015
"""Force (N) that is felt as a touch, and how long it has to last, s."""

FORGIVEN = 0.5
"""Seconds after a true touch in which the estimate may still show it."""

SLOWEST = 2.0
"""Longest lag that is looked for, s."""

WINDOW = 0.2
"""Seconds over which the error is averaged before its size is taken: slower than a pen's chatter."""


@metric(
    on_demand="estimate",
    keys={
        "bias": Score(
            "Mean of the estimated less the true force along the contact axis while sliding",
            "N",
            ranked=False,
        ),
        "error_rms": Score(
            f"Error of the estimated force over {WINDOW:g} s, root mean square along the worst axis",
            "N",
            True,
            ranked=False,
        ),
        "lag": Score(
            "Time constant of the low pass that the estimated force is of the true one",
            "s",
            True,
            ranked=False,
        ),
        "noise": Score("Deviation of the estimated force in free flight", "N", True, ranked=False),
        "touch_late": Score(
            "Time from the first touch until the estimate shows it; never: no number", "s", True, ranked=False
        ),
        "false_touches": Score(
            "Times that the estimate shows a touch where there is none", "", True, kind="count", ranked=False
        ),
    },
)
def estimate(run: Run) -> dict[str, float]:
    """How far the estimated force is from the true one, how late, and what touch it makes of it."""
    log = run.log
    time, known = log.time.values, recorded(log, "external_force_estimate")
    true, touching = pushed(log), in_contact(log)
    counts = tared(log)
    sliding = in_phase(log, "slide") & touching
    off, axis = known - true, contact_axis(log)
    acts = np.linalg.norm(true, axis=1) > 0.0
    free = counts & ~_lately(time, acts, 1.0)
    return {
        "bias": float(axis.along(off[sliding]).mean()) if sliding.any() else np.nan,
        "error_rms": _size(time[counts], off[counts]),
        "lag": lag(time[counts], known[counts], true[counts]),
        "noise": float(np.sqrt(np.mean(known[free].var(axis=0)))) if free.sum() > 1 else np.nan,
        **_touch(time, axis.along(known), touching, acts, counts),
    }


def pushed(log: xr.Dataset) -> np.ndarray:
    """The true external force at every sample, W, N, (time, 3): of the surface and of pushes.

    Raises:
        NoNumberError: where it is not known, as in wind.
    """
    force, time = np.array(recorded(log, "contact_force"), dtype=float), log.time.values
    for event in events_of(log):
        if event.kind == "wind":
            raise NoNumberError("the force of wind")
        if event.kind == "push":
            # A push acts from its tick on; what is recorded at a tick is of the time before it.
            acts = (time > event.time + 1e-9) & (time < event.time + event.duration + 1e-9)
            force[acts] += np.asarray(event.table["force"], dtype=float)
    return force


def lag(time: np.ndarray, known: np.ndarray, true: np.ndarray) -> float:
    """By how much an estimate lags, s: the time constant of the low pass of the truth that it is most like.

    For an observer of first order that is the inverse of its gain; its bandwidth in Hz is 1 / (2 pi lag).

    Args:
        time: even, s, (n,).
        known: (n, 3).
        true: (n, 3); NaN comes out where nothing pushes.
    """
    if len(time) < 2 or not np.any(true.std(axis=0) > 0.0):
        return float("nan")
    dt = (time[-1] - time[0]) / (len(time) - 1)
    # Twice the length in zeros, so that what is filtered does not come round.
    spectrum = np.fft.rfft(true, 2 * len(true), axis=0)
    back = np.exp(-1j * np.linspace(0.0, np.pi, len(spectrum)))[:, None]

    def misfit(constant: float) -> float:
        decay = np.exp(-dt / constant)
        passed = spectrum * (1.0 - decay) / (1.0 - decay * back)
        off = known - np.fft.irfft(passed, 2 * len(true), axis=0)[: len(true)]
        return float(np.sum(off.var(axis=0)))

    constants = np.geomspace(0.2 * dt, SLOWEST, 40)
    for _ in range(2):
        best = int(np.argmin([misfit(constant) for constant in constants]))
        ends = constants[max(best - 1, 0)], constants[min(best + 1, len(constants) - 1)]
        constants = np.linspace(*ends, 20)
    return float(constants[np.argmin([misfit(constant) for constant in constants])])


def tared(log: xr.Dataset) -> np.ndarray:
    """At which samples the tare is over."""
    taken = in_phase(log, "tare") if "tare" in phase_names(log) else np.zeros(log.sizes["time"], dtype=bool)
    after = int(np.flatnonzero(taken)[-1]) + 1 if taken.any() else 0
    return np.arange(len(taken)) >= after


def _lately(time: np.ndarray, mask: np.ndarray, window: float) -> np.ndarray:
    """Where the mask has held within the last `window` seconds."""
    last = np.maximum.accumulate(np.where(mask, time, -np.inf))
    return time - last < window


def _size(time: np.ndarray, off: np.ndarray) -> float:
    if len(time) < 2:
        return float("nan")
    means = [moving_mean(time, off[:, k], WINDOW) for k in range(3)]
    return float(max(np.sqrt(np.mean(mean**2)) for mean in means))


def _touch(
    time: np.ndarray, along: np.ndarray, touching: np.ndarray, acts: np.ndarray, counts: np.ndarray
) -> dict[str, float]:
    """When the estimate shows the first touch, and how often one that is none."""
    felt = [(begin, end) for begin, end in spans(time, (-along > TOUCH) & counts) if end - begin >= LASTS]
    near = _lately(time, acts, FORGIVEN)
    false = sum(not near[np.searchsorted(time, begin)] for begin, _ in felt)
    if not touching.any():
        return {"touch_late": float("nan"), "false_touches": float(false)}
    first = time[np.argmax(touching)]
    shown = [max(begin + LASTS, first) for begin, end in felt if end > first]
    return {"touch_late": shown[0] - first if shown else np.nan, "false_touches": float(false)}
