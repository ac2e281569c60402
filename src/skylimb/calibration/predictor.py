"""What a log should look like: a robot predicted from its thrusts, and put right by every frame.

State of the true robot, at the time that a frame shows: place p and velocity v of the centre of gravity in W,
attitude R of the root link, and angular momentum per mass l about the centre of gravity, in W. With the
`Mechanics` of that moment, m the mass, s_i the thrust scale over the mass's, and lambda_i the thrusts behind
their lag,

    v' = R sum_i s_i lambda_i u_i / m - g + g lean,      l' = R sum_i s_i lambda_i (t_i - d x u_i) / m,
    R' = R hat(I^-1 (R^T l - h)),                         measured: p - R (c + d) and R Exp(e).

Momentum makes the joints' own motion exact, and needs no acceleration of anything. A Kalman filter of
constant noise levels predicts each frame from those before it. What a frame differs from its prediction, over
the standard deviation that the filter expects, is the residual (6 a frame); for the right parameters it is
white. So prediction errors of a whole flight make a likelihood, without an observer's drift in them and
unbiased by the controller, which reacts to the same noise (Ljung, System Identification, 1999, chapter 7).

One function does a step: it carries the derivative of state and residual by all parameters along, exactly,
with the filter's gain held.
"""

from __future__ import annotations

import functools
from typing import NamedTuple

import casadi as ca
import numpy as np

from skylimb.calibration.mechanics import Mechanics, shapes
from skylimb.robots.model import GRAVITY
from skylimb.spatial import cross, hat, vee

STATES = 12
"""p, v, a small turn of R, l."""

MEASURED = 6
"""Place and a small turn."""


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


START = (0.05, 0.3, 0.05, 0.1)
"""How well p (m), v (m/s), R (rad) and l (m^2/s) are known before the first frame."""


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


def _exp(v: ca.SX) -> ca.SX:
    """Rotation by a small vector, rad; exact to third order, and orthogonal (Cayley)."""
    V = hat(0.5 * v)
    return ca.SX.eye(3) + (2.0 / (1.0 + 0.25 * ca.sumsqr(v))) * (V + V @ V)


def _small(R: ca.SX) -> ca.SX:
    """The small vector of a rotation, rad."""
    return 0.5 * vee(R - R.T)


def _rows(flat: ca.SX, rows: int, columns: int) -> ca.SX:
    """A matrix from its entries row by row."""
    return ca.reshape(flat, columns, rows).T


class _Symbols(NamedTuple):
    """What a step takes besides state, gain and covariance, in the order of `Steps`."""

    middle: ca.SX
    middle_rate: ca.SX
    cog: ca.SX
    cog_rate: ca.SX
    thrusts: ca.SX
    thrusts_by: ca.SX
    early: ca.SX
    early_by: ca.SX
    position: ca.SX
    attitude: ca.SX
    fresh: ca.SX


def _mechanics(flat: ca.SX, n: int) -> Mechanics:
    sizes, parts, at = shapes(n), [], 0
    for name in Mechanics._fields:
        shape = sizes[name]
        rows, columns = (shape[0], shape[1] if len(shape) > 1 else 1)
        parts.append(_rows(flat[at : at + rows * columns], rows, columns))
        at += rows * columns
    return Mechanics(*parts)


class _Model:
    """One step in symbols, for a robot of so many rotors."""

    def __init__(self, n: int, mass: float, root: tuple[float, np.ndarray], dt: float) -> None:
        self.n, self.mass, self.root, self.dt = n, mass, root, dt
        size = sum(int(np.prod(shape)) for shape in shapes(n).values())
        widths = (size, size, 3, 3, n, 2 * n, n, 2 * n, 3, 9, 1)
        self.given = _Symbols(*(ca.SX.sym(k, w) for k, w in zip(_Symbols._fields, widths, strict=True)))
        self.parameters = 10 + n
        self.x, self.theta = ca.SX.sym("x", 3 + 3 + 9 + 3), ca.SX.sym("theta", self.parameters)
        self.dx, self.dtheta = ca.SX.sym("dx", STATES), ca.SX.sym("dtheta", self.parameters)
        self.gain = ca.SX.sym("gain", STATES, MEASURED)

    def _told(self, dx: ca.SX, dtheta: ca.SX) -> tuple[ca.SX, ...]:
        """State and parameters, a little beside their values."""
        x, theta, n = self.x, self.theta + dtheta, self.n
        R = _rows(x[6:15], 3, 3) @ _exp(dx[6:9])
        state = (x[0:3] + dx[0:3], x[3:6] + dx[3:6], R, x[15:18] + dx[9:12])
        return (*state, theta[0:3], theta[3:6], theta[6 : 6 + n], theta[8 + n : 10 + n])

    def residual(self, dx: ca.SX, dtheta: ca.SX) -> ca.SX:
        """What the frame differs from its prediction, m and rad, (6,)."""
        p, _, R, _, e, d, _, _ = self._told(dx, dtheta)
        given, latency = self.given, dtheta[self.n + 7]
        c = given.cog + given.cog_rate * latency
        seen = R @ _exp(e)
        return ca.vertcat(given.position - (p - R @ (c + d)), _small(seen.T @ _rows(given.attitude, 3, 3)))

    def next(self, dx: ca.SX, dtheta: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX]:
        """p, v, R and l one step later, put right by the frame before."""
        p, v, R, momentum, _, d, scale, lean = self._told(dx, dtheta)
        given, n, dt = self.given, self.n, self.dt
        right = given.fresh * (self.gain @ self.residual(dx, dtheta))
        p, v, R, momentum = (
            p + right[0:3],
            v + right[3:6],
            R @ _exp(right[6:9]),
            momentum + right[9:12],
        )
        lag, latency = dtheta[n + 6], dtheta[n + 7]
        m = _mechanics(given.middle + given.middle_rate * latency, n)
        beside = ca.vertcat(lag, latency)
        thrusts = scale * (given.thrusts + ca.reshape(given.thrusts_by, n, 2) @ beside)
        early = scale * (given.early + ca.reshape(given.early_by, n, 2) @ beside)
        root, centre = self.root[0], ca.DM(self.root[1])
        arm = centre - m.cog
        moments = m.moments + arm @ d.T + d @ arm.T + (self.mass / root - 1.0) * (d @ d.T)
        inertia = ca.inv_minor(ca.trace(moments) * ca.SX.eye(3) - moments)
        own = m.momentum - cross(d, m.cog_rate)
        force = m.forces @ thrusts / self.mass
        torque = m.torques @ thrusts / self.mass - cross(d, force)
        # Place and attitude need their rates' means over the step, which the early thrusts make.
        early_force = m.forces @ early / self.mass
        early_torque = m.torques @ early / self.mass - cross(d, early_force)
        mean = momentum + 0.5 * dt * (R @ early_torque)
        first = inertia @ (R.T @ mean - own)
        R_half, R_early = R @ _exp(0.5 * dt * first), R @ _exp(dt / 3.0 * first)
        weight = GRAVITY * ca.vertcat(lean, -1.0)
        spin = inertia @ (R_half.T @ mean - own)
        return (
            p + dt * v + 0.5 * dt**2 * (R_early @ early_force + weight),
            v + dt * (R_half @ force + weight),
            R @ _exp(dt * spin),
            momentum + dt * (R_half @ torque),
        )

    def linear(self) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX]:
        """The next state, flat; its derivatives by state and parameters; residual and its derivatives.

        All derivatives are at the state and the parameters themselves.
        """
        zero_x, zero_theta = ca.SX.zeros(STATES), ca.SX.zeros(self.parameters)
        plain = self.next(zero_x, zero_theta)
        p, v, R, momentum = self.next(self.dx, self.dtheta)
        beside = ca.vertcat(p, v, _small(plain[2].T @ R), momentum)
        small = ca.vertcat(self.dx, self.dtheta)
        at = [small], [ca.vertcat(zero_x, zero_theta)]

        def here(expression: ca.SX) -> ca.SX:
            (value,) = ca.substitute([expression], *at)
            return value

        following = ca.vertcat(plain[0], plain[1], ca.vec(plain[2].T), plain[3])
        slope = here(ca.jacobian(beside, small))
        residual = self.residual(self.dx, self.dtheta)
        return following, slope, here(residual), here(ca.jacobian(residual, small))


@functools.lru_cache(maxsize=4)
def _functions(
    n: int, mass: float, root_mass: float, root_centre: tuple[float, ...], dt: float
) -> tuple[ca.Function, ca.Function]:
    """The filter's step, which finds gains, and the predictor's, which takes them and has derivatives."""
    model = _Model(n, mass, (root_mass, np.array(root_centre)), dt)
    following, slope, residual, seen = model.linear()
    inputs = [model.theta, *model.given]

    # 1. The filter: covariance along, gain and whitening out.
    P, noise = ca.SX.sym("P", STATES, STATES), ca.SX.sym("noise", MEASURED + STATES)
    H = -seen[:, :STATES]
    M = P @ H.T
    L = _cholesky(H @ M + ca.diag(noise[:MEASURED]))
    W = _inverse_lower(L)
    gain = M @ W.T @ W
    corrected = P - model.given.fresh * (gain @ M.T)
    A = ca.substitute([slope[:, :STATES]], [model.gain], [ca.SX.zeros(STATES, MEASURED)])[0]
    P_next = A @ (0.5 * (corrected + corrected.T)) @ A.T + ca.diag(noise[MEASURED:])
    (moved,) = ca.substitute([following], [model.gain], [gain])
    filtering = ca.Function(
        "filtering",
        [ca.vertcat(model.x, ca.vec(P)), *inputs, noise],
        [
            ca.densify(out)
            for out in (ca.vertcat(moved, ca.vec(P_next)), ca.vec(gain), ca.vec(W), W @ residual)
        ],
        {"cse": True},
    )

    return filtering, _predicting(model, following, slope, residual, seen)


def _predicting(model: _Model, following: ca.SX, slope: ca.SX, residual: ca.SX, seen: ca.SX) -> ca.Function:
    """The predictor's step, its gain and whitening flat."""
    S = ca.SX.sym("S", STATES, model.parameters)
    gain, white = ca.SX.sym("K", STATES * MEASURED), ca.SX.sym("W", MEASURED * MEASURED)
    W = ca.reshape(white, MEASURED, MEASURED)
    total = seen[:, :STATES] @ S + seen[:, STATES:]
    S_next = slope[:, :STATES] @ S + slope[:, STATES:]
    outputs = [
        ca.densify(ca.vertcat(following, ca.vec(S_next))),
        ca.densify(W @ residual),
        ca.densify(ca.vec(W @ total)),
    ]
    outputs = ca.substitute(outputs, [model.gain], [ca.reshape(gain, STATES, MEASURED)])
    inputs = [ca.vertcat(model.x, ca.vec(S)), model.theta, *model.given, gain, white]
    return ca.Function("predicting", inputs, outputs, {"cse": True})


def _cholesky(A: ca.SX) -> ca.SX:
    """The lower factor of a symmetric matrix, entry by entry."""
    n = A.shape[0]
    L = ca.SX.zeros(n, n)
    for j in range(n):
        L[j, j] = ca.sqrt(A[j, j] - sum((L[j, k] ** 2 for k in range(j)), ca.SX(0)))
        for i in range(j + 1, n):
            L[i, j] = (A[i, j] - sum((L[i, k] * L[j, k] for k in range(j)), ca.SX(0))) / L[j, j]
    return L


def _inverse_lower(L: ca.SX) -> ca.SX:
    """The inverse of a lower triangular matrix, entry by entry."""
    n = L.shape[0]
    X = ca.SX.zeros(n, n)
    for j in range(n):
        X[j, j] = 1.0 / L[j, j]
        for i in range(j + 1, n):
            X[i, j] = -sum((L[i, k] * X[k, j] for k in range(j, i)), ca.SX(0)) / L[i, i]
    return X


def _scan(function: ca.Function, state: np.ndarray, columns: list[np.ndarray]) -> list[np.ndarray]:
    """A step's function over all rows; what it gives besides the state, (k, size) each."""
    count = len(columns[0])
    buffer, evaluate = function.buffer()
    outputs = [np.empty((count, function.size1_out(i))) for i in range(1, function.n_out())]
    state = np.array(state, dtype=float)
    following = np.empty_like(state)
    arguments = [np.ascontiguousarray(column, dtype=float) for column in columns]
    for k in range(count):
        buffer.set_arg(0, memoryview(state))  # pyright: ignore[reportCallIssue, reportArgumentType]
        for i, column in enumerate(arguments):
            buffer.set_arg(i + 1, memoryview(column[k]))  # pyright: ignore[reportCallIssue, reportArgumentType]
        buffer.set_res(0, memoryview(following))  # pyright: ignore[reportCallIssue, reportArgumentType]
        for i, output in enumerate(outputs):
            buffer.set_res(i + 1, memoryview(output[k]))  # pyright: ignore[reportCallIssue, reportArgumentType]
        evaluate()
        state, following = following, state
    return outputs


class Predictor:
    """Prediction errors of one record as a function of the parameters.

    Args:
        n: number of rotors.
        mass: of the described robot, kg.
        root: mass (kg) and centre of mass (m) of its root link.
        dt: time of a step, s.
    """

    def __init__(self, n: int, mass: float, root: tuple[float, np.ndarray], dt: float) -> None:
        self.dt = dt
        self._filtering, self._predicting = _functions(n, mass, root[0], tuple(map(float, root[1])), dt)
        self.parameters = 10 + n

    def start(self, steps: Steps, theta: np.ndarray) -> np.ndarray:
        """The state that the first frame suggests, at rest, (18,)."""
        R = steps.attitude[0].reshape(3, 3) @ np.asarray(ca.DM(_exp(ca.SX(-theta[0:3])))).astype(float)
        p = steps.position[0] + R @ (steps.cog[0] + theta[3:6])
        return np.concatenate([p, np.zeros(3), R.ravel(), np.zeros(3)])

    def filtered(self, steps: Steps, theta: np.ndarray, noise: Noise, start: np.ndarray) -> Filtered:
        """The filter along a record, for these parameters and noise levels."""
        P = np.diag(np.repeat(START, 3) ** 2)
        dt = self.dt
        levels = np.repeat(
            [noise.position**2, noise.attitude**2, 1e-14, dt * noise.push**2, 1e-14, dt * noise.turn**2], 3
        )
        count = len(steps.fresh)
        columns = [np.tile(theta, (count, 1)), *steps, np.tile(levels, (count, 1))]
        gains, whitening, residuals = _scan(self._filtering, np.concatenate([start, P.ravel()]), columns)
        return Filtered(gains, whitening, residuals * steps.fresh)

    def predict(self, steps: Steps, theta: np.ndarray, start: np.ndarray, known: Filtered) -> Predicted:
        """Residuals and their derivatives by the parameters, with the filter's gains held."""
        state = np.concatenate([start, np.zeros(STATES * self.parameters)])
        columns = [np.tile(theta, (len(steps.fresh), 1)), *steps, known.gains, known.whitening]
        residuals, slopes = _scan(self._predicting, state, columns)
        slopes = slopes.reshape(len(residuals), self.parameters, MEASURED).transpose(0, 2, 1)
        used = steps.fresh
        return Predicted(residuals * used, slopes * used[:, :, None])
