"""What every reader of a log needs: phases, axes, and stretches of time in which something holds."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import xarray as xr

from skylimb.errors import unknown_name

ADAPTATION_THRESHOLD = 0.005
"""The arm counts as adapting while its commanded reach is more than this (m) away from its reference."""


def phase_names(log: xr.Dataset) -> dict[str, int]:
    """The phases that the log knows, with the number each has in the signal `phase`."""
    if "phase" not in log:
        return {}
    attributes = log.phase.attrs
    values = np.atleast_1d(attributes.get("flag_values", []))
    return dict(
        zip(str(attributes.get("flag_meanings", "")).split(), (int(value) for value in values), strict=True)
    )


def in_phase(log: xr.Dataset, name: str) -> np.ndarray:
    """At which samples the flight was in the phase `name`: booleans, shape (time,).

    A log without phases is never in any.

    Raises:
        UnknownNameError: if the log has phases, but none of that name.
    """
    known = phase_names(log)
    if not known:
        return np.zeros(log.sizes["time"], dtype=bool)
    if name not in known:
        raise unknown_name("phase", name, known)
    return np.asarray(log.phase.values == known[name])


def contact_axis(log: xr.Dataset) -> str:
    """The axis along which the robot pushes; x where the log doesn't say."""
    return str(log.attrs.get("contact_axis", "x"))


def sliding_axes(log: xr.Dataset) -> tuple[str, str]:
    """The two axes along which the tip slides; y and z where the log doesn't say."""
    axes = log.attrs.get("sliding_axes", ("y", "z"))
    first, second = axes.replace(",", " ").split() if isinstance(axes, str) else axes
    return str(first), str(second)


def in_contact(log: xr.Dataset) -> np.ndarray:
    """At which samples the tip touched: booleans, shape (time,)."""
    if "contact" not in log:
        return np.zeros(log.sizes["time"], dtype=bool)
    return log.contact.values > 0


def adapting(log: xr.Dataset) -> np.ndarray:
    """At which samples the arm gave way: booleans, shape (time,).

    It does where its commanded reach is away from its reference.
    """
    if not {"reach_command", "reach_reference"} <= set(log.variables):
        return np.zeros(log.sizes["time"], dtype=bool)
    return np.abs(log.reach_command.values - log.reach_reference.values) > ADAPTATION_THRESHOLD


def spans(time: np.ndarray, mask: np.ndarray, bridge: float = 0.0) -> list[tuple[float, float]]:
    """The stretches of time in which `mask` holds, as (begin, end) in s.

    Args:
        time: shape (n,), s.
        mask: booleans, shape (n,).
        bridge: gaps up to this long (s) don't interrupt a stretch: a bouncing pen is still drawing.
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(np.int8), [0]])))
    found: list[tuple[float, float]] = []
    for begin, end in zip(edges[::2], edges[1::2] - 1, strict=True):
        if found and time[begin] - found[-1][1] <= bridge:
            found[-1] = (found[-1][0], float(time[end]))
        else:
            found.append((float(time[begin]), float(time[end])))
    return found


def surface_of(log: xr.Dataset) -> dict[str, Any] | None:
    """The surface's description, or None where the log has none.

    It holds kind, origin (m), axis_u, axis_v, normal (unit vectors in W) and the surface's own parameters.
    """
    text = log.attrs.get("surface", "")
    surface = json.loads(text) if text else None
    if not surface or not {"origin", "axis_u", "axis_v", "normal"} <= set(surface):
        return None
    return surface
