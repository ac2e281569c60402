"""When a calibration was made: in its file, as a file's own date is that of its last copy."""

from __future__ import annotations

import math
from datetime import UTC, datetime
from pathlib import Path

from skylimb.base.config import parse_toml
from skylimb.base.sources import read_source

MADE = "made"
"""Its key in a calibration.toml."""


def dated(text: str) -> str:
    """The text of a calibration.toml that is made now, and says so."""
    return f"{MADE} = {datetime.now(UTC).isoformat()}\n{text}"


def age_of(path: str | Path) -> float:
    """Days since a calibration was made, negative where that is to come; NaN where it does not say."""
    made = parse_toml(read_source(path), path).get(MADE)
    if not isinstance(made, datetime):
        return math.nan
    return (datetime.now(UTC) - made.replace(tzinfo=made.tzinfo or UTC)).total_seconds() / 86400.0
