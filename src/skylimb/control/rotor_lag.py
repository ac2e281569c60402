"""The lag of the rotors: known, and shortened by a lead.

A thrust follows its command with a first-order lag. With lambda the modelled thrust now,

    lambda_cmd = lambda + lead (lambda_wanted - lambda)

makes it follow `lead` times faster, at most as fast as it is there within a tick.
"""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

from skylimb.base.keys import Key, configuration
from skylimb.control.records import Allocated, Command, LawInput
from skylimb.control.thrusts import rotor_wrench, thrust_limits
from skylimb.symbolic import Array, clip, exp


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


def allocated(
    gains: Any, thrusts: Array, wanted: Array, inputs: LawInput, joint_angles: Array, vectoring_angles: Array
) -> tuple[Array, Allocated]:
    """The command that makes the rotors give wanted thrusts, and the wrench that comes of it.

    Args:
        gains: a `RotorLag`.
        thrusts: modelled now, N, (n,).
        wanted: within the limits, N, (n,).
        inputs: of this tick.
        joint_angles: commanded, rad.
        vectoring_angles: commanded, rad.

    Returns:
        The modelled thrusts at the end of the tick, N, (n,), and what the allocation law gives.
    """
    led = lead_thrusts(gains, thrusts, wanted, thrust_limits(inputs.robot), inputs.dt)
    command = Command(led.command, joint_angles, vectoring_angles)
    return led.end, Allocated(command, rotor_wrench(inputs.estimate.body, led.mean))


def lead_thrusts(gains: Any, thrusts: Array, wanted: Array, limits: tuple[Array, Array], dt: float) -> Led:
    """The command that makes the rotors follow faster.

    Args:
        gains: a `RotorLag`.
        thrusts: modelled now, N, (n,).
        wanted: within the limits, N, (n,).
        limits: least and greatest thrust, N, (n,) each.
        dt: control period, s.
    """
    if not gains.compensate:
        return Led(wanted, wanted, wanted)
    decay = exp(-dt / gains.time_constant)
    # More would lead past the wanted thrust, and ring.
    lead = clip(gains.lead, 1.0, 1.0 / (1.0 - decay))
    command = clip(thrusts + lead * (wanted - thrusts), limits[0], limits[1])
    return lagging_thrusts(gains, thrusts, command, dt)


def lagging_thrusts(gains: Any, thrusts: Array, command: Array, dt: float) -> Led:
    """How the modelled thrusts follow a command; at once where the lag is not compensated.

    Arguments are those of `lead_thrusts`; `command` is within the limits, N, (n,).
    """
    if not gains.compensate:
        return Led(command, command, command)
    decay = exp(-dt / gains.time_constant)
    away = thrusts - command
    mean = command + away * (gains.time_constant / dt) * (1.0 - decay)
    return Led(command, mean, command + away * decay)
