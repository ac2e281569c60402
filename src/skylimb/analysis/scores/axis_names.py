"""What the axes of a task are called: the contact axis and the two sliding axes, by their names in W."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from skylimb.analysis.scores.signals import contact_axis, direction, sliding_axes

if TYPE_CHECKING:
    import xarray as xr


class AxisNames(NamedTuple):
    """Names of the axes of one task.

    An axis that is one of W's has its name there, with a minus sign where it points the other way. Any other
    has the name that it has in the code: `u` and `v` for the sliding axes, `n` for the contact axis.

    Attributes:
        u: the first sliding axis.
        v: the second sliding axis.
        n: the contact axis, into the surface.
    """

    u: str
    v: str
    n: str

    def label(self, text: str) -> str:
        """A text with the axes' names in the places of {u}, {v} and {n}, as tables call their lines.

        These are sizes, such as `|{u} error|`, so the names have no sign. In the place of {signed} is the
        contact axis with its sign.
        """
        names = {key: name.lstrip("\N{MINUS SIGN}") for key, name in self._asdict().items()}
        for key, name in {**names, "signed": self.n}.items():  # other braces are a user's own
            text = text.replace(f"{{{key}}}", name)
        return text

    def __str__(self) -> str:
        sliding = " and ".join(
            key if key == name else f"{key} = {name}" for key, name in (("u", self.u), ("v", self.v))
        )
        contact = "n" if self.n == "n" else f"n = {self.n}"
        return f"contact axis {contact}, sliding axes {sliding}"


GENERIC = AxisNames("u", "v", "n")
"""For numbers of tasks that have their axes in different directions, or in any."""

PAPER = AxisNames("y", "z", "x")
"""The paper's."""


def axis_names(log: xr.Dataset) -> AxisNames:
    """The names of the axes of a run's task."""
    first, second = sliding_axes(log)
    return names_of_vectors(first.vector, second.vector, contact_axis(log).vector)


def names_of_vectors(u: np.ndarray, v: np.ndarray, n: np.ndarray) -> AxisNames:
    """The names of sliding axes and contact axis given as unit vectors in W, shape (3,)."""
    found = (direction(axis, key).name for key, axis in zip(AxisNames._fields, (u, v, n), strict=True))
    return AxisNames(*(name.replace("-", "\N{MINUS SIGN}") for name in found))


def common_names(logs: Iterable[xr.Dataset]) -> AxisNames:
    """The names that the axes have in all of some runs; `GENERIC` where they differ."""
    found = {axis_names(log) for log in logs}
    return found.pop() if len(found) == 1 else GENERIC
