"""Cubic B-splines and Gaussians over regular grids, in NumPy.

The numbers are to the bit those of SciPy's `ndimage`, whose order of operations they follow; a flight over a
height map needs no SciPy. Beyond its border a grid goes on as its mirror image about the last point.
"""

from __future__ import annotations

import numpy as np

_POLE = -0.2679491924311227
"""Of the recursive filter that turns samples into coefficients: sqrt(3) - 2, all of its digits."""


def coefficients(samples: np.ndarray) -> np.ndarray:
    """Coefficients of the cubic B-spline that passes through samples (n, m), along both axes."""
    return _filtered(_filtered(np.array(samples, dtype=float)).T).T


def _filtered(c: np.ndarray) -> np.ndarray:
    """The filter along the first axis, there and back (Unser, Aldroubi, Eden, IEEE TSP 41(2), 1993)."""
    c, last = c * ((1.0 - _POLE) * (1.0 - 1.0 / _POLE)), len(c) - 1
    far, power = _POLE**last, _POLE
    c[0] += far * c[last]
    for i in range(1, last):
        c[0] += power * (c[i] + far * c[last - i])
        power *= _POLE
    c[0] /= 1.0 - far * far
    for i in range(1, last + 1):
        c[i] += _POLE * c[i - 1]
    c[last] = (_POLE * c[last - 1] + c[last]) * _POLE / (_POLE * _POLE - 1.0)
    for i in range(last - 1, -1, -1):
        c[i] = _POLE * (c[i + 1] - c[i])
    return c


def at_grid(c: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The spline with coefficients (n, m) on a grid of places, counted in points: (len(x), len(y))."""
    (rows, along), (columns, across) = (_weights(p, n) for p, n in zip((x, y), c.shape, strict=True))
    values = np.zeros((len(x), len(y)))
    for i in range(4):
        for j in range(4):
            values += c[np.ix_(rows[i], columns[j])] * along[i][:, None] * across[j]
    return values


def _weights(places: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The four coefficients at each place along an axis, and their weights, (4, n) each."""
    first = np.floor(places)
    y = places - first
    z = 1.0 - y
    one, two = ((s * s * (s - 2.0) * 3.0 + 4.0) / 6.0 for s in (y, z))
    zero = z * z * z / 6.0
    beside = np.abs(first.astype(int) + np.arange(-1, 3)[:, None])
    last = count - 1
    return last - np.abs(last - beside), np.stack([zero, one, two, 1.0 - zero - one - two])


def smoothed(values: np.ndarray, deviations: np.ndarray) -> np.ndarray:
    """Values (n, m) under a Gaussian, whose standard deviations along both axes are in points.

    Beyond the border the outermost value goes on. A Gaussian ends at four deviations.
    """
    for deviation in deviations:
        reach = int(4.0 * deviation + 0.5)
        bell = np.exp(-0.5 / (deviation * deviation) * np.arange(-reach, reach + 1) ** 2)
        bell = bell / bell.sum()
        wide, n = np.pad(values, ((reach, reach), (0, 0)), mode="edge"), len(values)
        values = wide[reach : reach + n] * bell[reach]
        for k in range(reach, 0, -1):
            values = (
                values + (wide[reach - k : reach - k + n] + wide[reach + k : reach + k + n]) * bell[reach - k]
            )
        values = values.T
    return values
