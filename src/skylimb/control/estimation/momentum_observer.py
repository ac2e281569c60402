"""External wrench from momentum, eq:external wrench estimation, discretised exactly.

The observer is a first-order low pass of the true wrench, eq:external wrench estimation low-pass. Between two
ticks the commanded wrench is held, so with decay a = exp(-K dt) the recursion

    f[k] = a f[k-1] + (1 - a) ((h[k] - h[k-1]) / dt - u[k-1])

holds without a discretisation error: h is momentum (m p' in W, I omega in C) and u what is known to act
(rotor force less weight; rotor torque less omega x I omega). u must be built from the thrusts really
commanded, after saturation: with those before it, the estimate is off by the difference.
"""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

import numpy as np

from skylimb.base.keys import Key, Vector3, configuration
from skylimb.control.estimation.records import BodyState, Wrench
from skylimb.symbolic import Array, cross, low_pass


@configuration
class ObserverGains:
    """Gains of eq:external wrench estimation."""

    force: Annotated[Vector3, Key("1/s", "K_ti, of the force in W", above=0.0, high=1e4)] = (3.0, 3.0, 3.0)
    torque: Annotated[Vector3, Key("1/s", "K_ri, of the torque in C", above=0.0, high=1e4)] = (1.0, 1.0, 1.0)


_ZERO = np.zeros(3)


class ObserverState(NamedTuple):
    """Estimate and momentum of the last tick, and the known wrench that acts until the next.

    Without arguments it is the state before the first tick: no external wrench.

    Attributes:
        force: estimated external force, W, N.
        torque: estimated external torque, C, N m.
        linear_momentum: m p', W, kg m/s.
        angular_momentum: I omega, C, kg m^2/s.
        known_force: rotor force less weight, W, N.
        known_torque: rotor torque less omega x I omega, C, N m.
        started: 0 before the first tick, 1 after it.
    """

    force: Array = _ZERO
    torque: Array = _ZERO
    linear_momentum: Array = _ZERO
    angular_momentum: Array = _ZERO
    known_force: Array = _ZERO
    known_torque: Array = _ZERO
    started: float | Array = 0.0


def observe(gains: Any, state: ObserverState, body: BodyState, dt: float) -> tuple[ObserverState, Wrench]:
    """One step of eq:external wrench estimation.

    Args:
        gains: K_ti, K_ri, 1/s, as arrays (`packing.numeric`) or symbols.
        state: of the last tick, completed by `known_wrench`.
        body: state of {C} now.
        dt: time since the last tick, s.

    Returns:
        The new state (its known wrench still that of the last tick) and the estimated wrench.
    """
    linear = body.model.mass * body.velocity
    angular = body.model.inertia_C @ body.angular_velocity
    force_now = (linear - state.linear_momentum) * (1.0 / dt) - state.known_force
    torque_now = (angular - state.angular_momentum) * (1.0 / dt) - state.known_torque
    # There is no difference to take at the first tick.
    force = low_pass(state.force, force_now * state.started, gains.force, dt)
    torque = low_pass(state.torque, torque_now * state.started, gains.torque, dt)
    new = state._replace(
        force=force, torque=torque, linear_momentum=linear, angular_momentum=angular, started=1.0
    )
    return new, Wrench(force, torque)


def known_wrench(body: BodyState, rotors: Wrench) -> Wrench:
    """What is known to act: rotor force less weight (W, N), rotor torque less omega x I omega (C, N m).

    Args:
        body: state of {C} now.
        rotors: wrench of the saturated thrusts, force in W and torque in C.
    """
    gyroscopic = cross(body.angular_velocity, body.model.inertia_C @ body.angular_velocity)
    return Wrench(rotors.force - body.model.mass * body.model.gravity, rotors.torque - gyroscopic)
