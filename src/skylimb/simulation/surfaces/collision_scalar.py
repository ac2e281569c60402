"""The arithmetic of collision.c in plain Python numbers, for machines without a C compiler.

A surface is its list of numbers, from the kind on. Each function takes a point (w, u, v) and returns the
signed distance of the point from the surface and the outward unit normal, (distance, n_w, n_u, n_v).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

Touch = tuple[float, float, float, float]
Derivatives = tuple[float, float, float, float, float, float]

_SEAM = 1e-12
_NOWHERE: Touch = (math.inf, -1.0, 0.0, 0.0)


def touch(numbers: Sequence[float], w: float, u: float, v: float, reach: float) -> Touch:
    """Distance and normal at the surface that `numbers` describe; infinitely far when not within `reach`."""
    kind = numbers[0]
    if kind == 1.0:
        return _profile(numbers, w, u)
    return _graph(_wave if kind == 2.0 else _spline, numbers, w, u, v, reach)


def _profile(numbers: Sequence[float], w: float, u: float) -> Touch:
    nearest = _NOWHERE
    for first in range(2, 2 + 8 * int(numbers[1]), 8):
        kind, at_u, at_w, du, dw, extent, cosine, _ = numbers[first : first + 8]
        x, y = u - at_u, w - at_w
        if kind == 0.0:
            along = x * du + y * dw
            if not -_SEAM <= along <= extent + _SEAM:
                continue
            nu, nw = dw, -du
            distance = x * nu + y * nw
        else:
            length = math.hypot(x, y)
            if length < 1e-12 or x * du + y * dw < (cosine - _SEAM) * length:
                continue
            side = 1.0 if kind == 1.0 else -1.0
            nu, nw = side * x / length, side * y / length
            distance = side * (length - extent)
        if abs(distance) < abs(nearest[0]):
            nearest = (distance, nw, nu, 0.0)
    return nearest


def _graph(
    derivatives: Callable[[Sequence[float], float, float], Derivatives],
    numbers: Sequence[float],
    w: float,
    u0: float,
    v0: float,
    reach: float,
) -> Touch:
    u, v = u0, v0
    h, hu, hv, huu, huv, hvv = derivatives(numbers, u, v)
    if h - w > 10.0 * reach:
        return _NOWHERE
    for _ in range(20):
        e = h - w
        gu, gv = u - u0 + e * hu, v - v0 + e * hv
        a, b, c = 1.0 + hu * hu, hu * hv, 1.0 + hv * hv
        A, B, C = a + e * huu, b + e * huv, c + e * hvv
        det = A * C - B * B
        if 0.1 * a > A or det < 0.1 * (a * c - b * b):
            A, B, C, det = a, b, c, a * c - b * b
        su, sv = (C * gu - B * gv) / det, (A * gv - B * gu) / det
        u, v = u - su, v - sv
        h, hu, hv, huu, huv, hvv = derivatives(numbers, u, v)
        if su * su + sv * sv < 1e-20:
            break
    scale = 1.0 / math.sqrt(1.0 + hu * hu + hv * hv)
    nw, nu, nv = -scale, hu * scale, hv * scale
    return (w - h) * nw + (u0 - u) * nu + (v0 - v) * nv, nw, nu, nv


def _wave(numbers: Sequence[float], u: float, v: float) -> Derivatives:
    amplitude, k = numbers[1], numbers[2]
    angle = k * u + numbers[3]
    s, c = amplitude * math.sin(angle), amplitude * math.cos(angle)
    return s + numbers[4], k * c, 0.0, -k * k * s, 0.0, 0.0


def _cubic(t: float) -> tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]]:
    s = 1.0 - t
    p, q = (3 * t * t * t - 6 * t * t + 4) / 6, (3 * s * s * s - 6 * s * s + 4) / 6
    value = (s * s * s / 6, p, q, t * t * t / 6)
    first = (-s * s / 2, (9 * t * t - 12 * t) / 6, -(9 * s * s - 12 * s) / 6, t * t / 2)
    return value, first, (s, 3 * t - 2, 3 * s - 2, t)


def _spline(numbers: Sequence[float], u: float, v: float) -> Derivatives:
    nu, nv, pitch = int(numbers[1]), int(numbers[2]), numbers[5]
    x, y = (u - numbers[3]) / pitch, (v - numbers[4]) / pitch
    inner_x, inner_y = min(max(x, 1.0), nu - 2.0), min(max(y, 1.0), nv - 2.0)
    beyond_x, beyond_y = x - inner_x, y - inner_y
    i, j = min(int(inner_x), nu - 3), min(int(inner_y), nv - 3)
    bu, bv = _cubic(inner_x - i), _cubic(inner_y - j)
    h = hu = hv = huu = huv = hvv = 0.0
    for a in range(4):
        start = 6 + (i - 1 + a) * nv + j - 1
        c0, c1, c2, c3 = numbers[start : start + 4]
        row, slope, bend = (c0 * b[0] + c1 * b[1] + c2 * b[2] + c3 * b[3] for b in bv)
        h += bu[0][a] * row
        hu += bu[1][a] * row
        huu += bu[2][a] * row
        hv += bu[0][a] * slope
        huv += bu[1][a] * slope
        hvv += bu[0][a] * bend
    if beyond_x != 0.0 or beyond_y != 0.0:
        h += hu * beyond_x + hv * beyond_y + huv * beyond_x * beyond_y
        hu, hv = hu + huv * beyond_y, hv + huv * beyond_x
        huu, hvv = huu * (beyond_x == 0.0), hvv * (beyond_y == 0.0)
    square = pitch * pitch
    return h, hu / pitch, hv / pitch, huu / square, huv / square, hvv / square
