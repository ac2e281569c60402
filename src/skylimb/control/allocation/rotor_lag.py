"""The lag of the rotors: known, and shortened by a lead.

A thrust follows its command with a first-order lag. With lambda the modelled thrust now,

    lambda_cmd = lambda + lead (lambda_wanted - lambda)

makes it follow `lead` times faster, at most as fast as it is there within a tick.
"""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

from skylimb.base.keys import Key, configuration
from skylimb.control.allocation.rotor_reaction import Reaction, motor_limits, reaction, reaction_torque
from skylimb.control.estimation.body_state import rotor_wrench
from skylimb.control.estimation.records import Wrench
from skylimb.control.records import Allocated, Command, LawInput
from skylimb.robots.model import Robot
from skylimb.symbolic import Array, clip, exp, low_pass, stack

NONE = 1e6
"""A bandwidth that lets every command pass, rad/s."""


@configuration
class RotorLag:
    """What is assumed about the lag, and whether it is shortened."""

    compensate: Annotated[
        bool, Key("", "whether the lag is shortened; without, thrusts are taken to follow at once")
    ] = False
    time_constant: Annotated[float, Key("s", "assumed time constant of the thrusts", low=1e-4, high=1.0)] = (
        0.05
    )
    lead: Annotated[
        float, Key("", "how many times faster than by themselves the thrusts follow", low=1.0, high=10.0)
    ] = 2.0
    bandwidth: Annotated[
        float,
        Key("rad/s", "low pass on the led command: no motor follows what is faster", above=0.0, high=NONE),
    ] = NONE
    reaction: Annotated[
        bool,
        Key("", "whether the torque of rotors that change their speed, and what their motors can, are known"),
    ] = False


class Rotors(NamedTuple):
    """What is known of the rotors between two ticks, N, (n,) each.

    Attributes:
        thrusts: as they are modelled.
        command: the last one.
    """

    thrusts: Array
    command: Array


class Led(NamedTuple):
    """Thrusts that are led, N, (n,).

    Attributes:
        command: within the limits.
        mean: modelled thrust over the tick to come.
        end: modelled thrust at the end of that tick.
    """

    command: Array
    mean: Array
    end: Array


def at_rest(thrusts: Array) -> Rotors:
    """Rotors that have followed a command for long, N, (n,)."""
    return Rotors(thrusts, thrusts)


def known_reaction(gains: Any, rotors: Rotors, inputs: LawInput) -> Reaction | None:
    """What to choose thrusts for besides their own wrench; None where nothing is known of it.

    Arguments are those of `allocated`.
    """
    if not gains.reaction:
        return None
    rate = (gains.lead if gains.compensate else 1.0) / time_constants(inputs.robot, gains.time_constant)
    return reaction(inputs.robot, inputs.estimate.body, rotors.thrusts, rate)


def allocated(
    gains: Any, rotors: Rotors, wanted: Array, inputs: LawInput, joint_angles: Array, vectoring_angles: Array
) -> tuple[Rotors, Allocated]:
    """The command that makes the rotors give wanted thrusts, and the wrench that comes of it.

    Args:
        gains: a `RotorLag`.
        rotors: of the last tick.
        wanted: within the limits, N, (n,).
        inputs: of this tick.
        joint_angles: commanded, rad.
        vectoring_angles: commanded, rad.

    Returns:
        The rotors at the end of the tick, and what the allocation law gives.
    """
    limits = inputs.robot.thrust_limits()
    if gains.reaction:
        limits = motor_limits(inputs.robot, rotors.thrusts, gains.time_constant)
    lags = time_constants(inputs.robot, gains.time_constant)
    led = lead_thrusts(gains, rotors, wanted, limits, lags, inputs.dt)
    command = Command(led.command, joint_angles, vectoring_angles)
    return Rotors(led.end, led.command), Allocated(command, made_wrench(gains, rotors, led, inputs))


def made_wrench(gains: Any, rotors: Rotors, led: Led, inputs: LawInput) -> Wrench:
    """What the rotors are known to do over the tick: force in W (N) and torque in C (N m).

    Args:
        gains: a `RotorLag`.
        rotors: of the last tick.
        led: over this one.
        inputs: of this tick.
    """
    robot, body = inputs.robot, inputs.estimate.body
    made = rotor_wrench(body, led.mean)
    if not gains.reaction:
        return made
    turned = reaction_torque(robot, body, rotors.thrusts, led.end, inputs.dt)
    return made._replace(torque=made.torque + turned)


def time_constants(robot: Robot, assumed: Any) -> Any:
    """Of each thrust, s: that of motors is assumed, that of a servo is known; one where all are motors.

    Args:
        robot: with the rotors.
        assumed: of a motor, s.
    """
    sides = [rotor.side for rotor in robot.description.rotors]
    if not any(sides):
        return assumed
    return stack(*(assumed if side is None else side.lag for side in sides))


def lead_thrusts(
    gains: Any, rotors: Rotors, wanted: Array, limits: tuple[Array, Array], time_constant: Any, dt: float
) -> Led:
    """The command that makes the rotors follow faster.

    Args:
        gains: a `RotorLag`.
        rotors: of the last tick.
        wanted: within the limits, N, (n,).
        limits: least and greatest thrust, N, (n,) each.
        time_constant: of the thrusts, s; one for all, or one for each.
        dt: control period, s.
    """
    if not gains.compensate:
        return Led(wanted, wanted, wanted)
    thrusts, decay = rotors.thrusts, exp(-dt / time_constant)
    # More would lead past the wanted thrust, and ring.
    lead = clip(gains.lead, 1.0, 1.0 / (1.0 - decay))
    command = low_pass(rotors.command, thrusts + lead * (wanted - thrusts), gains.bandwidth, dt)
    return lagging_thrusts(gains, thrusts, clip(command, limits[0], limits[1]), time_constant, dt)


def lagging_thrusts(gains: Any, thrusts: Array, command: Array, time_constant: Any, dt: float) -> Led:
    """How the modelled thrusts follow a command; at once where the lag is not compensated.

    Args:
        gains: a `RotorLag`.
        thrusts: modelled now, N, (n,).
        command: within the limits, N, (n,).
        time_constant: of the thrusts, s; one for all, or one for each.
        dt: control period, s.
    """
    if not gains.compensate:
        return Led(command, command, command)
    decay = exp(-dt / time_constant)
    away = thrusts - command
    mean = command + away * (time_constant / dt) * (1.0 - decay)
    return Led(command, mean, command + away * decay)
