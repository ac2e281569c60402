"""What most figures of the evidence are: a line for each value of one parameter, over another."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike


def curves(
    x: ArrayLike | None,
    rows: ArrayLike,
    labels: Iterable[str],
    axes_labels: tuple[str, str],
    *,
    logarithmic: bool = False,
) -> Callable[[Any], None]:
    """What draws the lines.

    Args:
        x: of their points, (n,); none for their numbers.
        rows: values, (m, n).
        labels: of the lines, m.
        axes_labels: of both axes, with units.
        logarithmic: whether the axis of x is.
    """
    values, names = np.asarray(rows), list(labels)
    at = np.arange(values.shape[1]) if x is None else np.asarray(x)

    def draw(axes: Any) -> None:
        for row, name in zip(values, names, strict=True):
            axes.plot(at, row, "o-", label=name)
        if logarithmic:
            axes.set_xscale("log")
        axes.set(xlabel=axes_labels[0], ylabel=axes_labels[1])
        axes.legend()

    return draw
