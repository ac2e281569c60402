"""Records of the predictor: what is known of every step of a flight, and what is found along it."""

from __future__ import annotations

from typing import NamedTuple

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
    """What is known of every step of a record, a row each; see `record`.

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

    middle: np.ndarray
    middle_rate: np.ndarray
    cog: np.ndarray
    cog_rate: np.ndarray
    thrusts: np.ndarray
    thrusts_by: np.ndarray
    early: np.ndarray
    early_by: np.ndarray
    position: np.ndarray
    attitude: np.ndarray
    fresh: np.ndarray


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
