"""Rotational impedance that does not wait for the torque of a contact that is known to come.

A force at the pen turns the robot: 0.4 N across hydrus_xi_quad's tip give 0.3 N m about the vertical, which
its yaw stiffness answers with 9 mm at the pen. What the contact law expects across the contact axis, f, is
taken off at once, and of what is estimated beyond it, tau_hat, as much as one likes:

    tau = tau_cmd - s R^T (r x f) - b (tau_hat - R^T (r x f)),

with r from the centre of gravity to the tip, and s and b shares about each axis of C.
"""

from __future__ import annotations

from typing import Annotated, Any

from skylimb.base.keys import Key, Vector3, configuration
from skylimb.base.rotations import rotation_error
from skylimb.base.signal_table import TURN_TERMS
from skylimb.control.attitude.laws import impedance
from skylimb.control.estimation.records import Signals
from skylimb.control.records import LawInput, no_memory
from skylimb.control.terms import turn_terms
from skylimb.symbolic import Array, clip, cross, vector

REQUIRES = (
    *impedance.REQUIRES,
    *("estimate.arm", "contact.engaged", "contact.across", "contact.landing", "contact.own_speed"),
)


@configuration
class Gains(impedance.Gains):
    """The impedance about the axes of C, and how much of the expected torque is taken off.

    About an axis whose virtual inertia is above the true one the impedance feeds back the estimated torque as
    well: together they take it off twice.
    """

    contact_share: Annotated[
        Vector3, Key("", "s, share of the contact's expected torque that is taken off", low=0.0, high=1.0)
    ] = (0.0, 0.0, 1.0)
    unexpected_share: Annotated[
        Vector3,
        Key(
            "",
            "b, share of the estimated torque beyond the expected one that is taken off",
            low=0.0,
            high=1.0,
        ),
    ] = (0.0, 0.0, 0.0)
    landing_share: Annotated[
        Vector3, Key("", "b from a touch on until the path goes on", low=0.0, high=0.95)
    ] = (0.0, 0.0, 0.0)
    slow_stiffness: Annotated[
        Vector3,
        Key("", "times by which the axes are stiffer where the path rests in touch", low=0.01, high=100.0),
    ] = (1.0, 1.0, 1.0)
    slow_damping: Annotated[
        Vector3, Key("", "times by which they are damped more there", low=0.01, high=100.0)
    ] = (1.0, 1.0, 1.0)
    slow_speed: Annotated[
        float,
        Key(
            "m/s",
            "speed of the path from which they are as `normalized_stiffness` and `damping_ratio` say",
            above=0.0,
            high=10.0,
        ),
    ] = 0.05


initial_state = no_memory


def step(gains: Any, state: tuple[()], inputs: LawInput, R_target: Array) -> tuple[tuple[()], Array, Signals]:
    """tau_cmd, C, N m, (3,)."""
    state, torque, signals = impedance.step(gains, state, inputs, R_target)
    expected = inputs.estimate.body.R_WC.T @ cross(inputs.estimate.arm, inputs.contact.across)
    beyond = inputs.estimate.wrench.torque - expected
    share = [
        gains.unexpected_share[i]
        + inputs.contact.landing * (gains.landing_share[i] - gains.unexpected_share[i])
        for i in range(3)
    ]
    off = vector(*(gains.contact_share[i] * expected[i] + share[i] * beyond[i] for i in range(3)))
    spring, damper, rests = _firmer(gains, inputs, R_target)
    firmer = inputs.estimate.body.model.inertia_C @ ((spring + damper) * rests)
    proportional, _, derivative = (signals[name] for name in TURN_TERMS)
    own = turn_terms(proportional - spring * rests, derivative - damper * rests)
    return state, torque - off - firmer, {**signals, **own}


def _firmer(gains: Any, inputs: LawInput, R_target: Array) -> tuple[Array, Array, Any]:
    """What a path that rests adds to spring and damper, C, rad/s^2, (3,) each, and how much it rests."""
    body, contact = inputs.estimate.body, inputs.contact
    rests = contact.engaged * (1.0 - clip(contact.own_speed / gains.slow_speed, 0.0, 1.0))
    damping = 2.0 * gains.damping_ratio * gains.normalized_stiffness**0.5
    spring = gains.normalized_stiffness * rotation_error(body.R_WC, R_target)
    damper = damping * body.angular_velocity
    stiffer, damped = gains.slow_stiffness, gains.slow_damping
    return (
        vector(*((stiffer[i] - 1.0) * spring[i] for i in range(3))),
        vector(*((damped[i] - 1.0) * damper[i] for i in range(3))),
        rests,
    )
