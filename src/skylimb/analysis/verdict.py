"""Whether a flight did what it was commanded, within the tolerances that its experiment states.

A flight that comes to its end has the status OK. That says nothing of what it did there. Its verdict does:
the pen touches, keeps to its reference line, draws all of it, and presses with the commanded force where the
controller commands one. A flight that is to touch nothing has no verdict. A lost flight did not do what was
commanded, whatever it did before.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from skylimb.analysis.force import commanded, limited_by
from skylimb.analysis.pen_line import drawn_fraction
from skylimb.analysis.task import task_parts


class Check(NamedTuple):
    """One thing that was commanded.

    Attributes:
        name: of the tolerance.
        value: what the flight reached, in the tolerance's unit.
        tolerance: its bound.
        kept: whether the value keeps it.
        words: what was missed, by how much.
    """

    name: str
    value: float
    tolerance: float
    kept: bool
    words: str


class Verdict(NamedTuple):
    """Whether it was done as commanded.

    Attributes:
        done: None where nothing was commanded that could be judged.
        missed: what was missed and by how much, in words.
        checks: all that was judged.
    """

    done: bool | None
    missed: tuple[str, ...]
    checks: tuple[Check, ...]


def verdict(log: xr.Dataset, scores: Mapping[str, Any], limits: Mapping[str, Any]) -> Verdict:
    """The verdict on a flight.

    Args:
        log: its log; the attribute `tolerances` (JSON) says what is commanded, a flight without contact has
            none.
        scores: its figures of merit, as `metrics` gives them.
        limits: as `force_limits` gives them.
    """
    tolerances = json.loads(log.attrs.get("tolerances", "{}"))
    if not tolerances:
        return Verdict(None, (), ())
    if str(log.attrs.get("status", "OK")) != "OK":
        return Verdict(False, ("the flight was lost",), ())
    checks = tuple(_checks(log, tolerances, scores, limits))
    missed = tuple(check.words for check in checks if not check.kept)
    return Verdict(not missed if checks else None, missed, checks)


def _checks(
    log: xr.Dataset, tolerances: Mapping[str, float], scores: Mapping[str, Any], limits: Mapping[str, Any]
) -> Iterator[Check]:
    during = commanded(log)
    if during.any():
        wanted = float(np.mean(log.contact_force_reference.values[during]))
        because = limited_by(limits)
        because = f" ({because})" if because else ""
        off, allowed = scores["force_error_percent"] / 100.0, tolerances["force"]
        words = (
            f"the mean force is {wanted + scores['force_error_mean']:.2f} of {wanted:.2f} N, "
            f"{_percent(off)} off, {_percent(allowed)} allowed{because}"
        )
        yield Check("force", off, allowed, off <= allowed, words)
        swing, allowed = scores["force_error_rms"] / wanted, tolerances["force_swing"]
        words = f"the force swings by {_percent(swing)} of {wanted:.2f} N, {_percent(allowed)} allowed"
        yield Check("force_swing", swing, allowed, swing <= allowed, words)
    touch, least = scores.get("contact_fraction"), tolerances["contact"]
    if touch is not None:
        words = f"the pen touches {_percent(touch)} of the time, {_percent(least)} commanded"
        yield Check("contact", touch, least, touch >= least, words)
    within, rms = tolerances["pen_line"], scores.get("pen_line_rms")
    if rms is not None:
        words = f"the pen is {1e3 * rms:.1f} mm off its line (root mean square), {1e3 * within:g} mm allowed"
        yield Check("pen_line", rms, within, rms <= within, words)
    drawn, least = drawn_fraction(log, within), tolerances["path"]
    if np.isfinite(drawn):
        words = (
            f"{_percent(drawn)} of the line is drawn within {1e3 * within:g} mm, {_percent(least)} commanded"
        )
        yield Check("path", drawn, least, drawn >= least, words)
    yield from _of_a_drawing(tolerances, scores)
    for part in task_parts(tolerances, scores):
        yield Check(part.tolerance, part.score, tolerances[part.tolerance], part.kept, part.words)


def _of_a_drawing(tolerances: Mapping[str, float], scores: Mapping[str, Any]) -> Iterator[Check]:
    """Its strokes in their order, and nothing besides."""
    leash, most = scores.get("line_frechet"), tolerances["frechet"]
    if leash is not None:
        words = (
            f"the drawing is {1e3 * leash:.1f} mm from its reference in the strokes' order (Frechet), "
            f"{1e3 * most:g} mm allowed"
        )
        yield Check("frechet", leash, most, leash <= most, words)
    lifted, most = scores.get("lift_time"), tolerances["lifted"]
    if lifted:
        touch = scores["lift_touch_time"] / lifted
        words = f"the pen touches {_percent(touch)} of the time of its lifts, {_percent(most)} allowed"
        yield Check("lifted", touch, most, touch <= most, words)


def _percent(share: float) -> str:
    """A share in words; one place where rounding would hide that it is not all."""
    return f"{100.0 * share:.1f} %" if 0.99 <= share < 1.0 else f"{100.0 * share:.0f} %"
