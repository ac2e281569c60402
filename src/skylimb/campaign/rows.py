"""A flight's row in the table, with a checksum that tells a damaged row from a good one."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

from skylimb.campaign.draws import Draw
from skylimb.campaign.frozen import Campaign

Row = dict[str, Any]

OK = "OK"
FAILED = "FAILED"
"""The flight was lost, or the controller's own code failed."""
REFUSED = "REFUSED"
"""The draw cannot be flown by anybody: the robot would start inside the surface, or the path leaves it."""
QUARANTINED = "QUARANTINED"
"""The flight killed its worker three times."""

LOST = (FAILED, QUARANTINED)

CHECKSUM = "checksum"

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
    """The row of a flight, sealed."""
    index, controller = campaign.split(flight)
    drawn = campaign.draw(index)
    row = {
        "flight": flight,
        "draw": index,
        "controller": controller,
        "seed": drawn.seed,
        **parameters(campaign, drawn),
        "status": status,
        "cause": cause,
        **{key: _finite(scores.get(key)) for key in campaign.spec.keys},
        "versions": versions_text(campaign),
    }
    return {**row, CHECKSUM: checksum(row)}


def versions_text(campaign: Campaign) -> str:
    """What computed a row, on one line."""
    return ", ".join(
        f"{name} {value}" for name, value in {**campaign.versions, "driver": campaign.driver}.items()
    )


def checksum(row: Mapping[str, Any]) -> str:
    """SHA-256 of a row without its checksum; floats enter with all their digits."""
    content = {key: value for key, value in row.items() if key != CHECKSUM}
    text = json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def is_sound(campaign: Campaign, row: Any) -> bool:
    """Whether a row is whole, unaltered, and of this campaign."""
    if not isinstance(row, dict) or not isinstance(row.get("flight"), int) or row["flight"] < 0:
        return False
    if row["flight"] >= campaign.flight(campaign.spec.draws, 0):
        return False
    try:
        if row.get(CHECKSUM) != checksum(row):
            return False
    except (TypeError, ValueError):
        return False
    index, controller = campaign.split(row["flight"])
    drawn = campaign.draw(index)
    expected = {"draw": index, "controller": controller, "seed": drawn.seed, **parameters(campaign, drawn)}
    return all(row.get(key) == value for key, value in expected.items())


def _finite(value: Any) -> float | None:
    return float(value) if value is not None and math.isfinite(value) else None
