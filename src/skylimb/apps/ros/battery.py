"""What is left in a battery, by its voltage: the lab's table of a lithium polymer cell."""

from __future__ import annotations

import numpy as np

CELL_VOLTS = (3.209, 3.683, 3.747, 3.791, 3.812, 3.839, 3.883, 3.936, 3.999, 4.085, 4.2)
"""Volts of a cell at 0, 10, ... 100 per cent."""


FULLEST = 4.35
"""Volts of a cell above which there is none: the number of cells is another one."""


def percentage(voltage: float, cells: int) -> float:
    """Charge that is left, per cent, 0 .. 100.

    Args:
        voltage: of the whole battery, V.
        cells: in series.

    Returns:
        NaN for a voltage that no battery of so many cells has: not finite, not above zero, or too high.
    """
    if not 0.0 < voltage <= FULLEST * cells:
        return float("nan")
    return float(np.interp(voltage / cells, CELL_VOLTS, 10.0 * np.arange(11)))
