"""Friction on a pen that slides while nobody sees it.

Coulomb friction goes with the way of the tip, not with that of its path: a tip that drifts across its path is
held back by F v_drift / v_path, as by a damper. A prediction without that goes astray twice as far. Here

    f = -mu n v / (|v|^2 + v_0^2)^(1/2),

with v the tip's velocity, n what the contact pushes back with along the contact axis, and mu usual: half or
twice of it predicts nearly as well, as a wrench that is felt with it has the rest.
"""

from __future__ import annotations

from skylimb.control.estimation.body_state import BodyState
from skylimb.symbolic import Array, clip, cross, dot, stack

FRICTION, MOST = 0.3, 10.0
"""mu, and the greatest n that it counts with, N."""

STILL, LIGHT = 0.01, 0.1
"""Speed below which friction fades, m/s, and the least mass with which a tip answers, kg: friction that turns
the tip round within a tick would shake it."""


def slip_wrench(body: BodyState, speeds: Array, joints: int, push: Array, axis: Array, dt: float) -> Array:
    """Friction on the tip, W, N, and its torque about the centre of gravity, C, N m, (6,).

    Args:
        body: state of {C}.
        speeds: of joint and vectoring angles, rad/s.
        joints: how many of them are the shape's.
        push: force on the robot from outside, W, N, (3,).
        axis: into the surface, W, (3,); 0 where nothing is to touch.
        dt: control period, s.
    """
    model = body.model
    moving = body.R_WC.T @ body.velocity + cross(body.angular_velocity, model.tip_C)
    if joints:
        bent = model.tip_jacobian @ speeds[:joints] - model.cog_jacobian @ speeds
        moving = moving + model.R_root_C.T @ bent
    most = FRICTION * clip(-dot(axis, push), 0.0, MOST)
    slow = STILL + most * dt / LIGHT
    force = -most / (dot(moving, moving) + slow * slow) ** 0.5 * moving
    return stack(body.R_WC @ force, cross(model.tip_C, force))
