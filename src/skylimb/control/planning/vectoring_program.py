"""The program for whole paths of vectoring angles, and what it sees of a posture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.polynomial import chebyshev

from skylimb.control.planning.nlp import ipopt, search
from skylimb.control.planning.vectoring_criteria import VectoringCriteria


@dataclass(frozen=True)
class Posture:
    """What a posture theta with vectoring angles psi gives, and the bounds of it.

    The function's outputs are the face distances and everything else that is bounded, one vector. `limits`
    are those of the vectoring joints, (n,) each.
    """

    function: ca.Function
    low: list[float]
    high: list[float]
    span: tuple[float, float]
    limits: tuple[np.ndarray, np.ndarray]


def turns_freely(lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """Which joints may turn without end."""
    return ~(np.isfinite(lower) | np.isfinite(upper))


class PathProgram:
    """The program for whole paths psi(theta) of one degree, at Chebyshev nodes and both ends.

    Every node sees the coefficients only through its own few angles, psi_k = C v_k. So the derivatives are
    those of the nodes, (v_k^T x J_k) and sum of (v_k v_k^T x H_k), far cheaper than those of the whole.
    """

    def __init__(
        self, posture: Posture, criteria: VectoringCriteria, degree: int, nodes: int, iterations: int
    ) -> None:
        self.degree, self.n = degree, posture.function.size1_in(1)
        low, high = posture.span
        x = np.concatenate([[-1.0], chebyshev.chebpts1(nodes), [1.0]])
        self.nodes = len(x)
        half = 0.5 * (high - low)
        values = chebyshev.chebvander(x, degree)
        slopes = chebyshev.chebval(x, chebyshev.chebder(np.eye(degree + 1))).T / half
        limited = np.flatnonzero(~turns_freely(*posture.limits)).tolist()
        self._low = [*posture.low, *[-criteria.slope] * self.n, *posture.limits[0][limited]] * self.nodes
        self._high = [*posture.high, *[criteria.slope] * self.n, *posture.limits[1][limited]] * self.nodes

        thetas = ca.DM(low + half * (1.0 + x)).T
        coefficients, t = ca.MX.sym("c", self.n, degree + 1), ca.MX.sym("t", self.nodes)
        unknown = ca.vertcat(ca.vec(coefficients), t)
        psi, slope = coefficients @ ca.DM(values.T), coefficients @ ca.DM(slopes.T)
        faces, bounded = posture.function.map(self.nodes)(thetas, psi)
        constraints = ca.vertcat(faces - ca.repmat(t.T, faces.shape[0], 1), bounded, slope, psi[limited, :])
        objective = (criteria.smoothing * ca.sumsqr(slope) - ca.sum1(t)) / self.nodes

        count, rest = faces.shape[0], self.n + len(limited)
        first, second = _node_derivatives(posture.function)
        J = ca.horzsplit(first.map(self.nodes)(thetas, psi), self.n)
        unit, picked = ca.DM.eye(self.n), ca.DM.eye(self.n)[limited, :]
        jacobian = ca.vertcat(
            *(
                ca.horzcat(
                    ca.vertcat(ca.kron(v, J_k), ca.kron(s, unit), ca.kron(v, picked)),
                    _column(k, count, bounded.shape[0] + rest, self.nodes),
                )
                for k, (J_k, v, s) in enumerate(zip(J, _rows(values), _rows(slopes), strict=True))
            )
        )
        sigma, multipliers = ca.MX.sym("sigma"), ca.MX.sym("lambda", constraints.numel())
        of_nodes = ca.reshape(multipliers, -1, self.nodes)[: count + bounded.shape[0], :]
        H = ca.horzsplit(second.map(self.nodes)(thetas, psi, of_nodes), self.n)
        smooth = 2.0 * criteria.smoothing / self.nodes * ca.kron(ca.DM(slopes.T @ slopes), unit)
        curved = sum((ca.kron(v.T @ v, H_k) for H_k, v in zip(H, _rows(values), strict=True)), sigma * smooth)
        hessian = ca.triu(ca.diagcat(curved, ca.MX(self.nodes, self.nodes)))

        g, none = ca.vec(constraints), ca.MX.sym("none", 0, 1)
        derivatives = {
            "jac_g": ca.Function("jac_g", [unknown, none], [g, jacobian]),
            "hess_lag": ca.Function("hess_lag", [unknown, none, sigma, multipliers], [hessian]),
        }
        problem = {"x": unknown, "f": objective, "g": g}
        self.ipopt = ipopt(problem, iterations, derivatives)

    def solve(self, start: Sequence[float] | np.ndarray) -> tuple[float, np.ndarray] | None:
        """Gain and coefficients (n, degree + 1) from a start, (n,) or (n, fewer); None without success."""
        start = np.asarray(start, dtype=float).reshape(self.n, -1)
        first = np.zeros((self.n, self.degree + 1))
        first[:, : start.shape[1]] = start
        x0 = np.concatenate([first.ravel(order="F"), np.full(self.nodes, 1.0)])
        found = search(self.ipopt, x0, lbg=self._low, ubg=self._high)
        if found is None:
            return None
        cost, x = found
        return -cost, x[: first.size].reshape(self.n, -1, order="F")


def _node_derivatives(posture: ca.Function) -> tuple[ca.Function, ca.Function]:
    """Of a posture's outputs h by psi: dh/dpsi, and d^2(lambda . h)/dpsi^2 from (theta, psi, lambda)."""
    theta, psi = ca.SX.sym("theta"), ca.SX.sym("psi", posture.size1_in(1))
    h = ca.vertcat(*posture(theta, psi))
    weights = ca.SX.sym("lambda", h.shape[0])
    curvature, _ = ca.hessian(ca.dot(weights, h), psi)
    # What is common to both is shared already; to look for more of it takes longer than it saves.
    first = ca.Function("first", [theta, psi], [ca.densify(ca.jacobian(h, psi))])
    second = ca.Function("second", [theta, psi, weights], [ca.densify(curvature)])
    return first, second


def _rows(matrix: np.ndarray) -> list[ca.DM]:
    return [ca.DM(row).T for row in matrix]


def _column(k: int, faces: int, others: int, nodes: int) -> ca.DM:
    """What t_k does to the constraints of its node: -1 for every face, nothing else."""
    column = ca.DM(faces + others, nodes)
    column[:faces, k] = -1.0
    return column
