"""Rotations and cross products that work on NumPy arrays and on CasADi symbols alike.

Conventions: `R_AB` turns coordinates in frame B into coordinates in frame A; quaternions are (w, x, y, z);
roll, pitch and yaw compose as R = Rz(yaw) Ry(pitch) Rx(roll); angles in radians. A function handed any CasADi
argument returns a CasADi matrix, otherwise a NumPy array. Vectors are (3,) in NumPy and 3 x 1 in CasADi.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any

import numpy as np

from skylimb.symbolic import Array, arctan2, cos, dot, matrix, sin, vector, where


def wrapped(angle: Any) -> Any:
    """The same angle within -pi .. pi (NumPy only), entry by entry; pi itself becomes -pi."""
    return (angle + np.pi) % (2.0 * np.pi) - np.pi


def hat(v: Array) -> Array:
    """The skew-symmetric matrix of a 3-vector; its product with w is the cross product of v and w."""
    return matrix([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def vee(S: Array) -> Array:
    """The 3-vector of a skew-symmetric matrix, the inverse of `hat`."""
    return vector(S[2, 1], S[0, 2], S[1, 0])


def rot_x(angle: Any) -> Array:
    """Rotation about x."""
    c, s = cos(angle), sin(angle)
    return matrix([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def rot_y(angle: Any) -> Array:
    """Rotation about y."""
    c, s = cos(angle), sin(angle)
    return matrix([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def rot_z(angle: Any) -> Array:
    """Rotation about z."""
    c, s = cos(angle), sin(angle)
    return matrix([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def rotation_from_rpy(roll: Any, pitch: Any, yaw: Any) -> Array:
    """Roll about x, then pitch about y, then yaw about z: the order of eq:target roll and pitch angle."""
    return rot_z(yaw) @ rot_y(pitch) @ rot_x(roll)


def rotation_from_axis_angle(axis: Sequence[float] | Array, angle: Any) -> Array:
    """Rotation by `angle` about a constant unit `axis` (Rodrigues' formula)."""
    c, s = cos(angle), sin(angle)
    K = hat(np.asarray(axis, dtype=float))
    return np.eye(3) + K * s + (K @ K) * (1.0 - c)


def rotation_from_vector(v: Array) -> Array:
    """Rotation about `v` (3,) by its length, rad; exact but for the square of 1e-9 rad."""
    size = (dot(v, v) + 1e-18) ** 0.5
    c, s = cos(size), sin(size)
    K = hat(v / size)
    return np.eye(3) + K * s + (K @ K) * (1.0 - c)


def rotation_from_quaternion(q: Array) -> Array:
    """Rotation matrix of a unit quaternion (w, x, y, z)."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    return matrix(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def quaternion_product(a: Array, b: Array) -> Array:
    """The quaternion a * b, both (w, x, y, z)."""
    return vector(
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    )


def small_turn(first: Array, then: Array) -> Array:
    """The turn from an attitude, a unit quaternion (w, x, y, z), to a near one, in body axes, rad, (3,)."""
    way = quaternion_product(vector(first[0], -first[1], -first[2], -first[3]), then)
    return 2.0 * where(way[0] < 0.0, -1.0, 1.0) * way[1:4]


def quaternion_from_rotation(R: np.ndarray) -> np.ndarray:
    """Unit quaternion (w, x, y, z), w >= 0, of a rotation matrix (NumPy only)."""
    return np.array(_quaternion_of(np.ascontiguousarray(R, dtype=float).tobytes()))


# A description's rotations are asked for again with every plant that is built of it.
@functools.lru_cache(maxsize=1024)
def _quaternion_of(R: bytes) -> tuple[float, ...]:
    """From the largest of w, x, y, z, so that no small number divides; SciPy's takes 0.2 s to import."""
    m = np.frombuffer(R).reshape(3, 3).tolist()
    trace = m[0][0] + m[1][1] + m[2][2]
    i = max(range(3), key=lambda k: m[k][k])
    if trace >= m[i][i]:
        w, axis = 1.0 + trace, [m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]]
    else:
        j, k = (i + 1) % 3, (i + 2) % 3
        w, axis = m[k][j] - m[j][k], [0.0, 0.0, 0.0]
        axis[i], axis[j], axis[k] = 1.0 - trace + 2.0 * m[i][i], m[j][i] + m[i][j], m[k][i] + m[i][k]
    x, y, z = axis
    size = (x * x + y * y + z * z + w * w) ** 0.5 * (-1.0 if w < 0.0 else 1.0)
    return w / size, x / size, y / size, z / size


def rpy_from_rotation(R: Array) -> Array:
    """Roll, pitch and yaw of R = Rz(yaw) Ry(pitch) Rx(roll), away from pitch = +-pi/2."""
    horizontal = (R[2, 1] * R[2, 1] + R[2, 2] * R[2, 2]) ** 0.5
    return vector(arctan2(R[2, 1], R[2, 2]), arctan2(-R[2, 0], horizontal), arctan2(R[1, 0], R[0, 0]))


def rotation_error(R: Array, R_ref: Array) -> Array:
    """e_R of eq:error of rotation: the vee of (R_ref^T R - R^T R_ref) / 2, in the frame of R."""
    return 0.5 * vee(R_ref.T @ R - R.T @ R_ref)


def rotation_from_x_to(axis: tuple[float, ...] | np.ndarray) -> np.ndarray:
    """(3, 3) the smallest rotation that takes the world's x to `axis`."""
    w = np.asarray(axis, dtype=float)
    w = w / np.linalg.norm(w)
    x = np.array([1.0, 0.0, 0.0])
    turn = np.cross(x, w)
    sine = float(np.linalg.norm(turn))
    if sine < 1e-12:
        return np.eye(3) if w[0] > 0 else rot_z(np.pi)
    return rotation_from_axis_angle((turn / sine).tolist(), float(np.arctan2(sine, w[0])))


def small_rotation(v: Array) -> Array:
    """Rotation by a small vector (rad), orthogonal up to third order (Cayley)."""
    # (I - V/2)^-1 (I + V/2) in closed form.
    half = 0.5 * v
    square = half[0] ** 2 + half[1] ** 2 + half[2] ** 2
    V = hat(half)
    return np.eye(3) + (2.0 / (1.0 + square)) * (V + V @ V)
