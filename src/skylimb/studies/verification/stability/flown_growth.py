"""The same growth, seen in a flight: nothing is linear there.

A point is flown on twice, once as it is and once nudged along a mode. The difference of the two, measured
along the mode's left eigenvector, grows or dies away at the mode's rate for as long as it is small.
"""

from __future__ import annotations

import mujoco
import numpy as np

from skylimb.studies.verification.stability.closed_loop import ClosedLoop
from skylimb.studies.verification.stability.modes import Mode
from skylimb.studies.verification.stability.plant import tangent_difference
from skylimb.studies.verification.stability.point import OperatingPoint

_NUDGE = 1e-3
"""Largest entry of the perturbation, in the state's own units."""


def flown_growth(point: OperatingPoint, loop: ClosedLoop, mode: Mode, duration: float = 1.0) -> float:
    """Growth of a mode in flight, 1/s.

    Args:
        point: where both flights begin.
        loop: the linearisation there.
        mode: one of its modes.
        duration: of the flights, s.
    """
    ticks = round(duration / point.period)
    still, nudged = (
        _fly(point, np.zeros(len(loop.names)), ticks),
        _fly(point, _NUDGE * loop.direction(mode), ticks),
    )
    difference = np.array(
        [tangent_difference(point.plant.model, a, b) for a, b in zip(nudged, still, strict=True)]
    )
    size = np.log(abs(loop.amplitude(mode, difference)))
    return float(np.polyfit(np.arange(ticks) * point.period, size, 1)[0])


_Moment = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


def _fly(point: OperatingPoint, moved: np.ndarray, ticks: int) -> list[_Moment]:
    """Positions, velocities, activations and the tick's state at every tick."""
    model, data = point.plant.model, point.data()
    nv, na = model.nv, model.na
    mujoco.mj_integratePos(model, data.qpos, moved[:nv], 1.0)
    data.qvel[:] += moved[nv : 2 * nv]
    data.act[:] += moved[2 * nv : 2 * nv + na]
    driver = point.driver(data, ticks, point.state + moved[2 * nv + na :])
    moments = []
    for k in range(ticks):
        moments.append((data.qpos.copy(), data.qvel.copy(), data.act.copy(), driver.state(k).copy()))
        driver.tick(k)
    return moments
