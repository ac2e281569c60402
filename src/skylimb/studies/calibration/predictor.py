"""What a log should look like: a robot predicted from its thrusts, and put right by every frame.

A Kalman filter of constant noise levels predicts each frame from those before it, by the steps of
`StepModel`. What a frame differs from its prediction, over the standard deviation that the filter expects, is
the residual (6 a frame); for the right parameters it is white. So prediction errors of a whole flight make a
likelihood, without an observer's drift in them and unbiased by the controller, which reacts to the same noise
(Ljung, System Identification, 1999, chapter 7).

One function does a step: it carries the derivative of state and residual by all parameters along, exactly,
with the filter's gain held.
"""

from __future__ import annotations

import functools

import casadi as ca
import numpy as np

from skylimb.base.rotations import small_rotation
from skylimb.flight.drivers.machine_code import fastest
from skylimb.studies.calibration.scan import scan
from skylimb.studies.calibration.step_model import MEASURED, STATES, StepModel
from skylimb.studies.calibration.steps import Filtered, Noise, Predicted, Steps

START = (0.05, 0.3, 0.05, 0.1)
"""How well p (m), v (m/s), R (rad) and l (m^2/s) are known before the first frame."""


@functools.lru_cache(maxsize=4)
def _functions(
    wheels: tuple[float, ...], mass: float, root_mass: float, root_centre: tuple[float, ...], dt: float
) -> tuple[ca.Function, ca.Function]:
    """The filter's step, which finds gains, and the predictor's, which takes them and has derivatives."""
    model = StepModel(np.array(wheels), mass, (root_mass, np.array(root_centre)), dt)
    following, slope, residual, seen = model.linear()

    # The filter: covariance along, gain and whitening out.
    P, noise = ca.SX.sym("P", STATES, STATES), ca.SX.sym("noise", MEASURED + STATES)
    H = -seen[:, :STATES]
    M = P @ H.T
    L = ca.chol(H @ M + ca.diag(noise[:MEASURED])).T
    W = ca.densify(ca.solve(L, ca.SX.eye(MEASURED)))
    gain = M @ W.T @ W
    corrected = P - model.given.fresh * (gain @ M.T)
    A = ca.substitute([slope[:, :STATES]], [model.gain], [ca.SX.zeros(STATES, MEASURED)])[0]
    P_next = A @ (0.5 * (corrected + corrected.T)) @ A.T + ca.diag(noise[MEASURED:])
    (moved,) = ca.substitute([following], [model.gain], [gain])
    filtering = ca.Function(
        "filtering",
        [ca.vertcat(model.x, ca.vec(P)), ca.vertcat(model.theta, *model.given, noise)],
        [
            ca.densify(ca.vertcat(moved, ca.vec(P_next))),
            ca.densify(ca.vertcat(ca.vec(gain), ca.vec(W), W @ residual)),
        ],
        {"cse": True},
    )

    return filtering, _predicting(model, following, slope, residual, seen)


def _predicting(
    model: StepModel, following: ca.SX, slope: ca.SX, residual: ca.SX, seen: ca.SX
) -> ca.Function:
    """The predictor's step, its gain and whitening flat."""
    S = ca.SX.sym("S", STATES, model.parameters)
    gain, white = ca.SX.sym("K", STATES * MEASURED), ca.SX.sym("W", MEASURED * MEASURED)
    W = ca.reshape(white, MEASURED, MEASURED)
    total = seen[:, :STATES] @ S + seen[:, STATES:]
    S_next = slope[:, :STATES] @ S + slope[:, STATES:]
    outputs = [
        ca.densify(ca.vertcat(following, ca.vec(S_next))),
        ca.densify(ca.vertcat(W @ residual, ca.vec(W @ total))),
    ]
    outputs = ca.substitute(outputs, [model.gain], [ca.reshape(gain, STATES, MEASURED)])
    inputs = [ca.vertcat(model.x, ca.vec(S)), ca.vertcat(model.theta, *model.given, gain, white)]
    return ca.Function("predicting", inputs, outputs, {"cse": True})


class Predictor:
    """Prediction errors of one record as a function of the parameters.

    Args:
        wheels: of the rotors; see `Record.wheels`.
        mass: of the described robot, kg.
        root: mass (kg) and centre of mass (m) of its root link.
        dt: time of a step, s.
    """

    def __init__(self, wheels: np.ndarray, mass: float, root: tuple[float, np.ndarray], dt: float) -> None:
        self.dt = dt
        functions = _functions(tuple(map(float, wheels)), mass, root[0], tuple(map(float, root[1])), dt)
        self._filtering, self._predicting = (fastest(each, often=True) for each in functions)

    def start(self, steps: Steps, theta: np.ndarray) -> np.ndarray:
        """The state that the first frame suggests, at rest, (18,)."""
        R = steps.attitude[0].reshape(3, 3) @ small_rotation(-theta[0:3])
        p = steps.position[0] + R @ (steps.cog[0] + theta[3:6])
        return np.concatenate([p, np.zeros(3), R.ravel(), np.zeros(3)])

    def filtered(self, steps: Steps, theta: np.ndarray, noise: Noise, start: np.ndarray) -> Filtered:
        """The filter along a record, for these parameters and noise levels."""
        P = np.diag(np.repeat(START, 3) ** 2)
        dt = self.dt
        levels = np.repeat(
            [noise.position**2, noise.attitude**2, 1e-14, dt * noise.push**2, 1e-14, dt * noise.turn**2], 3
        )
        rows = [np.tile(theta, (len(steps.fresh), 1)), *steps, np.tile(levels, (len(steps.fresh), 1))]
        found = scan(self._filtering, np.concatenate([start, P.ravel()]), np.hstack(rows))
        gains, whitening, residuals = np.split(found, np.cumsum([STATES * MEASURED, MEASURED**2]), axis=1)
        return Filtered(gains, whitening, residuals * _telling(steps))

    def predict(self, steps: Steps, theta: np.ndarray, start: np.ndarray, known: Filtered) -> Predicted:
        """Residuals and their derivatives by the parameters, with the filter's gains held."""
        state = np.concatenate([start, np.zeros(STATES * len(theta))])
        rows = [np.tile(theta, (len(steps.fresh), 1)), *steps, known.gains, known.whitening]
        found = scan(self._predicting, state, np.hstack(rows))
        residuals, slopes = found[:, :MEASURED], found[:, MEASURED:]
        slopes = slopes.reshape(len(residuals), len(theta), MEASURED).transpose(0, 2, 1)
        used = _telling(steps)
        return Predicted(residuals * used, slopes * used[:, :, None])


def _telling(steps: Steps) -> np.ndarray:
    """1 for a frame that is used, but for the first, which the state begins with: it is off by rounding."""
    return np.vstack([np.zeros_like(steps.fresh[:1]), steps.fresh[1:]])
