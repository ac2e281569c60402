"""The zeros that rotors' reaction puts between commanded thrusts and the robot's lift and torque.

A rotor that gains thrust gains speed, and turns its body the other way: dT of thrust is dOmega = dT / (2 k
Omega) of speed, so that lift and torque of thrusts T(s) are

    w = (Q + s G) T,    G_i = -spin_i J_i / (2 k_i Omega_i) (0, z_i),

with the allocation matrix Q and z_i the rotor's axis. Where a tilted rotor's thrust turns the robot against
its own reaction, det(Q + s G) has a zero in the right half plane: whatever the controller, the torque first
goes the wrong way, and no loop across it can be faster than half the zero; flights want a fifth. No filter
removes it; other vectoring angles, spins or postures do.
"""

from __future__ import annotations

import math

import numpy as np

from skylimb.robots.model import Robot

DOUBTFUL_ZERO = 5.0
"""Times the attitude's bandwidth: a faster zero costs nothing; with one of 3.6 times a robot has fallen."""


def reaction_zeros(
    robot: Robot, joint_angles: np.ndarray, vectoring_angles: np.ndarray, inertia: float | None = None
) -> np.ndarray:
    """Zeros of lift and torque under least-norm thrusts around hover, (m,) complex, rad/s; the slowest first.

    Args:
        robot: any whose rotors have inertia and thrust factor; of the others no reaction is known.
        joint_angles: (nq,) rad.
        vectoring_angles: (nv,) rad.
        inertia: of each rotor, kg m^2; the description's when None.
    """
    state = robot.at(joint_angles, vectoring_angles)
    reaction = np.zeros_like(state.allocation_C)
    for index, rotor in enumerate(robot.description.rotors):
        J = rotor.inertia if inertia is None else inertia
        if not J or rotor.thrust_factor is None:
            continue
        # A servo that turns a rotor turns all of its angular momentum (`control.allocation.rotor_reaction`).
        halves, of = (2.0, index) if rotor.side is None else (1.0, rotor.side.of)
        speed = math.sqrt(max(state.hover_thrusts[of], rotor.thrust_min, _LEAST) / rotor.thrust_factor)
        gain = rotor.spin * J / (halves * rotor.thrust_factor * speed)
        reaction[3:, index] = -gain * state.allocation_C[:3, index]
    # det(I + s G Q^+) = 0: a zero is minus one over an eigenvalue.
    shares = np.linalg.eigvals(reaction[2:] @ np.linalg.pinv(state.allocation_C[2:]))
    zeros = -1.0 / shares[np.abs(shares) > 1.0 / _FASTEST]
    return zeros[np.argsort(np.abs(zeros))]


def slowest_unstable_zero(zeros: np.ndarray) -> float:
    """The least real part of the zeros in the right half plane, rad/s; infinite where there is none."""
    parts = np.real(zeros)
    return float(parts[parts > 0.0].min(initial=math.inf))


_LEAST = 0.1
"""Stands for the thrust of a rotor that hover leaves without, N."""

_FASTEST = 1e4
"""Zeros beyond this say nothing, rad/s."""
