"""A random case for the board: what came, what is measured, and what our board makes of it."""

from __future__ import annotations

from typing import Any

import numpy as np

from skylimb.analysis.exchange.messages import (
    FourAxes,
    Gains,
    Motor,
    MotorInfo,
    PMatrix,
    TorqueInverse,
    UavInfo,
)
from skylimb.apps.ros.attitude_loop import attitude_loop
from skylimb.apps.ros.spinal import Spinal
from skylimb.base.rotations import quaternion_from_rotation, rotation_from_quaternion, rotation_from_rpy

ROTORS = 4
MOTORS = MotorInfo(0.58, 0.92, 1.0, 7.0, 0, (Motor(25.2, 33.0, (0.0, -5.342, 0.0976, 0.0, 0.0)),))
"""As `tools/lab_stack/board.cpp` describes them."""

UNLIMITED = (np.array(-np.inf), np.array(np.inf))


class BoardCase:
    """A random case.

    Args:
        rng: draws it.
        gimbal_dof: in how many directions the board turns each rotor.
    """

    def __init__(self, rng: np.random.Generator, gimbal_dof: int = 0) -> None:
        # The board has room for ten components.
        self.gimbal_dof, self.rotors = gimbal_dof, ROTORS - (gimbal_dof == 2)
        entries = self.rotors * (gimbal_dof + 1)
        shared = rng.random() < 0.25
        scale = rng.choice([300, 3000, 20000])
        self.gains = rng.integers(-scale, scale, (1 if shared else entries, 7))
        self.rows, self.inverse = rng.integers(-3000, 3000, (2, entries, 3))
        self.inertia = np.array([100, 1200, 1300, -120, 1, -10])
        self.desired = rng.uniform(-0.1, 0.1, 3)
        tilt = 1.2 if rng.random() < 0.05 else 0.2
        self.angles = np.array([*rng.uniform(-tilt, tilt, 2), rng.uniform(-4.0, 4.0)])
        self.base = rng.uniform(*((0.0, 34.0) if rng.random() < 0.3 else (8.0, 13.0)), entries)
        rpy = [*rng.uniform(-tilt, tilt, 2), rng.uniform(-3.0, 3.0)]
        self.turn = np.asarray(quaternion_from_rotation(np.asarray(rotation_from_rpy(*rpy))))
        self.rates, self.integral = rng.uniform(-0.3, 0.3, 3), rng.uniform(-0.05, 0.05, 2)

    def line(self) -> str:
        """For the compiled board."""
        parts = (self.gains, self.rows, self.inertia, self.inverse, self.desired, self.angles, self.base)
        numbers = np.concatenate([np.ravel(part) for part in (*parts, self.turn, self.rates, self.integral)])
        return " ".join(map(repr, [len(self.gains), *numbers.tolist()]))

    def ours(self) -> np.ndarray:
        """Thrusts of our board, N, angles of its gimbals, rad, and whether it lands by force."""
        board = (
            Spinal(self.rotors)
            .with_gimbals(self.gimbal_dof)
            .informed(UavInfo(self.rotors, 17))
            .informed(MOTORS)
            .configured(0)
        )
        board = board.gained(Gains(_rows(self.gains)))
        board = board.with_p_matrix(PMatrix(_rows(self.rows), tuple(self.inertia.tolist())))
        if len(self.gains) == 1:
            board = board.with_torque_inverse(TorqueInverse(_rows(self.inverse)))
        board = board.desired(*self.desired.tolist())._replace(integral=tuple(self.integral.tolist()))
        board = board.commanded(FourAxes(tuple(self.angles.tolist()), tuple(self.base.tolist())), 0.0)
        if board.heard is None:  # a command that is refused leaves the board without one
            board = board._replace(heard=0.0, base=np.zeros(board.entries))
        R = np.asarray(rotation_from_quaternion(self.turn))
        board, thrusts = attitude_loop(board, R, self.rates, 0.0, 0.001, UNLIMITED)
        return np.concatenate([thrusts, board.gimbals, [board.force_landing]])


def _rows(values: np.ndarray) -> tuple[tuple[Any, ...], ...]:
    return tuple(tuple(row) for row in values.tolist())
