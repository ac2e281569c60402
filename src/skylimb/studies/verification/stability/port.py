"""The admittance of the tip as the closed loop makes it, and whether it is passive.

With the surface taken away and its force held, a further force F on the tip moves it. Over one control period

    x' = M x + N F,        p = C x,

with F constant over it and p the place of the tip. The energy that goes in is F (p' - p), so the admittance
that counts for it, from force to mean velocity, is

    Y(z) = (z - 1) / T C (z - M)^-1 N.

A port is passive when (Y + Y^H) / 2 has no negative eigenvalue on z = exp(i w T): no passive environment can
then make it grow (Colgate, Hogan, Int. J. Control 48(1), 1988). Where it is not, some could; the simplest is
a spring, whose least stiffness that makes the loop grow is sought by its eigenvalues, and the damper beside
it that it takes to keep the loop from growing with any spring. Both answer in every physics step, not once a
period.
"""

from __future__ import annotations

import copy
import dataclasses
from dataclasses import dataclass

import mujoco
import numpy as np

from skylimb.analysis.scores.signals import stretches
from skylimb.base.errors import ConfigError
from skylimb.simulation.robot_bodies import TIP_SITE
from skylimb.simulation.surfaces.geom import GEOM
from skylimb.studies.verification.rig import touches
from skylimb.studies.verification.stability.closed_loop import ClosedLoop, in_loop, loop_parts
from skylimb.studies.verification.stability.plant import plant_transition, push_response
from skylimb.studies.verification.stability.point import OperatingPoint

_AWAY = 1000.0  # m, by which the surface is taken away
_PASSIVE = 1e-9
"""Share of the greatest admittance by which a real part may be negative, for rounding."""
_FLOOR = 1e-2
"""Growth that does not count, 1/s."""


@dataclass(frozen=True)
class TipPort:
    """A closed loop with a force on its tip along one axis or several.

    Attributes:
        A: plant over one physics step, (n, n).
        B: controls and joint forces, held over it, (n, nu + nv).
        push: force on the tip, held over it, (n, k).
        place: of the tip along the same axes, (k, n).
        speed: of the tip along them, (k, n).
        feedback: (K_x, K_s, S_x, S_s) of the control tick: u = K_x x + K_s s and s' = S_x x + S_s s.
        substeps: physics steps in a control period.
        period: of control, s.
    """

    A: np.ndarray
    B: np.ndarray
    push: np.ndarray
    place: np.ndarray
    speed: np.ndarray
    feedback: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
    substeps: int
    period: float

    def along(self, direction: np.ndarray) -> TipPort:
        """The port along one direction (k,) alone."""
        d = np.asarray(direction, dtype=float)[:, None]
        return dataclasses.replace(self, push=self.push @ d, place=d.T @ self.place, speed=d.T @ self.speed)

    def over_period(self, stiffness: float = 0.0, damper: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """M and N over one control period, with a spring (N/m) and a damper (N s/m) at the tip.

        Both act along all axes of the port.
        """
        step = self.A - self.push @ (stiffness * self.place + damper * self.speed)
        A, B, push = np.eye(len(step)), np.zeros_like(self.B), np.zeros_like(self.push)
        for _ in range(self.substeps):
            A, B, push = step @ A, step @ B + self.B, step @ push + self.push
        K_x, K_s, S_x, S_s = self.feedback
        M = np.block([[A + B @ K_x, B @ K_s], [S_x, S_s]])
        return M, np.vstack([push, np.zeros((len(S_s), push.shape[1]))])

    def admittance(self, frequencies: np.ndarray) -> np.ndarray:
        """Y at frequencies in Hz, below half the control rate, (f, k, k), m/s/N."""
        M, N = self.over_period()
        C = np.hstack([self.place, np.zeros((len(self.place), len(M) - self.place.shape[1]))])
        # What is in no loop with the plant neither answers nor is answered.
        inside = in_loop(M, self.place.shape[1])
        M, N, C = M[np.ix_(inside, inside)], N[inside], C[:, inside]
        z = np.exp(2.0j * np.pi * np.asarray(frequencies) * self.period)
        return np.array([(w - 1.0) / self.period * C @ np.linalg.solve(w * np.eye(len(M)) - M, N) for w in z])

    def growth(self, stiffness: float, damper: float = 0.0) -> float:
        """Of the fastest mode, 1/s, with a spring (N/m) and a damper (N s/m) at the tip; no neutral ones."""
        M, _ = self.over_period(stiffness, damper)
        return ClosedLoop(M, (), self.place.shape[1], self.period).growth

    def unstable_springs(self, stiffnesses: np.ndarray) -> tuple[float, float] | None:
        """The least and the greatest of rising `stiffnesses` with which a mode grows, N/m, or None.

        The least one is found to a thousandth between them.

        Args:
            stiffnesses: of the spring, N/m.
        """
        grows = np.flatnonzero([self.growth(float(k)) > _FLOOR for k in stiffnesses])
        if len(grows) == 0:
            return None
        first = int(grows[0])
        low = float(stiffnesses[first - 1]) if first else 0.0
        high = float(stiffnesses[first])
        while high - low > 1e-3 * high:
            middle = 0.5 * (low + high)
            low, high = (low, middle) if self.growth(middle) > _FLOOR else (middle, high)
        return high, max(high, float(stiffnesses[grows[-1]]))

    def calming_damper(self, stiffnesses: np.ndarray, dampers: np.ndarray) -> float | None:
        """The least of rising `dampers` beside which a spring of none of the `stiffnesses` makes a mode grow.

        Args:
            stiffnesses: of the springs, N/m.
            dampers: N s/m.

        Returns:
            The damper, N s/m; None where each of them leaves a spring that does.
        """
        calm = (
            float(damper)
            for damper in dampers
            if all(self.growth(float(stiffness), float(damper)) <= _FLOOR for stiffness in stiffnesses)
        )
        return next(calm, None)


def real_part(Y: np.ndarray) -> np.ndarray:
    """Least eigenvalue of (Y + Y^H) / 2 of each admittance (f, k, k), (f,); negative: energy comes out."""
    return np.linalg.eigvalsh(0.5 * (Y + np.conj(np.swapaxes(Y, 1, 2))))[:, 0]


def active_bands(frequencies: np.ndarray, Y: np.ndarray) -> list[tuple[float, float]]:
    """The bands of frequencies in which admittances (f, k, k) are not passive, each as its first and last."""
    inside = real_part(Y) < -_PASSIVE * np.abs(Y).max()
    return [(float(frequencies[a]), float(frequencies[b - 1])) for a, b in stretches(inside)]


def tip_port(point: OperatingPoint, axes: np.ndarray) -> TipPort:
    """The port of a flight's tip at a moment in contact, the surface taken away and its force held.

    Args:
        point: a moment at which the tip touches, at rest.
        axes: unit vectors, W, (k, 3).

    Raises:
        ConfigError: when the tip does not touch there.
    """
    held = _held(point)
    fine = dataclasses.replace(held, plant=dataclasses.replace(held.plant, substeps=1))
    A, B = plant_transition(fine)
    push = push_response(fine, axes)
    model = held.plant.model
    jacobian = np.zeros((3, model.nv))
    mujoco.mj_jacSite(model, held.data(), jacobian, None, model.site(TIP_SITE).id)
    place, speed = np.zeros((2, len(axes), len(A)))
    place[:, : model.nv] = speed[:, model.nv : 2 * model.nv] = np.asarray(axes) @ jacobian
    return TipPort(A, B, push, place, speed, loop_parts(held), held.plant.substeps, held.period)


def _held(point: OperatingPoint) -> OperatingPoint:
    """The same state without the surface, its force on the tip held."""
    data = point.data()
    body = int(point.plant.model.site_bodyid[point.plant.model.site(TIP_SITE).id])
    pushes = [
        np.concatenate([touch.force, np.cross(touch.point - data.xipos[body], touch.force)])
        for touch in touches(point.plant.model, data, point.plant.model.body(body).name)
    ]
    if not pushes:
        raise ConfigError("the tip does not touch at this point, so it has no force to hold")
    model = copy.copy(point.plant.model)
    model.geom_pos[model.geom(GEOM).id] += _AWAY * np.array(point.plant.surface.contact_axis)
    return dataclasses.replace(
        point, plant=dataclasses.replace(point.plant, model=model), held=(body, np.sum(pushes, axis=0))
    )
