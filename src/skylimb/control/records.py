"""The records that laws and controllers exchange."""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

from skylimb.estimation.records import BodyState, Wrench
from skylimb.missions.reference import Reference
from skylimb.symbolic import Array


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
