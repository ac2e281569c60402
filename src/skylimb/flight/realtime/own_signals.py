"""A controller's own signals, tick by tick: a log's column has the shape that it had at first."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from skylimb.base.packing import number
from skylimb.control.estimation.records import Measurement, zero_measurement
from skylimb.control.missions.reference import Reference


def kept_signals(own: Mapping[str, Any], first: Mapping[str, Any]) -> tuple[dict[str, Any], list[str]]:
    """The signals of a tick, and the names of those that are no numbers of the shape that they had: NaN here.

    Args:
        own: of this tick; one that is left out stands as it was.
        first: of a tick before, which says names and shapes.
    """
    kept, odd = dict[str, Any](), list[str]()
    for name, before in first.items():
        kept[name], fits = _as_before(own.get(name, before), np.shape(before))
        if not fits:
            odd.append(name)
    return kept, odd


def unknown_signals(signals: Mapping[str, Any]) -> dict[str, Any]:
    """NaN in the place of each."""
    return {name: np.full(np.shape(value), np.nan) for name, value in signals.items()}


def _as_before(value: Any, shape: tuple[int, ...]) -> tuple[Any, bool]:
    """A signal as numbers of a shape, NaN where it is none; and whether it is."""
    if type(value) is float and not shape:
        return value, True
    try:
        found = value if type(value) is np.ndarray and value.dtype == float else number(value, shape)
    except (TypeError, ValueError):
        found = None
    if found is None or np.shape(found) != shape:
        return number(np.full(shape, np.nan)), False
    return found, True


def at_rest(reference: Reference, imu: bool = False) -> Measurement:
    """A measurement of a robot that hovers level near its reference, where nobody flies by it."""
    q, psi = reference.joint_angles, reference.vectoring_angles
    level = np.array([1.0, 0.0, 0.0, 0.0])
    still = zero_measurement(len(q), len(psi), imu)
    return still._replace(
        position=np.array(reference.position), quaternion=level, joint_angles=q, vectoring_angles=psi
    )
