"""Records of the predictor: what is known of every step of a flight, and what is found along it."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np


class Noise(NamedTuple):
    """Standard deviations of what the filter expects.

    Attributes:
        position: of a frame, m.
        attitude: of a frame, rad, about each axis.
        push: of an unknown acceleration, m/s^2 over sqrt(Hz).
        turn: of an unknown torque per mass, m^2/s^2 over sqrt(Hz).
    """

    position: float
    attitude: float
    push: float
    turn: float


class Steps(NamedTuple):
    """What is known of every step of a record, a row each, or the symbols of one step; see `record`.

    Attributes:
        middle: mechanics in the middle of the step, flat, and their derivative by the latency.
        middle_rate: that derivative.
        cog: c when the frame was taken, m.
        cog_rate: its derivative by the latency.
        thrusts: mean lambda over the step, N, (k, n).
        thrusts_by: its derivatives by the lag and by the latency, N/s, (k, 2 n).
        early: the mean in which what comes early counts more, as it does for the way within the step, N.
        early_by: its derivatives by the lag and by the latency, N/s, (k, 2 n).
        position: measured, m.
        attitude: measured, (k, 9), row by row.
        fresh: 1 where a new frame is there to be used, else 0.
    """

    middle: Any
    middle_rate: Any
    cog: Any
    cog_rate: Any
    thrusts: Any
    thrusts_by: Any
    early: Any
    early_by: Any
    position: Any
    attitude: Any
    fresh: Any


class Filtered(NamedTuple):
    """What the filter found along a record.

    Attributes:
        gains: (k, 72), column by column.
        whitening: of the residuals, (k, 36), column by column.
        residuals: over their expected standard deviation, (k, 6); zero where no frame is used.
    """

    gains: np.ndarray
    whitening: np.ndarray
    residuals: np.ndarray


class Predicted(NamedTuple):
    """Residuals of a record over their expected standard deviation; zero where no frame is used.

    Attributes:
        residuals: (k, 6).
        by_parameters: their derivative, (k, 6, parameters).
    """

    residuals: np.ndarray
    by_parameters: np.ndarray
