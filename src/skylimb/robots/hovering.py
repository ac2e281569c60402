"""The hovering frame {C}, the allocation matrix in it and the hover thrusts, as CasADi expressions."""

from __future__ import annotations

from typing import Any, NamedTuple

import casadi as ca
import numpy as np

Array = Any
"""A CasADi matrix."""

_TURNS = 4
"""Turns of {C} when more than four rotors leave a choice. Each leaves about a tenth of the tilt before it:
after four, nine random postures in ten of a six-rotor robot have the net force within 2e-5 rad of z."""


class Hovering(NamedTuple):
    """Orientation of {C} (3 x 3), allocation matrix in it (6 x n), hover thrusts (n x 1, N)."""

    R_root_C: Array
    allocation: Array
    thrusts: Array


def hovering_frame(Q_t: Array, Q_r: Array, weight: float, preferred: np.ndarray | None) -> Hovering:
    """Turn {C} by roll and pitch until the net force of the hover thrusts lies along its z axis.

    Four rotors have one direction of thrusts without torque. A turn of the axes does not change it, so one
    turn is exact. More rotors leave a choice: the least-norm thrusts, evaluated again in the turned frame.

    Args:
        Q_t: force of 1 N of each rotor in root axes, (3, n).
        Q_r: torque of it about the centre of gravity, (3, n), m.
        weight: m g, N.
        preferred: of more than four rotors the thrusts (n,) that the hover's come nearest to, N; none: zero.
    """
    if Q_t.shape[1] == 4:
        free = _torque_free_direction(Q_r)
        force = Q_t @ free
        size = ca.sqrt(ca.sumsqr(force))
        up = ca.sign(force[2])  # thrusts must carry, not press down: z of {C} is the way up of the root frame
        z_axis, thrusts = force * (up / size), free * (up * weight / size)
    else:
        z_axis = ca.SX([0.0, 0.0, 1.0])
        for _ in range(_TURNS):
            force = Q_t @ _nearest(z_axis.T @ Q_t, Q_r, weight, preferred)
            z_axis = force / ca.sqrt(ca.sumsqr(force))
        thrusts = _nearest(z_axis.T @ Q_t, Q_r, weight, preferred)
    return hovering_in(_roll_pitch(z_axis), thrusts, Q_t, Q_r)


def hovering_in(R: Array, thrusts: Array, Q_t: Array, Q_r: Array) -> Hovering:
    """The allocation matrix in a known {C}; `Q_t` and `Q_r` as for `hovering_frame`."""
    return Hovering(R, ca.vertcat(R.T @ Q_t, R.T @ Q_r), thrusts)


def _torque_free_direction(Q_r: Array) -> Array:
    """The null vector of a 3 x 4 matrix, by its minors: free of divisions and pivots."""
    a, b, c = Q_r[0, :], Q_r[1, :], Q_r[2, :]
    pair = {(i, j): a[i] * b[j] - a[j] * b[i] for i in range(4) for j in range(i + 1, 4)}
    minors = []
    for left_out in range(4):
        i, j, k = (column for column in range(4) if column != left_out)
        minors.append(c[i] * pair[j, k] - c[j] * pair[i, k] + c[k] * pair[i, j])
    return ca.vertcat(minors[0], -minors[1], minors[2], -minors[3])


def _nearest(Q_tz: Array, Q_r: Array, weight: float, preferred: np.ndarray | None) -> Array:
    A, wanted = ca.vertcat(Q_tz, Q_r), ca.SX([weight, 0.0, 0.0, 0.0])
    if preferred is None:
        return A.T @ (ca.inv_minor(A @ A.T) @ wanted)
    return preferred + A.T @ (ca.inv_minor(A @ A.T) @ (wanted - A @ preferred))


def _roll_pitch(z_axis: Array) -> Array:
    """R = Ry(pitch) Rx(roll) whose third column is the unit vector `z_axis`, without trigonometry."""
    x, y, z = z_axis[0], z_axis[1], z_axis[2]
    cos_roll = ca.sqrt(x * x + z * z)
    sin_pitch, cos_pitch = x / cos_roll, z / cos_roll
    return ca.vertcat(
        ca.horzcat(cos_pitch, -sin_pitch * y, x),
        ca.horzcat(0, cos_roll, y),
        ca.horzcat(-sin_pitch, -cos_pitch * y, z),
    )
