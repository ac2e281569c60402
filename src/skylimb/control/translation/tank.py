"""A press whose force integral lives on a tank of energy.

The integral is what could pump energy into a bouncing contact. What the damper along the contact axis
dissipates fills the tank, the integral's work empties it, and an empty tank lets the integral fade.

At the end of a stroke what the integral has come to is carried to the next one, so that a short stroke is
pressed right. It comes with the last third of the press: a light one that it made lighter lost the surface.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from skylimb.control.estimation.records import Signals
from skylimb.control.press import PLAIN, SATURATED, UNLOADING, WAITING
from skylimb.control.records import NOTHING, LawInput
from skylimb.control.windup import unless_short
from skylimb.symbolic import clip, dot, where

TANK_LOW = 0.25
"""Share of the tank below which the integral fades, and counts as limited."""

SHORT = 0.05
"""Force along the axis by which the rotors fell short from which the press counts as limited, N."""


class Pressed(NamedTuple):
    """What a press remembers.

    Attributes:
        integral: of the force error since the touch, N.
        tank: energy in the tank, J.
        carried: what the integral came to in the strokes before, N.
    """

    integral: Any
    tank: Any
    carried: Any


def gone(inputs: LawInput) -> Any:
    """How sure it is that the surface has gone, 0 to 1."""
    return 0.0 if inputs.contact.gone is None else inputs.contact.gone


def regulated(
    gains: Any, state: Any, inputs: LawInput, relative: Any, damper: Any
) -> tuple[Any, Pressed, Signals]:
    """Force along the axis besides the anchor's spring, N, what is remembered, and signals of it.

    `relative` is the speed toward the surface, m/s, and `damper` what holds it back, N.
    """
    contact, dt, before = inputs.contact, inputs.dt, state.press
    engaged, away = contact.engaged, gone(inputs)
    ramp = 1.0 if contact.ramp is None else contact.ramp
    reason = PLAIN if contact.reason is None else contact.reason
    unloads = where(reason == UNLOADING, 1.0, 0.0)
    commanded = inputs.force
    wanted = commanded * contact.ease * (1.0 - away)
    missing = wanted - contact.normal_force
    alive = clip(before.tank / (TANK_LOW * gains.tank), 0.0, 1.0)
    axis_residual = dot(inputs.reference.contact_axis, (inputs.residual or NOTHING).force)
    grown = unless_short(gains.force_integral * missing * dt, axis_residual)
    limit = gains.force_integral_limit
    integral = clip(
        before.integral + grown * (1.0 - unloads), -limit - before.carried, limit - before.carried
    )
    borne = integral + before.carried * clip(3.0 * ramp - 2.0, 0.0, 1.0)
    power = borne * relative
    # The work that the integral takes back always fills the tank; what it spends needs energy in it.
    used = borne * where(power > 0.0, alive, 1.0)
    tank = clip(before.tank + (damper * relative - used * relative) * dt, 0.0, gains.tank)
    estimated = dot(inputs.reference.contact_axis, inputs.estimate.wrench.force)
    inertia = (1.0 / gains.press_mass_ratio - 1.0) * (estimated + wanted)
    limited = where(abs(integral + before.carried) >= limit, 1.0, 0.0)
    limited = where(tank < TANK_LOW * gains.tank, 1.0, where(abs(axis_residual) > SHORT, 1.0, limited))
    signals = {
        "contact_force_reference": commanded * inputs.reference.touch * ramp,
        "contact_force_target": wanted * engaged,
        "contact_force_integral": used * engaged,
        "press_reason": where(limited * where(reason > WAITING, 0.0, 1.0) * engaged > 0.5, SATURATED, reason),
    }
    after = Pressed(
        integral * engaged * (1.0 - unloads),
        where(engaged > 0.5, tank, gains.tank),
        before.carried + integral * engaged * unloads,
    )
    return wanted + used + inertia - damper, after, signals
