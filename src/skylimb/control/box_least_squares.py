"""The nearest point of a box: weighted least squares within bounds, in CasADi, by an active set that ends.

Of all x with lower <= x <= upper, the one for which A x is nearest to A x_wanted; where there are several,
the one near x_wanted itself. That is

    minimise  |A (x - x_wanted)|^2 + epsilon |x - x_c|^2   over the box,

first with x_c = x_wanted, then again with x_c at the last answer (the proximal point method). Each round
takes what the term with epsilon still costs in |A (x - x_wanted)| down by epsilon / (epsilon + sigma^2), with
sigma the least singular value that counts, and leaves alone what A does not see.

One iteration of the primal active-set method (Nocedal and Wright, Numerical Optimization, algorithm 16.3):
solve for the free entries, go there or to the first bound on the way, which then holds; at the least point of
a face, free the entry whose bound pulls the most the wrong way, or end.

Why it ends. Each problem is strictly convex, and the bounds that hold are linearly independent, so every
freed entry moves inward and lowers the cost. A face has one least point, so none is met twice: a round ends
after at most 3^n faces, with at most n bounds in a row before each. That bound is far away in practice: a
million random problems with 4, 6 and 8 entries took 24 iterations at most (docs/reports/allocation.md). So
they stop at `ITERATIONS`. Wherever they stop, x is inside of the box and costs no more than x_wanted cut off.

A point that is inside of the box from the start costs a comparison: iterations are skipped, not computed in
vain, by a branch that CasADi and its C code share.
"""

from __future__ import annotations

import functools
from typing import NamedTuple

import casadi as ca

from skylimb.symbolic import clip, solve_positive

ROUNDS = 3
"""Proximal rounds."""

ITERATIONS = 64
"""Greatest number of active-set iterations of all rounds together."""

BLOCK = 4
"""Iterations between two looks at whether it has ended: a branch costs about as much as two iterations."""

_EPSILON = 1e-8
"""Of the mean eigenvalue of A^T A: small beside what A sees, large beside rounding."""

_WRONG_WAY = 1e-12
"""Pull of a bound that counts as none, in units of an entry of x."""


class _State(NamedTuple):
    """Between two iterations, (n,) each but for the last two.

    Attributes:
        x: inside of the box.
        gradient: half of the cost's there.
        center: x_c of this round.
        free: 1 where no bound holds x, else 0.
        round: number of rounds that have ended.
        iterations: so far.
    """

    x: ca.SX
    gradient: ca.SX
    center: ca.SX
    free: ca.SX
    round: ca.SX
    iterations: ca.SX


@functools.lru_cache(maxsize=16)
def nearest_in_box(rows: int, n: int) -> ca.Function:
    """(A, wanted, lower, upper) -> (x, iterations), to be called with numbers or inside of a traced function.

    Args:
        rows: of A.
        n: entries of x.

    Returns:
        A function of A (rows, n), x_wanted, lower and upper (n,), which gives x (n,) and the number of
        iterations that were made: 0 where x_wanted is in the box and comes back as it is.
    """
    shapes = {"A": (rows, n), "wanted": (n, 1), "lower": (n, 1), "upper": (n, 1)}
    _, wanted, lower, upper = given = [ca.MX.sym(name, *shape) for name, shape in shapes.items()]
    state, H = _start(rows, n)(*given)
    state = _repeated(_block(n), n)(state, H, wanted, lower, upper)
    search = ca.Function("search", given, [state[:n], state[_size(n) - 1]])
    inside = ca.Function("inside", given, [wanted, 0])
    outside = ca.mmax(ca.fmax(lower - wanted, wanted - upper)) > 0.0
    x, iterations = ca.Function.if_else("search_outside", search, inside)(outside, *given)
    return ca.Function(
        "nearest_in_box", given, [x, iterations], [*shapes], ["x", "iterations"], {"never_inline": True}
    )


def _start(rows: int, n: int) -> ca.Function:
    """(A, wanted, lower, upper) -> (state, H) before the first iteration."""
    A, wanted = ca.SX.sym("A", rows, n), ca.SX.sym("wanted", n)
    lower, upper = ca.SX.sym("lower", n), ca.SX.sym("upper", n)
    x = clip(wanted, lower, upper)
    H = ca.SX(n, n)
    for i in range(n):
        for j in range(i + 1):
            H[i, j] = H[j, i] = ca.dot(A[:, i], A[:, j])
    H = H * (n / (ca.trace(H) + 1e-300)) + _EPSILON * ca.SX.eye(n)
    begin = _State(x, H @ (x - wanted), wanted, (x > lower) * (x < upper), ca.SX(0), ca.SX(0))
    return ca.Function("start", [A, wanted, lower, upper], [_flat(begin), H], {"cse": True})


def _fixed(n: int) -> list[ca.MX]:
    """Symbols of what stays the same in all iterations."""
    return [
        ca.MX.sym("H", n, n),
        *(ca.MX.sym(name, n) for name in ("wanted", "lower", "upper")),
    ]


def _size(n: int) -> int:
    """Of a flat state."""
    return 4 * n + 2


def _flat(state: _State) -> ca.SX:
    return ca.densify(ca.vertcat(*state))


def _repeated(block: ca.Function, n: int) -> ca.Function:
    """`ITERATIONS` steps: a block, then the next ones only where that has not ended it."""
    state, fixed = ca.MX.sym("state", _size(n)), _fixed(n)
    steps, done = block, ca.Function("done", [state, *fixed], [state])
    for count in range(2 * BLOCK, ITERATIONS + 1, BLOCK):
        more = ca.Function.if_else(f"more_{count}", steps, done)
        after = block(state, *fixed)
        ended = after[_size(n) - 2] >= ROUNDS
        steps = ca.Function(f"steps_{count}", [state, *fixed], [more(ca.logic_not(ended), after, *fixed)])
    return steps


def _block(n: int) -> ca.Function:
    """`BLOCK` iterations without a branch; those after the end change nothing."""
    state, H = ca.SX.sym("state", _size(n)), ca.SX.sym("H", n, n)
    fixed = [H, *(ca.SX.sym(name, n) for name in ("wanted", "lower", "upper"))]
    iterate, after = _iteration(n), state
    for _ in range(BLOCK):
        after = ca.if_else(after[_size(n) - 2] < ROUNDS, iterate(after, *fixed), after)
    return ca.Function("block", [state, *fixed], [after], {"cse": True})


def _iteration(n: int) -> ca.Function:
    """(state, H, wanted, lower, upper) -> state after one iteration of the active set."""
    flat, H = ca.SX.sym("state", _size(n)), ca.SX.sym("H", n, n)
    wanted, lower, upper = (ca.SX.sym(name, n) for name in ("wanted", "lower", "upper"))
    old = _State(*ca.vertsplit(flat, [0, n, 2 * n, 3 * n, 4 * n, 4 * n + 1, 4 * n + 2]))

    # The least point of the face: rows and columns of held entries are those of the identity.
    masked = H * (old.free @ old.free.T) + ca.diag(1.0 - old.free)
    move = solve_positive(masked, -old.free * old.gradient)

    # As far as the first bound on the way.
    bound = ca.if_else(move > 0.0, upper, lower)
    moves = old.free * (move != 0.0)
    room = ca.if_else(moves, (bound - old.x) / (move + (1.0 - moves)), 2.0)
    nearest = ca.mmin(room)
    arrived = nearest >= 1.0
    stopped = (room <= nearest) * ca.logic_not(arrived)
    x = ca.if_else(stopped, bound, clip(old.x + ca.fmin(nearest, 1.0) * move, lower, upper))
    held = old.free * ca.logic_not(stopped)

    # At the least point of the face: free the entry whose bound pulls the most the wrong way.
    gradient = H @ (x - wanted) + _EPSILON * (wanted - old.center)
    wrong = (1.0 - held) * ca.if_else(x <= lower, -gradient, gradient)
    worst = ca.mmax(wrong)
    ended = arrived * (worst <= _WRONG_WAY)
    freed = (wrong >= worst) * arrived * ca.logic_not(ended)
    new = _State(
        x,
        gradient - ended * _EPSILON * (x - old.center),
        old.center + ended * (x - old.center),
        ca.fmax(held, freed),
        old.round + ended,
        old.iterations + 1,
    )
    return ca.Function("iteration", [flat, H, wanted, lower, upper], [_flat(new)], {"cse": True})
