"""Refuse robots that cannot fly: what only the whole model shows."""

from __future__ import annotations

import numpy as np

from skylimb.errors import AllocationError, DescriptionError
from skylimb.robots.description import Inertial
from skylimb.robots.model import Robot
from skylimb.robots.validation import check_inertial

_TRIES = 500
"""Sets of vectoring angles tried before a robot is said to be unable to hover."""


def check_robot(robot: Robot) -> None:
    """Check what only the whole model shows: moving bodies have mass, and the rotors can carry it all.

    Raises:
        DescriptionError: a moving body without mass.
        AllocationError: at the nominal posture the rotors cannot command a thrust and three torques, or
            cannot hover.
    """
    for body in robot.bodies:
        if body.mass <= 0.0:
            raise DescriptionError(
                f"the body of link '{body.name}' moves but has no mass; give it an <inertial>"
            )
        check_inertial(body.name, Inertial(body.mass, body.com, body.inertia))
    posture, start = robot.description.posture, robot.description.vectoring_start
    nominal = posture.offset + posture.slope * posture.theta_nominal
    # Golden-ratio steps spread the tries evenly and are the same every time; the first one is the start guess
    # itself.
    steps = np.outer(np.arange(_TRIES if robot.n_vectoring else 1), golden_steps(robot.n_vectoring))
    singular = 0
    for psi in start + 2.0 * np.pi * (steps % 1.0):
        try:
            thrusts = robot.at(nominal, psi).hover_thrusts
        except AllocationError:
            singular += 1
            continue
        if all(
            0.0 < thrust < rotor.thrust_max
            for rotor, thrust in zip(robot.description.rotors, thrusts, strict=True)
        ):
            return
    if singular == len(steps):
        raise AllocationError(
            f"the allocation matrix of '{robot.name}' is singular at its nominal posture, whatever the "
            "vectoring angles: "
            "its rotors cannot command a thrust and three torques; look at rotor frames and spins"
        )
    raise AllocationError(
        f"'{robot.name}' cannot hover at its nominal posture with thrusts between 0 and thrust_max and no "
        "torque at any of "
        f"{len(steps)} sets of vectoring angles tried; look at rotor frames, spins and masses"
    )


def golden_steps(n: int) -> np.ndarray:
    """Steps (n,) of a low-discrepancy sequence in n dimensions, in turns.

    They are powers of 1 / x for the root of x^(n + 1) = x + 1, which is the golden ratio for n = 1.
    """
    root = 2.0
    for _ in range(60):
        root = (1.0 + root) ** (1.0 / (n + 1))
    return root ** -np.arange(1, n + 1)
