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
        touch: 1 while the tip is to touch, or to go on until it does, else 0.
        wait: 1 while the mission should not go on without touch, else 0.
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
    wait: Any
    sliding_axis: Array


def zero_reference(n_joints: int, n_vectoring: int) -> Reference:
    """A reference of zeros, which tells the sizes of all entries."""
    z3, q, psi = np.zeros(3), np.zeros(n_joints), np.zeros(n_vectoring)
    return Reference(z3, z3, z3, 0.0, 0.0, q, psi, z3, 0.0, 0.0, 0.0, z3, z3, z3, 0.0, 0.0, z3)


class Command(NamedTuple):
    """What the actuators are told: thrusts (N), joint angles q (rad), vectoring angles psi (rad)."""

    thrusts: Array
    joint_angles: Array
    vectoring_angles: Array


class ContactView(NamedTuple):
    """What a contact law tells the others.

    Attributes:
        engaged: 1 while the force is to be regulated, else 0.
        axis_position: of the tip along the contact axis while it is not, m.
        axis_velocity: its rate, m/s.
        anchor: of the centre of gravity along the contact axis while the force is regulated, m.
        surface_velocity: at which the surface is expected to come toward the pen's path, along the contact
            axis, m/s.
        normal_force: with which the surface is believed to push, N.
        speed: of the path, m/s.
        ease: share of the wanted force that is to be pressed with.
    """

    engaged: Any
    axis_position: Any
    axis_velocity: Any
    anchor: Any
    surface_velocity: Any
    normal_force: Any
    speed: Any
    ease: Any


def no_contact() -> ContactView:
    """A view of nothing."""
    return ContactView(*(0.0 for _ in ContactView._fields))._replace(ease=1.0)


class LawInput(NamedTuple):
    """What every law of the cascade may look at.

    Attributes:
        body: state of {C} and the model at the measured angles.
        reference: of this tick.
        wrench: tared external wrench.
        contact_force: f_hat, the filtered force along the contact axis, N, negative when pushed back.
        dt: control period, s.
        arm: from the centre of gravity to the tip in W, m, (3,).
        bias: wrench that the rotors have to make up in free flight, as a calibration knows it.
        contact: what the contact law tells.
        reach_rate: at which the arm was told to reach out at the last tick, m/s.
    """

    body: BodyState
    reference: Reference
    wrench: Wrench
    contact_force: Any
    dt: float
    arm: Array = None
    bias: Any = None
    contact: ContactView = no_contact()
    reach_rate: Any = 0.0


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


class ContactLaw(Protocol):
    """A module that judges the contact, and may set the mission's pace."""

    Gains: type
    PACED: bool

    @staticmethod
    def initial_state(gains: Any) -> Any:
        """The law's state before the first tick."""
        ...

    @staticmethod
    def step(gains: Any, state: Any, inputs: LawInput) -> tuple[Any, ContactView, dict[str, Any]]:
        """New state, what the other laws may know, and signals to record; "pace" is one if PACED."""
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
