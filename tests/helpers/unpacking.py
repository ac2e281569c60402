"""What a page reads of packed numbers."""

import base64
import zlib
from typing import Any

import numpy as np

from skylimb.analysis.viewer.packing import LEVELS, NOTHING


def unpacked(pack: dict[str, Any]) -> np.ndarray:
    """The columns of `packed`, (rows, columns), as a page reads them."""
    codes = np.frombuffer(zlib.decompress(base64.b64decode(pack["data"])), dtype="<u2")
    codes = np.cumsum(codes.reshape(len(pack["low"]), pack["rows"]).astype(np.int64), axis=1).T % (LEVELS + 2)
    return np.where(codes == NOTHING, np.nan, np.array(pack["low"]) + codes * np.array(pack["step"]))
