"""Admittance of the tip along the contact axis, eq:admittance control in its right form.

    m_a (r'' - r_ref'') + c_a (r' - r_ref') + k_a (r - r_ref) = f_hat - f_ref,    f_hat < 0 when pushed back,

so that the arm draws back when pushed. As printed, the left side has the opposite sign and the arm would
reach into the surface (docs/errata.md).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

from skylimb.config import require_positive, require_range
from skylimb.control.records import ArmTarget, LawInput
from skylimb.estimation.records import Signals, Start
from skylimb.symbolic import Array, clip, where


@dataclass(frozen=True)
class Gains:
    """The virtual mass, damper and spring.

    Attributes:
        mass: m_a, kg.
        damping: c_a, N s/m.
        stiffness: k_a, N/m.
        force_reference: f_ref along the contact axis, N; negative asks for a push.
    """

    mass: float
    damping: float
    stiffness: float
    force_reference: float = 0.0

    def __post_init__(self) -> None:
        for name, unit in (("mass", "kg"), ("damping", "N s/m"), ("stiffness", "N/m")):
            require_positive("shape", name, getattr(self, name), unit)
        require_range("shape", "force_reference", self.force_reference, -20.0, 20.0, "N")


class State(NamedTuple):
    """Commanded reach (m) and its rate (m/s)."""

    reach: float | Array
    rate: float | Array


def initial_state(gains: Gains, start: Start) -> State:
    """At rest at the nominal reach."""
    return State(start.reach, 0.0)


def step(
    gains: Any, state: State, inputs: LawInput, reach_limits: tuple[float, float]
) -> tuple[State, ArmTarget, Signals]:
    """eq:difference method1 (right signs) and eq:difference method2: rate first, then reach.

    Outside of the adapting phases the force does not count, and the spring alone brings the arm back. At
    the end of its travel the arm stops, so that it leaves the limit as soon as the force turns.
    """
    dt = inputs.dt
    push = (inputs.estimate.contact_force - gains.force_reference) * inputs.reference.adapt
    acceleration = (
        push + gains.stiffness * (inputs.reference.reach - state.reach) - gains.damping * state.rate
    ) / gains.mass
    rate = state.rate + acceleration * dt
    free = state.reach + rate * dt
    reach = clip(free, reach_limits[0], reach_limits[1])
    rate = where(reach == free, rate, 0.0)
    return State(reach, rate), ArmTarget(reach, state.rate), {}
