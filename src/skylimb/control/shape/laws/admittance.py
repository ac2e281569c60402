"""Admittance of the tip along the contact axis, eq:admittance control in its right form.

    m_a (r'' - r_ref'') + c_a (r' - r_ref') + k_a (r - r_ref) = f_hat - f_ref,    f_hat < 0 when pushed back,

so that the arm draws back when pushed. As printed, the left side has the opposite sign and the arm would
reach into the surface (docs/errata.md).
"""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

from skylimb.base.keys import Key, configuration
from skylimb.control.estimation.records import Signals, Start
from skylimb.control.records import ArmTarget, LawInput
from skylimb.symbolic import Array, clip, where

PROVIDES = ("arm.reach", "arm.rate")
REQUIRES = ("estimate.contact_force",)


@configuration
class Gains:
    """The virtual mass, damper and spring."""

    mass: Annotated[float, Key("kg", "virtual mass m_a", above=0.0, high=1e5)]
    damping: Annotated[float, Key("N s/m", "virtual damper c_a", above=0.0, high=1e6)]
    stiffness: Annotated[float, Key("N/m", "virtual spring k_a", above=0.0, high=1e6)]
    force_reference: Annotated[
        float,
        Key("N", "wanted force f_ref along the contact axis; negative for a push", low=-20.0, high=20.0),
    ] = 0.0


class State(NamedTuple):
    """Commanded reach (m) and its rate (m/s)."""

    reach: float | Array
    rate: float | Array


def initial_state(gains: object, start: Start) -> State:
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
