"""How much of a force on the tip reaches the centre of gravity while the attitude is held."""

from __future__ import annotations

import numpy as np

from skylimb.base.rotations import hat, rot_z
from skylimb.robots.posed import RobotState
from skylimb.symbolic import Array, right_inverse


def tip_force_map(state: RobotState) -> Array:
    """Force at the centre of gravity for each newton at the tip, attitude and lift held: X, (3, 3), no unit.

    A force f on the tip at r turns the robot with the torque r x f. The controller holds the attitude and the
    lift, so the rotors answer with thrusts d_lambda for which

        [Q_tz; Q_r] d_lambda = -[0; S(r) f],

    with Q_tz the z row of the force rows and Q_r the torque rows of the allocation matrix. Tilted rotors push
    sideways with those thrusts, and the centre of gravity feels f + Q_t d_lambda = X f:

        X = E - Q_t [Q_tz; Q_r]^-1 [0; S(r)].

    An ideal robot has X = E. X[0, 1] and X[0, 2] are what friction across the surface adds to the pressing
    force, X[1, 1] < 0 means that a robot pushed to one side drifts to the other. The third row is (0, 0, 1)
    always. The cascade's own allocation, which takes the least-norm thrusts for the torque and scales the
    hover thrusts for the lift, gives the same X: the two differ by hover thrusts, which have no sideways
    force in {C}. More than four rotors leave a choice; it is the least-norm one here.

    Args:
        state: the model at some joint and vectoring angles, in numbers or in CasADi symbols.

    Returns:
        (3, 3) in the tip's heading frame, which is {C} turned about its z axis until x is along the heading.
    """
    Q = state.allocation_C
    S = hat(state.tip_C)
    held = right_inverse(Q[2:, :])
    X = np.eye(3) - Q[:3, :] @ (held[:, 1:] @ S)
    to_heading = rot_z(state.tip_heading)
    return to_heading.T @ X @ to_heading
