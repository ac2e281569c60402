"""Where a closed loop is stable, over one or two of its parameters."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from skylimb.base.errors import ConfigError
from skylimb.studies.verification.stability.closed_loop import linearise
from skylimb.studies.verification.stability.plant import with_stiffness
from skylimb.studies.verification.stability.point import OperatingPoint

if TYPE_CHECKING:
    import xarray

SCALE = "x "
"""Before a gain's name: its value at the point times the axis."""


def at(point: OperatingPoint, axis: str, value: float) -> OperatingPoint:
    """The point with one parameter changed and all else as it is.

    Args:
        point: where to begin.
        axis: "stiffness" of the surface, N/m; "latency", s, the true one; "known latency", s, which the
            controller assumes; a gain's dotted name, or "x " and the name to scale it.
        value: of it.
    """
    if axis == "stiffness":
        return with_stiffness(point, value)
    if axis == "latency":
        return point.with_latency(value)
    if axis == "known latency":
        return point.with_latency(value).with_gains({"estimation.delay.latency": value})
    if axis.startswith(SCALE):
        name = axis.removeprefix(SCALE)
        return point.with_gains({name: value * point.gain(name)})
    return point.with_gains({axis: value})


def stability_map(
    point: OperatingPoint,
    axes: Mapping[str, Sequence[float] | np.ndarray],
    progress: Callable[[int, int], None] | None = None,
) -> xarray.Dataset:
    """Growth, frequency and damping ratio of the dominant mode over a grid of parameters.

    Args:
        point: the operating point, whose forces and posture stay as they are.
        axes: parameters as for `at`, and the values of each.
        progress: called with the number of grid points done, and of all.

    Returns:
        `growth` (1/s; above 0 is unstable), `frequency` (Hz), `damping_ratio` and `neutral` (how many
        eigenvalues are one), with a dimension for each axis.
    """
    import xarray

    if not axes:
        raise ConfigError("a stability map needs at least one axis")
    shape = tuple(len(values) for values in axes.values())
    total, loops = int(np.prod(shape)), []
    for case in itertools.product(*axes.values()):
        there = point
        for name, value in zip(axes, case, strict=True):
            there = at(there, name, float(value))
        loops.append(linearise(there))
        if progress is not None:
            progress(len(loops), total)
    found = {
        name: np.reshape([getattr(loop.dominant, name) for loop in loops], shape)
        for name in ("growth", "frequency", "damping_ratio")
    }
    found["neutral"] = np.reshape([loop.neutral for loop in loops], shape)
    units = {"growth": "1/s", "frequency": "Hz", "damping_ratio": "1", "neutral": "1"}
    return xarray.Dataset(
        {name: (tuple(axes), values, {"units": units[name]}) for name, values in found.items()},
        coords={name: np.asarray(values, dtype=float) for name, values in axes.items()},
    )


def edge(point: OperatingPoint, axis: str, inside: float, outside: float, steps: int = 20) -> float:
    """Where between a stable and an unstable value of a parameter the dominant mode neither grows nor dies.

    Args:
        point: all else.
        axis: as for `at`.
        inside: a value at which the loop is stable.
        outside: one at which it is not.
        steps: of the bisection.

    Raises:
        ConfigError: when the two do not differ in stability.
    """
    for value, wanted in ((inside, True), (outside, False)):
        if linearise(at(point, axis, value)).stable is not wanted:
            raise ConfigError(
                f"{axis} = {value:g} is {'not ' if wanted else ''}stable; an edge needs one stable value and "
                "one that is not"
            )
    for _ in range(steps):
        middle = 0.5 * (inside + outside)
        if linearise(at(point, axis, middle)).stable:
            inside = middle
        else:
            outside = middle
    return 0.5 * (inside + outside)
