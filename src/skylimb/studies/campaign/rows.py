"""A flight's row in the table."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from skylimb.analysis.recording.run import FAILED, OK, STOPPED, UNFINISHED
from skylimb.studies.campaign.draws import Draw
from skylimb.studies.campaign.frozen import Campaign

Row = dict[str, Any]

REFUSED = "REFUSED"
"""The controller cannot fly the draw, as the robot would start inside the surface, for one."""
QUARANTINED = "QUARANTINED"
"""The flight killed its worker three times."""

FINISHED = (OK, STOPPED)
"""The flight went on for as long as its experiment wants."""
BROKEN_OFF = (FAILED, UNFINISHED)
"""It ended before that, or its time was over before its mission was."""
FLOWN = (*FINISHED, *BROKEN_OFF)
"""There is a log of it."""
LOST = (*BROKEN_OFF, QUARANTINED)
"""No number of the flight counts; nothing is as bad."""

_SIMPLE = {int, float, bool, str}


def parameters(campaign: Campaign, drawn: Draw) -> Row:
    """Columns of what was drawn: one a number, `key.0`, `key.1` for the entries of a list.

    A column holds one kind of value in every row: whole numbers only where all that can be drawn are whole,
    and JSON text where the values are of several kinds.
    """
    columns: Row = {}
    for key, value in drawn.values.items():
        columns |= _columns(key, value, campaign.spec.vary[key].extremes())
    return columns


def parameter_names(campaign: Campaign) -> list[str]:
    """The columns of what is drawn, in order."""
    return list(parameters(campaign, campaign.draw(0)))


def _columns(key: str, value: Any, ends: Sequence[Any]) -> Row:
    kinds = {type(end) for end in ends}
    if kinds <= {list} and len({len(end) for end in ends}) == 1 and value:
        columns: Row = {}
        for index, entry in enumerate(value):
            columns |= _columns(f"{key}.{index}", entry, [end[index] for end in ends])
        return columns
    if kinds == {int, float}:
        return {key: float(value)}
    return {key: value if len(kinds) == 1 and kinds <= _SIMPLE else json.dumps(value)}


def make_row(campaign: Campaign, flight: int, status: str, cause: str, scores: Mapping[str, Any]) -> Row:
    """The row of a flight."""
    index, controller = campaign.split(flight)
    drawn = campaign.draw(index)
    return {
        "flight": flight,
        "draw": index,
        "controller": controller,
        "seed": drawn.seed,
        **parameters(campaign, drawn),
        "status": status,
        "cause": cause,
        **{key: _finite(scores.get(key)) for key in campaign.spec.keys},
        "versions": ", ".join(f"{name} {version}" for name, version in campaign.versions.items()),
    }


def unscored(rows: Iterable[Row]) -> str:
    """How many flights lack a number as a metric of the user's failed, and why the first of them does."""
    lacking = [row for row in rows if row["status"] in FINISHED and row["cause"].startswith("metric '")]
    if not lacking:
        return ""
    first = lacking[0]
    flights = f"{len(lacking)} flight{'s' * (len(lacking) > 1)} lack{'s' * (len(lacking) == 1)} numbers"
    return f"{flights}; flight {first['flight']} ({first['controller']}): {first['cause']}"


def _finite(value: Any) -> float | None:
    return float(value) if value is not None and math.isfinite(value) else None
