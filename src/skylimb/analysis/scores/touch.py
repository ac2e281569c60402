"""Whether the tip touched over the sliding period, and how often it lost the surface."""

from __future__ import annotations

import json

import numpy as np

from skylimb.analysis.recording.run import Run
from skylimb.analysis.scores.score import CONTACT, Tolerance, metric
from skylimb.analysis.scores.signals import in_contact, in_phase, spans, while_sliding

LOSS_TIME = 0.050
"""Seconds without touch that count as a loss; a pen that skips over a rough patch is not lost."""

_TOUCH = {"contact_duty", "contact"}
"""Signals of which one tells the touch."""


@metric(
    smaller_is_better=False,
    group=CONTACT,
    row="fraction of the time in contact (truth)",
    tolerance=Tolerance(
        "contact",
        "the pen touches {value} of the time, {bound} commanded",
        required=lambda run: bool(_TOUCH & set(run.log.variables) and in_phase(run.log, "slide").any()),
    ),
)
def contact_fraction(run: Run) -> float:
    """Fraction of the time in contact (truth)."""
    # The duty counts physics steps and so does not depend on the control rate; the flag says "any touch in
    # the tick".
    touch = while_sliding(run.log, "contact_duty" if "contact_duty" in run.log else "contact")
    return float(np.mean(touch.astype(float)))


@metric(
    smaller_is_better=True,
    group=CONTACT,
    row=f"losses of touch for longer than {1e3 * LOSS_TIME:g} ms",
    kind="count",
    ranked=False,
    meaning=f"Times that the touch was lost for longer than {1e3 * LOSS_TIME:g} ms",
)
def contact_losses(run: Run) -> float:
    """Gaps that lasted; what was never touched cannot be lost."""
    log = run.log
    if not _TOUCH & set(log.variables):
        return np.nan
    time, touching = log.time.values, in_contact(log)
    touched = time[np.argmax(touching)] if touching.any() else np.inf
    gaps = spans(time, ~touching & in_phase(log, "slide"), 0.0)
    return float(sum(begin > touched and end - begin > LOSS_TIME for begin, end in gaps))


def _nearest(run: Run) -> tuple[str, float, float]:
    """The part that came nearest to the surface, by how much (m), and when (s); a NaN where none is known."""
    part, distance, time = json.loads(run.log.attrs.get("clearance", "null")) or ("", np.nan, np.nan)
    return part, distance, time


def _touching(run: Run) -> str:
    part, _, time = _nearest(run)
    return f"'{part}' is {{value}} from the surface at t = {time:.1f} s, where the tool alone may touch"


@metric(
    unit="m",
    smaller_is_better=False,
    group=CONTACT,
    row="least distance of a rotor's disc or a body from the surface",
    ranked=False,
    meaning="Least distance of any rotor's disc or body but the tool from the surface; negative behind it",
    tolerance=Tolerance("clearance", _touching),
)
def clearance(run: Run) -> float:
    """Least distance from the surface of all that is not to touch it."""
    return _nearest(run)[1]
