"""The closed loop over one control period as one matrix: plant, sensors and controller.

With x the plant's tangent state, s the tick's own state (sensor history, controller, clock) and u the
controls,

    u = K_x x + K_s s,      s' = S_x x + S_s s,      x' = A x + B u,

so that d(x', s') = [[A + B K_x, B K_s], [S_x, S_s]] d(x, s). K and S are exact derivatives of the compiled
tick, A and B are differences of the engine's steps.

Not every state is in the loop. Clocks run whatever happens; the tare's mean, the covariances and the energy
in a full tank are written and never answer, or answer and are never written. In the directed graph of the
matrix's entries, a loop is a strongly connected component, and the eigenvalues of the whole are those of its
components; only those components that hold states of the plant are judged.

Some directions of the loop are neutral by design, with an eigenvalue of one: on a path the flight may be
anywhere on it, and the anchor of the centre of gravity anywhere along the contact axis, while the arm makes
up the rest. They are counted, not judged.

Where a value stands exactly on a limit (a pace of one), the derivative is half of that beside it. Where the
path rests, the length of its velocity has no derivative, and that by clock and pace is no number: these
columns are differences. They are zero, as a reference that stays depends on no clock.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import casadi as ca
import mujoco
import numpy as np
from scipy.linalg import eig
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from skylimb.studies.verification.stability.modes import Mode
from skylimb.studies.verification.stability.plant import plant_transition, tangent_map
from skylimb.studies.verification.stability.point import OperatingPoint

NEUTRAL = 1e-5
"""Eigenvalues as near to one as this are neutral: a growth of 0.002 1/s."""

_ASIDE = 2.0**-20
"""Of a state whose derivative has a column that is no number: a tick, or a pace."""


@dataclass(frozen=True)
class ClosedLoop:
    """The linearised closed loop.

    Attributes:
        matrix: over one control period, (n, n).
        names: of the states, (n,).
        plant_size: how many of the first ones are the plant's.
        period: s.
    """

    matrix: np.ndarray
    names: tuple[str, ...]
    plant_size: int
    period: float

    @cached_property
    def in_loop(self) -> np.ndarray:
        """(n,) whether a state is in a loop with the plant."""
        return in_loop(self.matrix, self.plant_size)

    @cached_property
    def _values(self) -> np.ndarray:
        """Eigenvalues of the loop."""
        inside = self.in_loop
        return np.linalg.eigvals(self.matrix[np.ix_(inside, inside)])

    @cached_property
    def _spectrum(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Eigenvalues of the loop, and its left and right eigenvectors as columns."""
        inside = self.in_loop
        found: Any = eig(self.matrix[np.ix_(inside, inside)], left=True, right=True)
        return found[0], found[1], found[2]

    @property
    def neutral(self) -> int:
        """How many eigenvalues are one, but for rounding."""
        return int((abs(self._values - 1.0) < NEUTRAL).sum())

    @cached_property
    def dominant(self) -> Mode:
        """The mode that grows fastest or dies slowest, without the states that take part."""
        values = self._values[abs(self._values - 1.0) >= NEUTRAL]
        value = values[np.argmax(abs(values))]
        return Mode(complex(value.real, abs(value.imag)), self.period, ())

    @property
    def stable(self) -> bool:
        """Whether every perturbation dies away, or stays where the loop is neutral."""
        return abs(self.dominant.eigenvalue) < 1.0

    @property
    def growth(self) -> float:
        """Of the mode that grows fastest or dies slowest, 1/s."""
        return self.dominant.growth

    def modes(self, count: int = 8) -> list[Mode]:
        """The slowest to die away first; a pair of eigenvalues counts once.

        Args:
            count: how many at most.
        """
        values, left, right = self._spectrum
        names = [name for name, inside in zip(self.names, self.in_loop, strict=True) if inside]
        wanted = [
            i
            for i in np.argsort(-abs(values))
            if abs(values[i] - 1.0) >= NEUTRAL and np.imag(values[i]) >= 0.0
        ]
        return [
            Mode(complex(values[i]), self.period, _parts(names, left[:, i], right[:, i]))
            for i in wanted[:count]
        ]

    def direction(self, mode: Mode) -> np.ndarray:
        """A real direction of the state in which a mode alone is excited, (n,); the largest entry is 1."""
        vector = np.real(self._vector(mode, 2))
        return vector / abs(vector).max()

    def amplitude(self, mode: Mode, states: np.ndarray) -> np.ndarray:
        """How far states (k, n) are excited in a mode, (k,), complex; it goes with the eigenvalue."""
        return states @ self._vector(mode, 1).conj()

    def _vector(self, mode: Mode, which: int) -> np.ndarray:
        """The left (1) or right (2) eigenvector of a mode over all states, (n,)."""
        found = np.zeros(len(self.names), dtype=complex)
        nearest = int(np.argmin(abs(self._spectrum[0] - mode.eigenvalue)))
        found[self.in_loop] = self._spectrum[which][:, nearest]
        return found


def in_loop(matrix: np.ndarray, plant_size: int) -> np.ndarray:
    """Whether a state of a loop's matrix (n, n), the plant's first, is in a loop with the plant, (n,)."""
    count, component = connected_components(csr_array(matrix != 0.0), connection="strong")
    mine = np.zeros(count, dtype=bool)
    mine[component[:plant_size]] = True
    return mine[component]


def _parts(names: list[str], left: np.ndarray, right: np.ndarray) -> tuple[tuple[str, float], ...]:
    """Participation of each group of states in a mode: |l_i r_i|, which no choice of units changes."""
    share = abs(left.conj() * right)
    share = share / share.sum()
    groups: dict[str, float] = {}
    for name, value in zip(names, share, strict=True):
        group = name.partition("[")[0]
        # A register of past values is one thing, however many ticks it holds.
        group = ".".join(part for part in group.split(".") if not part.isdigit())
        groups[group] = groups.get(group, 0.0) + float(value)
    return tuple(sorted(groups.items(), key=lambda item: -item[1])[:6])


def linearise(point: OperatingPoint) -> ClosedLoop:
    """The closed loop at a moment of a flight."""
    A, B = plant_transition(point)
    K_x, K_s, S_x, S_s = loop_parts(point)
    matrix = np.block([[A + B @ K_x, B @ K_s], [S_x, S_s]])
    return ClosedLoop(matrix, (*plant_names(point), *point.names), len(A), point.period)


def loop_parts(point: OperatingPoint) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """K_x, K_s, S_x and S_s of the tick at a point; x is the plant's tangent state, s the tick's own."""
    data, m = point.data(), len(point.state)
    plant = data.qpos, data.qvel, data.act, data.history
    known = point.row, point.references.ravel(), point.gains, point.tick.rotors
    J = np.array(tick_jacobian(point.tick.function)(point.state, *plant, *known))

    def flown(state: np.ndarray) -> np.ndarray:
        """Next state, controls and joint forces."""
        after, controls, _, forces = point.tick.function(state, *plant, *known)
        return np.concatenate([np.asarray(after), np.asarray(controls), np.asarray(forces)]).ravel()

    for column in np.flatnonzero(np.isnan(J[:, :m]).any(axis=0)):
        aside = np.zeros(m)
        aside[column] = _ASIDE
        J[:, column] = (flown(point.state + aside) - flown(point.state - aside)) / (2.0 * _ASIDE)
    by_state, by_plant = J[:, :m], J[:, m:] @ _to_outputs(point.plant.model, point.qpos)
    return by_plant[m:], by_state[m:], by_plant[:m], by_state[:m]


def _to_outputs(model: mujoco.MjModel, qpos: np.ndarray) -> np.ndarray:
    """Derivative of (qpos, qvel, act) by the tangent of the plant."""
    G = tangent_map(model, qpos)
    nq, nv = G.shape
    na = int(model.na)
    found = np.zeros((nq + nv + na, 2 * nv + na))
    found[:nq, :nv], found[nq:, nv:] = G, np.eye(nv + na)
    return found


def plant_names(point: OperatingPoint) -> tuple[str, ...]:
    """A name for each entry of the plant's tangent state."""
    model = point.plant.model
    dofs = ["x", "y", "z", "turn about x", "turn about y", "turn about z"]
    dofs += [model.joint(i).name for i in range(1, model.njnt)]
    rotors = [model.actuator(i).name for i in range(model.na)]
    return (
        *(f"position {name}" for name in dofs),
        *(f"velocity {name}" for name in dofs),
        *(f"actuator {name}" for name in rotors),
    )


@lru_cache(maxsize=8)
def tick_jacobian(tick: ca.Function) -> ca.Function:
    """Derivative of (next state, controls, joint forces) by (state, qpos, qvel, act), at a tick's inputs."""
    given = [ca.SX.sym(tick.name_in(i), tick.sparsity_in(i)) for i in range(tick.n_in())]
    state, controls, _, forces = tick(*given)
    J = ca.jacobian(ca.vertcat(state, controls, forces), ca.vertcat(*given[:4]))
    return ca.Function("tick_jacobian", given, [J])
