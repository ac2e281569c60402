"""The widths of an SVG file's strokes, which a drawing's force follows."""

from __future__ import annotations

import math
import re
from typing import Any

from skylimb.base.errors import ConfigError

_WIDTH = re.compile(r"\+?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?\s*(px|mm|cm|in|pt|pc|%)?", re.IGNORECASE)


def stroke_width(element: Any, what: str, painted: bool) -> float:
    """Of an element of svgelements, where it stands: after its transform; 0 is no stroke.

    Args:
        element: a shape.
        what: the file is called in messages.
        painted: whether its stroke has a colour; of one without nothing is refused.

    Raises:
        ConfigError: where the file says something else than a width.
    """
    said = str(element.values.get("stroke-width", "1")).removesuffix("!important").strip()
    width = float(element.implicit_stroke_width or 0.0)
    if painted and not (_WIDTH.fullmatch(said) and math.isfinite(width)):
        raise ConfigError(
            f"{what} has stroke-width = '{said[:30]}', which is no width that is read; give a number, or a "
            "length in px, mm, cm, in, pt, pc or %"
        )
    # A percentage is of the viewport's diagonal over the root of two; svgelements takes the diagonal.
    return width / math.sqrt(2.0) if said.endswith("%") else width
