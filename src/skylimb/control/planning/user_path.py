"""A user's path: a Python function of time, sampled, checked and made smooth.

    # heart.py
    def heart(t):
        '''(u, v) in m at the times t in s, an array.'''
        return 0.1 * np.sin(t), 0.1 * np.cos(t)

`trajectory.shape = "heart.py:heart"` names it; so does a function at hand in Python. It is the same as
`shape = "own"`, `file = "heart.py"` and `function = "heart"`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from skylimb.base.errors import ConfigError, UserCodeError
from skylimb.base.user_code import UserCode
from skylimb.base.user_modules import load_module

Samples = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Position (..., 2) in m, velocity in m/s, acceleration in m/s^2."""

USER = "own"
"""The shape's name in a configuration."""

_STEP = 0.005
"""Between two samples, s, but at most `_MOST` and at least `_FEWEST` of them."""

_FEWEST, _MOST = 400, 200_000

_FINER = 64
"""Parts into which the longest step is divided to see whether the path jumps there."""


def spelled_out(tables: Mapping[str, Any]) -> dict[str, Any]:
    """A path's tables with `shape = "file.py:function"`, or a function, as its three keys.

    Raises:
        ConfigError: when a function at hand stands in no file.
    """
    shape = tables.get("shape")
    if callable(shape):
        code = getattr(shape, "__code__", None)
        file, name = getattr(code, "co_filename", ""), getattr(shape, "__name__", "")
        if not Path(file).is_file() or not name.isidentifier():
            raise ConfigError(
                f"trajectory.shape = {name or shape!r}: a path of your own is a function in a file, so "
                "that the run can be flown again"
            )
    elif isinstance(shape, str) and ".py:" in shape:
        file, _, name = shape.rpartition(":")
    else:
        return dict(tables)
    return {**tables, "shape": USER, "file": file, "function": name}


def user_path(
    file: str, function: str, duration: float, direction: int, speed: float, acceleration: float
) -> Callable[[np.ndarray], Samples]:
    """The path (u, v) over times within its duration (s), twice continuously differentiable.

    Args:
        file: Python file.
        function: its name in there; it takes times (k,) and returns u and v, (k,) each, or (k, 2).
        duration: how long the path takes, s.
        direction: -1 goes it the other way round.
        speed: the largest allowed, m/s.
        acceleration: the largest allowed, m/s^2.

    Raises:
        ConfigError: when the function fails, returns something else, is not finite, jumps, or is faster than
            allowed.
    """
    what = f"path '{function}' of '{Path(file).name}'"
    called = getattr(load_module(Path(file), (function,)), function)
    count = int(np.clip(np.ceil(duration / _STEP), _FEWEST, _MOST)) + 1
    times = np.linspace(0.0, duration, count)
    points = _points(called, times, what)
    if not np.array_equal(points, _points(called, times, what)):
        raise UserCodeError(
            f"{what} gives other places when it is called again: it remembers nothing, and draws no random "
            "numbers; draw them above the function, with a seed"
        )
    _require_continuous(called, times, points, what)
    spline = _cubic_spline(times, points[::direction])
    _, *rates = spline(times)
    most_allowed = (speed, "m/s", "speed"), (acceleration, "m/s^2", "acceleration")
    for rate, (most, unit, key) in zip(rates, most_allowed, strict=True):
        size = np.linalg.norm(rate, axis=1)
        worst = int(np.argmax(size))
        if size[worst] > most * (1.0 + 1e-6):
            raise ConfigError(
                f"{what} needs {size[worst]:.3g} {unit} at t = {times[worst]:.3f} s; trajectory.{key} = "
                f"{most:g} {unit} is the most that is allowed: set it, or make the path slower"
            )
    return spline


def _cubic_spline(times: np.ndarray, points: np.ndarray) -> Callable[[np.ndarray], Samples]:
    """Through points (k, 2) at times (k,), with its derivatives; not-a-knot at both ends."""
    curve, t = ca.interpolant("path", "bspline", [times], points.ravel()), ca.MX.sym("t")
    velocity = ca.jacobian(curve(t), t)
    function = ca.Function("path", [t], [curve(t), velocity, ca.jacobian(velocity, t)])

    def sample(t: np.ndarray) -> Samples:
        position, velocity, acceleration = (
            part.full().T.reshape(*t.shape, 2) for part in function(t.reshape(1, -1))
        )
        return position, velocity, acceleration

    return sample


def _points(function: Callable[..., Any], times: np.ndarray, what: str) -> np.ndarray:
    """The path at some times, (k, 2)."""
    with UserCode(what):
        found = function(times.copy())
        points = np.asarray(found)
        if np.iscomplexobj(points):
            raise UserCodeError(f"{what} returned complex numbers, expected real ones")
        points = points.astype(float)
    if points.shape == (2, len(times)) and isinstance(found, tuple | list):
        points = points.T
    if points.shape != (len(times), 2):
        raise UserCodeError(
            f"{what} should return u and v for every time: two arrays ({len(times)},), or one "
            f"({len(times)}, 2); it returned {points.shape}"
        )
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        raise UserCodeError(
            f"{what} is {points[bad[0]].tolist()} at t = {times[bad[0]]:.3f} s, no finite place"
        )
    return points


def _require_continuous(
    function: Callable[..., Any], times: np.ndarray, points: np.ndarray, what: str
) -> None:
    """Refuse a path whose longest step stays as long when it is looked at more finely."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    at = int(np.argmax(steps))
    finer = np.linspace(times[at], times[at + 1], _FINER + 1)
    jump = np.linalg.norm(np.diff(_points(function, finer, what), axis=0), axis=1).max()
    if jump > 0.5 * steps[at] > 1e-9:
        raise UserCodeError(f"{what} jumps by {jump:.3g} m at t = {times[at]:.3f} s; it has to be continuous")
