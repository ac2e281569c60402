"""Least and greatest thrust as the laboratory writes them: limits of a rotor's axle, in newtons."""

from __future__ import annotations

import math
from typing import NamedTuple
from xml.etree.ElementTree import Element

from skylimb.robots.urdf_numbers import is_number

_BELIEVED = 1e3
"""Greatest thrust that a limit of a rotor's axle may mean, N; +-1e16 means none."""


class Axle(NamedTuple):
    """What a file says of a rotor's axle.

    Attributes:
        joint: its name; empty where the rotor has none.
        lower: text of its limit, empty where it has none.
        upper: likewise.
    """

    joint: str = ""
    lower: str = ""
    upper: str = ""


def axle_of(joint: Element | None) -> Axle:
    """What a file says of a rotor's axle."""
    if joint is None:
        return Axle()
    limit = joint.find("limit")
    lower, upper = ("" if limit is None else limit.get(key, "").strip() for key in ("lower", "upper"))
    return Axle(joint.get("name", ""), lower, upper)


def thrust_limits(axle: Axle) -> tuple[float | None, float | None, str]:
    """Least and greatest thrust, N, where the limits can be thrusts; third what is wrong with them, or ''.

    Limits of an angle, or of an axle that turns without end, are no thrusts, and nothing is wrong with them.
    """
    for key, text in (("lower", axle.lower), ("upper", axle.upper)):
        if text and not is_number(text):
            return None, None, f"{key} = '{text[:40]}' is no number"
    low, high = (float(text) if text else math.nan for text in (axle.lower, axle.upper))
    if 0.0 <= low < high < _BELIEVED and high != 2.0 * math.pi:
        return low, high, ""
    if low > high:
        return None, None, f"lower {low:g} is above upper {high:g}"
    if low >= 0.0 and high >= _BELIEVED:
        return None, None, f"upper {high:g} is no thrust below {_BELIEVED:g} N"
    return None, None, ""
