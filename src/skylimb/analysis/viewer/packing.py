"""Numbers over time as a few bytes: 16 bits each, differences from sample to sample, deflated, base64."""

from __future__ import annotations

import base64
import zlib
from typing import Any

import numpy as np

LEVELS = 65534
"""Steps between the lowest and the highest value; the last code means that there is no number."""

NOTHING = LEVELS + 1


def packed(values: np.ndarray) -> dict[str, Any]:
    """Columns of numbers, each to 1/65534 of its range.

    Args:
        values: (samples,) or (samples, columns); NaN where there is no number.

    Returns:
        `rows`, and for each column `low` and `step`; `data` has the codes column by column, as differences
        modulo 65536.
    """
    columns = np.asarray(values, dtype=float)
    columns = columns[:, None] if columns.ndim == 1 else columns
    finite = np.isfinite(columns)
    low = np.min(columns, axis=0, initial=np.inf, where=finite)
    high = np.max(columns, axis=0, initial=-np.inf, where=finite)
    low, high = np.where(np.isfinite(low), low, 0.0), np.where(np.isfinite(high), high, 0.0)
    step = np.where(high - low > np.finfo(float).tiny * LEVELS, (high - low) / LEVELS, 1.0)
    codes = np.round((np.where(finite, columns, low) - low) / step).astype(np.int64)
    codes = np.where(finite, codes, NOTHING).T
    differences = np.diff(codes, axis=1, prepend=0).astype(np.uint16)
    return {
        "rows": len(columns),
        "low": [_short(x) for x in low],
        "step": [_short(x) for x in step],
        "data": base64.b64encode(zlib.compress(differences.astype("<u2").tobytes(), 9)).decode(),
    }


def _short(number: float) -> float:
    return float(f"{number:.9g}")
