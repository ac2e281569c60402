"""Rotational impedance that does not wait for the torque of a contact that is known to come.

A force at the pen turns the robot: 0.4 N across hydrus_xi_quad's tip give 0.3 N m about the vertical, which
its yaw stiffness answers with 9 mm at the pen. What the contact law expects across the contact axis, f, is
taken off at once, and of what is estimated beyond it, tau_hat, as much as one likes:

    tau = tau_cmd - s R^T (r x f) - b (tau_hat - R^T (r x f)),

with r from the centre of gravity to the tip, and s and b shares about each axis of C.
"""

from __future__ import annotations

from typing import Annotated, Any

from skylimb.control.attitude import impedance
from skylimb.control.attitude.impedance import Vector3
from skylimb.control.records import LawInput
from skylimb.estimation.records import Signals, Start
from skylimb.keys import Key, configuration
from skylimb.spatial import cross
from skylimb.symbolic import Array, vector


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


def initial_state(gains: Gains, start: Start) -> tuple[()]:
    """No memory."""
    return ()


def step(gains: Any, state: tuple[()], inputs: LawInput, R_target: Array) -> tuple[tuple[()], Array, Signals]:
    """tau_cmd, C, N m, (3,)."""
    state, torque, signals = impedance.step(gains, state, inputs, R_target)
    expected = inputs.estimate.body.R_WC.T @ cross(inputs.estimate.arm, inputs.contact.across)
    beyond = inputs.estimate.wrench.torque - expected
    off = vector(
        *(gains.contact_share[i] * expected[i] + gains.unexpected_share[i] * beyond[i] for i in range(3))
    )
    return state, torque - off, signals
