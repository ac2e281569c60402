"""Factors of small symmetric matrices of symbols, written out entry by entry, so that a step has no loop."""

from __future__ import annotations

import casadi as ca


def cholesky(A: ca.SX) -> ca.SX:
    """The lower factor of a symmetric matrix, entry by entry."""
    n = A.shape[0]
    L = ca.SX.zeros(n, n)
    for j in range(n):
        L[j, j] = ca.sqrt(A[j, j] - sum((L[j, k] ** 2 for k in range(j)), ca.SX(0)))
        for i in range(j + 1, n):
            L[i, j] = (A[i, j] - sum((L[i, k] * L[j, k] for k in range(j)), ca.SX(0))) / L[j, j]
    return L


def inverse_lower(L: ca.SX) -> ca.SX:
    """The inverse of a lower triangular matrix, entry by entry."""
    n = L.shape[0]
    X = ca.SX.zeros(n, n)
    for j in range(n):
        X[j, j] = 1.0 / L[j, j]
        for i in range(j + 1, n):
            X[i, j] = -sum((L[i, k] * X[k, j] for k in range(j, i)), ca.SX(0)) / L[i, i]
    return X
