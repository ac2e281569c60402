"""What a hover with least-norm thrusts leaves, for many postures at once: what holds here, holds.

For four rotors it is all that there is; for more, `robots.equilibrium` may find thrusts where this finds
none.
"""

from __future__ import annotations

import functools

import casadi as ca

from skylimb.control.planning.joint_torque import rest_function
from skylimb.robots.model import Robot
from skylimb.symbolic import right_inverse


@functools.lru_cache(maxsize=16)
def hover_margins_function(robot: Robot) -> ca.Function:
    """(q, psi) -> margins to each rotor's limits, N m, (2 n,); sine of the tilt, (2,); shares, (nq,).

    Joint angles are as commanded. Margins are the torque about any axis that a rotor still allows beside the
    lift, the tilt is that of the root link in two parts, shares are those of the servos' torque.
    """
    q, psi = ca.SX.sym("q", robot.n_joints), ca.SX.sym("psi", robot.n_vectoring)
    rest = rest_function(robot)(q, psi)
    state = robot.model(rest, psi)
    scale = right_inverse(state.allocation_C[2:, :])[:, 1:]
    swing = ca.sqrt(ca.sum2(scale * scale))
    least, most = robot.thrust_limits()
    margins = ca.vertcat((state.hover_thrusts - least) / swing, (most - state.hover_thrusts) / swing)
    servos = robot.description.shape_servos
    shares = servos.stiffness * (rest - q) / servos.torque_limit
    return ca.Function("hover", [q, psi], [margins, state.R_root_C[:2, 2], shares], {"cse": True})
