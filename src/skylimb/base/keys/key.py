"""What one configuration key is: unit, meaning and range."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any

import numpy as np

Vector3 = tuple[float, float, float]
"""Type of a key with a number for each of three axes."""


@dataclass(frozen=True)
class Key:
    """What one configuration key is. A range holds for every entry of a tuple.

    Attributes:
        unit: SI unit; empty for a pure number, a text or a switch.
        meaning: what it is, in a few words, without its unit.
        low: smallest value allowed.
        high: largest value allowed.
        above: the value must be more than this; in place of `low`.
        below: the value must be less than this; in place of `high`.
        finite: false where an infinite value has a meaning. NaN never has one.
        file: whether it names a file of the user's; a relative path is sought beside the file that names it.
    """

    unit: str = ""
    meaning: str = ""
    low: float | None = None
    high: float | None = None
    above: float | None = None
    below: float | None = None
    finite: bool = True
    file: bool = False

    @property
    def bounded(self) -> bool:
        """Whether both ends of the range are stated; an end may be stated as infinite."""
        lower, upper = (self.low, self.above), (self.high, self.below)
        return lower != (None, None) and upper != (None, None)

    @property
    def range(self) -> str:
        """The range without its unit, for example "0 .. 0.6" or "> 0, <= 5"."""
        if self._closed:
            return f"{shown(self.low)} .. {shown(self.high)}"
        return ", ".join(self._ends(">=", ">", "<=", "<")) or "any number"

    def allows(self, value: Any) -> bool:
        """Whether the number `value` is in the range."""
        if not is_number(value) or (self.finite and is_infinite(value)):
            return False
        if isinstance(value, float | np.floating) and math.isnan(value):
            return False
        return bool(
            (self.low is None or value >= self.low)
            and (self.above is None or value > self.above)
            and (self.high is None or value <= self.high)
            and (self.below is None or value < self.below)
        )

    def problem(self, value: Any) -> str:
        """What is wrong with a number outside of the range, with a guess at another unit."""
        unit = f" {self.unit}" if self.unit else ""
        ends = self._ends("at least", "above", "at most", "below")
        if self._closed:
            text = f"is outside of {self.range}{unit}"
        else:
            text = f"must be {' and '.join(ends)}{unit}" if ends else "must be finite"
        guess = self._unit_guess(value)
        return f"{text}; {guess}" if guess else text

    def reading_of(self, text: str) -> str:
        """What a number with a unit, such as "20deg", is in the key's own unit; empty where it is none."""
        match = _WITH_UNIT.fullmatch(text)
        factor = _READINGS.get(self.unit, {}).get(match[2]) if match else None
        if match is None or factor is None:
            return ""
        return f"{match[1]} {match[2]} = {float(match[1]) * factor:.6g} {self.unit}".rstrip()

    @property
    def _closed(self) -> bool:
        """Whether both ends are finite and belong to the range."""
        return all(end is not None and math.isfinite(end) for end in (self.low, self.high))

    def _ends(self, at_least: str, above: str, at_most: str, below: str) -> list[str]:
        """Each end of the range in the given words; an infinite end that belongs to it says nothing."""
        low = None if self.low == -math.inf else self.low
        high = None if self.high == math.inf else self.high
        ends = ((at_least, low), (above, self.above), (at_most, high), (below, self.below))
        return [f"{word} {shown(end)}" for word, end in ends if end is not None]

    def _unit_guess(self, value: float) -> str:
        """Asks whether `value` was meant in degrees, mm, g or ms; empty where that is not in range either."""
        if self.unit not in _OTHER_UNITS or is_infinite(value) or abs(value) < 1.0:
            return ""
        name, symbol, factor = _OTHER_UNITS[self.unit]
        if not self.allows(value * factor):
            return ""
        return f"is it in {name}? {value:g} {symbol} = {value * factor:.4g} {self.unit}"


_OTHER_UNITS = {
    "rad": ("degrees", "deg", math.pi / 180.0),
    "m": ("millimetres", "mm", 1e-3),
    "kg": ("grams", "g", 1e-3),
    "s": ("milliseconds", "ms", 1e-3),
}


_DEGREE = math.pi / 180.0

_READINGS = {
    "": {"%": 0.01},
    "rad": {"deg": _DEGREE, "degree": _DEGREE, "degrees": _DEGREE, "°": _DEGREE, "rad": 1.0},
    "rad/s": {"deg/s": _DEGREE, "°/s": _DEGREE, "rpm": math.pi / 30.0, "rad/s": 1.0},
    "m": {"mm": 1e-3, "cm": 1e-2, "m": 1.0},
    "m/s": {"mm/s": 1e-3, "cm/s": 1e-2, "m/s": 1.0},
    "kg": {"g": 1e-3, "kg": 1.0},
    "s": {"ms": 1e-3, "s": 1.0, "min": 60.0},
    "N": {"mN": 1e-3, "N": 1.0, "kN": 1e3},
    "Hz": {"Hz": 1.0, "kHz": 1e3},
}
"""Unit of a key -> units that people write, and how much of the first they are."""

_WITH_UNIT = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([a-zA-Z°%][a-zA-Z°/]*)\s*")


def is_number(value: Any) -> bool:
    """Whether a value is a real number, Python's or NumPy's; a bool is none."""
    return isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)


def is_infinite(value: Any) -> bool:
    """Whether a number is infinite, NaN, or too large for a float."""
    try:
        return not math.isfinite(value)
    except OverflowError:  # a whole number beyond every float
        return True


def shown(value: Any) -> str:
    """A value for a message: short, on one line."""
    if isinstance(value, float | np.floating):
        return f"{value:g}"
    text = str(value) if isinstance(value, np.integer) else repr(list(value) if _is_flat(value) else value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _is_flat(value: Any) -> bool:
    return isinstance(value, tuple) and all(is_number(entry) for entry in value)
