"""The scores of a flight, with its verdict.

A flight that failed is not scored: its numbers would be those of a shorter, easier task.
"""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from skylimb.analysis.recording.run import Run
from skylimb.analysis.scores.drawn_strokes import DRAWN
from skylimb.analysis.scores.force_limits import force_limits
from skylimb.analysis.scores.registry import METRICS, NUMERIC_KEYS, numbers_of
from skylimb.analysis.scores.score import Number, Score
from skylimb.analysis.scores.strokes import Stroke, drawn_line
from skylimb.analysis.scores.verdict import verdict

if TYPE_CHECKING:
    import xarray as xr


def metrics(log: xr.Dataset) -> dict[str, Any]:
    """The scores of a flight over the sliding period (phase "slide"), in SI.

    Args:
        log: a run's log; the contact direction and the sliding directions come from its attributes
            `contact_axis` and `sliding_axes` (x, and y and z, where it doesn't say).

    Returns:
        `status` and the `NUMERIC_KEYS`; `skylimb.analysis.scores.registry.SCORES` says what each is. A number
        is None where the log lacks its signal or has no sliding period. A failed flight has `status`, `cause`
        and no numbers.

        Besides: `missed`, what was not done as commanded, in words; `checks`, value and tolerance of each
        thing that was judged; `force_limits`, what limited a commanded force
        (`skylimb.analysis.scores.force`); and of a drawing `strokes`, each by itself
        (`skylimb.analysis.scores.drawn_strokes`).
    """
    drawn = None if Run("", "", log).failed else drawn_line(log)
    run = Run("", "", log, {DRAWN: drawn})
    numbers = numbers_of(run, [each for each in METRICS if not each.on_demand])
    found: dict[str, Any] = {
        "status": run.status,
        **({"cause": run.cause} if run.cause else {}),
        **{key: numbers.get(key) for key in NUMERIC_KEYS},
        "missed": [],
        "checks": {},
        "force_limits": {} if run.failed else force_limits(log),
        "strokes": [_numbers(stroke) for stroke in drawn.strokes] if drawn else [],
    }
    scores = [score for each in METRICS for score in each.scores]
    return {**found, **verdict(Run("", "", log, found), scores)}


def _numbers(stroke: Stroke) -> dict[str, Number]:
    return {
        name: value if isinstance(value, bool) else Score().number(value)
        for name, value in asdict(stroke).items()
    }
