"""A record with everything that its residuals need, for any parameters, and what residuals weigh."""

from __future__ import annotations

import functools

import numpy as np

from skylimb.studies.calibration.mechanics import root_mass
from skylimb.studies.calibration.parameters import parameters, slices, spreads
from skylimb.studies.calibration.predictor import Predictor
from skylimb.studies.calibration.record import Record
from skylimb.studies.calibration.step_model import MEASURED
from skylimb.studies.calibration.steps import Filtered, Noise, Predicted, Steps

HUBER, IMPOSSIBLE = 3.0, 8.0
"""Residuals, over their usual size, from which they weigh less, and from which their frame is not used."""

QUARTILE = 0.6745

_BESIDE = 0.3
"""Way of a central difference, in the deviations that an entry would have if all the others were known."""


class Fit:
    """A record with everything that its residuals need, for any parameters.

    Args:
        record: what was flown.
    """

    def __init__(self, record: Record) -> None:
        self.record = record
        self.parameters = parameters(record.robot)
        self.places = slices(self.parameters)
        robot = record.robot
        self.predictor = Predictor(record.wheels, robot.mass, root_mass(robot), record.step)
        self._steps = functools.lru_cache(maxsize=2)(self._of_all_pieces)
        self.impossible = [np.zeros(len(range(*piece, record.stride)), dtype=bool) for piece in record.pieces]

    def steps(self, theta: np.ndarray, chord: bool = False) -> list[Steps]:
        """What is known of every step of every piece, frames that cannot be true left out."""
        lag, latency = float(theta[self.places["rotor_lag"]][0]), float(theta[self.places["latency"]][0])
        return [
            steps._replace(fresh=steps.fresh * ~bad[:, None])
            for steps, bad in zip(self._steps(lag, latency, chord), self.impossible, strict=True)
        ]

    def _of_all_pieces(self, lag: float, latency: float, chord: bool) -> list[Steps]:
        """Kept for the next question: a search of noise levels asks thirty times at the same parameters."""
        return [self.record.steps(piece, lag, latency, chord) for piece in self.record.pieces]

    def filtered(self, theta: np.ndarray, noise: Noise) -> list[Filtered]:
        """The filter along every piece."""
        return [
            self.predictor.filtered(steps, theta, noise, self.predictor.start(steps, theta))
            for steps in self.steps(theta)
        ]

    def predicted(self, theta: np.ndarray, known: list[Filtered], chord: bool = False) -> list[Predicted]:
        """Residuals and derivatives along every piece, the filter's gains held; `chord` as `Record.steps`."""
        return [
            self.predictor.predict(steps, theta, self.predictor.start(steps, theta), one)
            for steps, one in zip(self.steps(theta, chord), known, strict=True)
        ]

    def whole(self, theta: np.ndarray, noise: Noise) -> tuple[list[Predicted], np.ndarray]:
        """The same with gains that go with the parameters, and how `uncertainty` goes with them, (p,).

        A record that hardly shows the heading shows it in part by what the filter makes of its own errors:
        with gains that are held, estimates of 200 such flights were up to four standard deviations off.
        By central differences; with lag and latency gains hardly change.
        """
        predicted = self.predicted(theta, self.filtered(theta, noise))
        steep = sum((np.sum(one.by_parameters**2, axis=(0, 1)) for one in predicted), np.zeros(len(theta)))
        ways = np.diag(_BESIDE / np.sqrt(steep + spreads(self.parameters) ** -2))
        growth = np.zeros(len(theta))
        held = {self.places[name].start for name in ("rotor_lag", "latency")}
        for entry in sorted(set(range(len(theta))) - held):
            high, low = (self.filtered(theta + side * ways[entry], noise) for side in (1.0, -1.0))
            there = 2.0 * ways[entry, entry]
            growth[entry] = (uncertainty(high) - uncertainty(low)) / there
            for one, up, down in zip(predicted, high, low, strict=True):
                one.by_parameters[:, :, entry] = (up.residuals - down.residuals) / there
        return predicted, growth

    def used(self, known: list[Filtered]) -> np.ndarray:
        """Residuals of the frames that are used, (k, 6)."""
        return np.concatenate([one.residuals[one.residuals.any(axis=1)] for one in known])

    def likelihood(self, known: list[Filtered]) -> float:
        """Minus twice the logarithm of the likelihood, up to a constant; large residuals count as Huber's."""
        size = np.abs(self.used(known))
        far = float(np.sum(np.where(size < HUBER, size**2, HUBER * (2.0 * size - HUBER))))
        return far + uncertainty(known)

    def leave_out(self, known: list[Filtered]) -> None:
        """Use no frame any more whose residual is beyond what any frame could have."""
        usual = np.median(np.abs(self.used(known)), axis=0) / QUARTILE
        most = IMPOSSIBLE * np.maximum(usual, 1.0)
        for piece, one in enumerate(known):
            far = np.any(np.abs(one.residuals) > most, axis=1)
            # A wild frame makes those behind it look wild.
            self.impossible[piece] |= far & ~np.concatenate([[False], far[:-1]])


def uncertainty(known: list[Filtered]) -> float:
    """Logarithm of the determinants of what the filter expects of the frames that are used."""
    used = [one.whitening[one.residuals.any(axis=1)][:, :: MEASURED + 1] for one in known]
    return -2.0 * float(sum(np.sum(np.log(each)) for each in used))


def robust_weights(residuals: np.ndarray) -> tuple[np.ndarray, float]:
    """Huber's weights of residuals, each in the deviations that its noise has, and their usual deviation.

    A residual within some usual deviations counts fully, one beyond pulls no more than one at that bound.
    Zeros are frames that were not measured: they say nothing of what is usual.

    Args:
        residuals: of frames, (k,).

    Returns:
        Weights, (k,), and the usual deviation, at least 1.
    """
    usual = max(1.0, float(np.median(np.abs(residuals[residuals != 0.0]))) / QUARTILE)
    return np.minimum(1.0, HUBER * usual / np.maximum(np.abs(residuals), 1e-12)), usual
