"""The records that laws and controllers exchange.

A law fills in the fields that it knows; the others are absent, None (`control.laws.fields`).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from skylimb.control.estimation.records import ABSENT, Estimate, Measurement, Start, Wrench
from skylimb.control.missions.reference import Reference
from skylimb.robots.model import Robot
from skylimb.symbolic import Array

NOTHING = Wrench(np.zeros(3), np.zeros(3))
"""No wrench."""


class Command(NamedTuple):
    """What the actuators are to do: thrusts (N), joint angles q (rad), vectoring angles psi (rad)."""

    thrusts: Array
    joint_angles: Array
    vectoring_angles: Array


class TipMove(NamedTuple):
    """How far the tip's target is from its reference, as a contact law wants it.

    Attributes:
        position: W, m, (3,).
        velocity: W, m/s, (3,).
        rotation: of the tool from its nominal attitude, a vector along its axis, W, rad, (3,).
        rotation_rate: of the target, that of the task's own axes included, W, rad/s, (3,).
    """

    position: Array
    velocity: Array
    rotation: Array
    rotation_rate: Array


class ContactView(NamedTuple):
    """What a contact law knows.

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
        across: force that surface and friction are expected to push with across the contact axis, W, N, (3,).
        tip: how far the tip's target is from its reference.
        landing: 1 from a touch on until the path goes on, then down to 0.
        own_speed: of the path at the mission's own pace, m/s, where it is not slowed down.
        ramp: share of its force that the law commands now: less while a press comes or goes.
        reason: why it is pressed so (`control.press`).
        gone: from 0 to 1, how sure it is that the surface has gone from under the tip.
    """

    engaged: Any = ABSENT
    axis_position: Any = ABSENT
    axis_velocity: Any = ABSENT
    anchor: Any = ABSENT
    surface_velocity: Any = ABSENT
    normal_force: Any = ABSENT
    speed: Any = ABSENT
    ease: Any = ABSENT
    across: Array = ABSENT
    tip: TipMove = ABSENT
    landing: Any = ABSENT
    own_speed: Any = ABSENT
    ramp: Any = ABSENT
    reason: Any = ABSENT
    gone: Any = ABSENT


class ArmTarget(NamedTuple):
    """What a shape law wants of the arm.

    Attributes:
        reach: from now on, m.
        rate: at which the reach was commanded to change until now, m/s.
    """

    reach: Any
    rate: Any = ABSENT


class LawInput(NamedTuple):
    """What every law after the estimation may look at.

    Attributes:
        robot: the controller's model of the robot.
        measurement: of this tick.
        reference: of this tick.
        dt: control period, s.
        estimate: of the estimation law.
        contact: of the contact law; absent for the contact law itself.
        arm: of the shape law; absent for the laws before it.
        residual: what the rotors fell short of at the last tick, wanted less given wrench, W and C; absent
            where the allocation law does not say.
        force: normal force that is wanted in touch, N: the path's, else the translation law's own.
    """

    robot: Robot
    measurement: Measurement
    reference: Reference
    dt: float
    estimate: Estimate
    contact: ContactView = ContactView()
    arm: ArmTarget = ArmTarget(ABSENT)
    residual: Wrench = ABSENT
    force: Any = 1.0


class Demand(NamedTuple):
    """What the rotors have to give.

    Attributes:
        force: wanted force with the bias of free flight made up for, W, N, (3,).
        aimed: the part of it that the attitude target was made for, W, N, (3,).
        torque: wanted torque with the bias made up for, C, N m, (3,).
        joint_angles: of the commanded posture, rad.
        vectoring_angles: nominal ones of that posture, rad.
    """

    force: Array
    aimed: Array
    torque: Array
    joint_angles: Array
    vectoring_angles: Array


class Allocated(NamedTuple):
    """What an allocation law makes of a demand.

    Attributes:
        command: to the actuators.
        wrench: that the rotors make until the next tick, as far as the law knows, W and C.
    """

    command: Command
    wrench: Wrench


def no_memory(gains: Any, start: Start) -> tuple[()]:
    """The `initial_state` of a law that remembers nothing between two ticks."""
    return ()
