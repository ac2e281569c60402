"""The records that laws and controllers exchange."""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

import numpy as np

from skylimb.estimation.records import BodyState, Wrench
from skylimb.symbolic import Array


class Reference(NamedTuple):
    """What the robot should do at a tick.

    Attributes:
        position: of the centre of gravity in W, m, (3,).
        velocity: m/s, zero when positions alone are sent.
        acceleration: m/s^2, zero when positions alone are sent.
        heading: of the tip link about W's z in the nominal posture, rad.
        reach: tip to centre of gravity along the tip link, m (r_ref of eq:admittance control).
        joint_angles: nominal posture q, rad; the shape law's change of reach comes on top of it.
        vectoring_angles: nominal psi of that posture, rad.
        contact_axis: unit vector in W pointing from the robot into the surface, (3,).
        tare: 1 while the observer's bias is averaged, else 0.
        align: 1 to turn the whole robot so that the tip link keeps its heading though the joints give way,
            else 0.
        adapt: 1 while the shape law may answer to force, else 0.
        tip_position: of the tip on its path over the nominal surface, in W, m, (3,): before the approach it
            stands off, afterwards it lies on the nominal surface, wherever the real one is.
        tip_velocity: its rate, m/s, whether or not velocities are sent.
        tip_acceleration: m/s^2.
        touch: 1 while the tip is to touch, else 0.
        sliding_axis: unit vector u of the sliding plane in W, (3,); the other one is contact_axis x u.
    """

    position: Array
    velocity: Array
    acceleration: Array
    heading: Any
    reach: Any
    joint_angles: Array
    vectoring_angles: Array
    contact_axis: Array
    tare: Any
    align: Any
    adapt: Any
    tip_position: Array
    tip_velocity: Array
    tip_acceleration: Array
    touch: Any
    sliding_axis: Array


def zero_reference(n_joints: int, n_vectoring: int) -> Reference:
    """A reference of zeros, which tells the sizes of all entries."""
    z3, q, psi = np.zeros(3), np.zeros(n_joints), np.zeros(n_vectoring)
    return Reference(z3, z3, z3, 0.0, 0.0, q, psi, z3, 0.0, 0.0, 0.0, z3, z3, z3, 0.0, z3)


class Command(NamedTuple):
    """What the actuators are told: thrusts (N), joint angles q (rad), vectoring angles psi (rad)."""

    thrusts: Array
    joint_angles: Array
    vectoring_angles: Array


class LawInput(NamedTuple):
    """What every law of the cascade may look at.

    Attributes:
        body: state of {C} and the model at the measured angles.
        reference: of this tick.
        wrench: tared external wrench.
        contact_force: f_hat, the filtered force along the contact axis, N, negative when pushed back.
        dt: control period, s.
    """

    body: BodyState
    reference: Reference
    wrench: Wrench
    contact_force: Any
    dt: float


class TranslationLaw(Protocol):
    """A module that turns position error and external force into a wanted force f_cmd in W, N."""

    Gains: type

    @staticmethod
    def initial_state(gains: Any) -> Any:
        """The law's state before the first tick, a record of arrays (or an empty tuple)."""
        ...

    @staticmethod
    def step(gains: Any, state: Any, inputs: LawInput) -> tuple[Any, Array]:
        """New state and f_cmd, (3,)."""
        ...


class AttitudeLaw(Protocol):
    """A module that turns attitude error and external torque into a wanted torque tau_cmd in C, N m."""

    Gains: type

    @staticmethod
    def initial_state(gains: Any) -> Any:
        """The law's state before the first tick."""
        ...

    @staticmethod
    def step(gains: Any, state: Any, inputs: LawInput, R_target: Array) -> tuple[Any, Array]:
        """New state and tau_cmd, (3,)."""
        ...


class ShapeLaw(Protocol):
    """A module that turns the contact force into a reach, m."""

    Gains: type

    @staticmethod
    def initial_state(gains: Any, reach: float) -> Any:
        """The law's state before the first tick, at the nominal reach."""
        ...

    @staticmethod
    def step(gains: Any, state: Any, inputs: LawInput, reach_limits: tuple[float, float]) -> tuple[Any, Any]:
        """New state and the commanded reach, m, within the limits."""
        ...
