"""One step of a robot that flies freely, in symbols, with its derivatives.

State of the true robot, at the time that a frame shows: place p and velocity v of the centre of gravity in W,
attitude R of the root link, and angular momentum per mass l about the centre of gravity, in W. With the
`Mechanics` of that moment, m the mass, s_i the thrust scale over the mass's, and lambda_i the thrusts behind
their lag,

    v' = R sum_i s_i lambda_i u_i / m - g + g lean,      l' = R sum_i s_i lambda_i (t_i - d x u_i) / m,
    R' = R hat(I^-1 (R^T l - h)),                         measured: p - R (c + d) and R Exp(e).

h is the angular momentum of what moves within the robot, per mass: that of the joints' own motion, and of the
rotors about their axes, spin_i J_i Omega_i u_i at the speeds of their thrusts.

Gravity g is a parameter too: over the Earth it differs by half a percent, which is a millimetre of centre of
gravity's height.

Momentum makes the joints' own motion exact and the rotors' reaction, and needs no acceleration of anything.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from skylimb.base.rotations import small_rotation, vee
from skylimb.studies.calibration.mechanics import layout
from skylimb.studies.calibration.steps import Steps
from skylimb.symbolic import cross

STATES = 12
"""p, v, a small turn of R, l."""

MEASURED = 6
"""Place and a small turn."""

_STANDS = 1e-6
"""Of a rotor that stands, N, so that its speed has a derivative."""


def _small(R: ca.SX) -> ca.SX:
    """The small vector of a rotation, rad."""
    return 0.5 * vee(R - R.T)


def _rows(flat: ca.SX, rows: int, columns: int) -> ca.SX:
    """A matrix from its entries row by row."""
    return ca.reshape(flat, columns, rows).T


class StepModel:
    """One step in symbols, for a robot with these wheels for rotors; see `Record.wheels`."""

    def __init__(self, wheels: np.ndarray, mass: float, root: tuple[float, np.ndarray], dt: float) -> None:
        n = len(wheels)
        self.n, self.wheels, self.mass, self.root, self.dt = n, wheels, mass, root, dt
        self.layout = layout(n)
        size = self.layout.size
        widths = (size, size, 3, 3, n, 2 * n, n, 2 * n, 3, 9, 1)
        self.given = Steps(*(ca.SX.sym(k, w) for k, w in zip(Steps._fields, widths, strict=True)))
        self.parameters = 11 + n
        self.x, self.theta = ca.SX.sym("x", 3 + 3 + 9 + 3), ca.SX.sym("theta", self.parameters)
        self.dx, self.dtheta = ca.SX.sym("dx", STATES), ca.SX.sym("dtheta", self.parameters)
        self.gain = ca.SX.sym("gain", STATES, MEASURED)

    def _beside(self, dx: ca.SX, dtheta: ca.SX) -> tuple[ca.SX, ...]:
        """State and parameters, a little beside their values."""
        x, theta, n = self.x, self.theta + dtheta, self.n
        R = _rows(x[6:15], 3, 3) @ small_rotation(dx[6:9])
        state = (x[0:3] + dx[0:3], x[3:6] + dx[3:6], R, x[15:18] + dx[9:12])
        return (*state, theta[0:3], theta[3:6], theta[6 : 6 + n], theta[8 + n : 10 + n], theta[10 + n])

    def residual(self, dx: ca.SX, dtheta: ca.SX) -> ca.SX:
        """What the frame differs from its prediction, m and rad, (6,)."""
        p, _, R, _, e, d, _, _, _ = self._beside(dx, dtheta)
        given, latency = self.given, dtheta[self.n + 7]
        c = given.cog + given.cog_rate * latency
        seen = R @ small_rotation(e)
        return ca.vertcat(given.position - (p - R @ (c + d)), _small(seen.T @ _rows(given.attitude, 3, 3)))

    def next(self, dx: ca.SX, dtheta: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX]:
        """p, v, R and l one step later, put right by the frame before."""
        p, v, R, momentum, _, d, scale, lean, gravity = self._beside(dx, dtheta)
        given, n, dt = self.given, self.n, self.dt
        right = given.fresh * (self.gain @ self.residual(dx, dtheta))
        p, v, R, momentum = (
            p + right[0:3],
            v + right[3:6],
            R @ small_rotation(right[6:9]),
            momentum + right[9:12],
        )
        lag, latency = dtheta[n + 6], dtheta[n + 7]
        m = self.layout.unpack(given.middle + given.middle_rate * latency)
        beside = ca.vertcat(lag, latency)
        commanded = given.thrusts + ca.reshape(given.thrusts_by, n, 2) @ beside
        thrusts = scale * commanded
        early = scale * (given.early + ca.reshape(given.early_by, n, 2) @ beside)
        root, centre = self.root[0], ca.DM(self.root[1])
        arm = centre - m.cog
        moments = m.moments + arm @ d.T + d @ arm.T + (self.mass / root - 1.0) * (d @ d.T)
        inertia = ca.inv_minor(ca.trace(moments) * ca.SX.eye(3) - moments)
        turning = self.wheels * ca.sqrt(ca.fmax(commanded, 0.0) + _STANDS)
        own = m.momentum + m.forces @ turning / self.mass - cross(d, m.cog_rate)
        force = m.forces @ thrusts / self.mass
        torque = m.torques @ thrusts / self.mass - cross(d, force)
        # Place and attitude need their rates' means over the step, which the early thrusts make.
        early_force = m.forces @ early / self.mass
        early_torque = m.torques @ early / self.mass - cross(d, early_force)
        mean = momentum + 0.5 * dt * (R @ early_torque)
        first = inertia @ (R.T @ mean - own)
        R_half, R_early = R @ small_rotation(0.5 * dt * first), R @ small_rotation(dt / 3.0 * first)
        weight = gravity * ca.vertcat(lean, -1.0)
        spin = inertia @ (R_half.T @ mean - own)
        return (
            p + dt * v + 0.5 * dt**2 * (R_early @ early_force + weight),
            v + dt * (R_half @ force + weight),
            R @ small_rotation(dt * spin),
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

        def at_zero(expression: ca.SX) -> ca.SX:
            (value,) = ca.substitute([expression], *at)
            return value

        following = ca.vertcat(plain[0], plain[1], ca.vec(plain[2].T), plain[3])
        slope = at_zero(ca.jacobian(beside, small))
        residual = self.residual(self.dx, self.dtheta)
        return following, slope, at_zero(residual), at_zero(ca.jacobian(residual, small))
