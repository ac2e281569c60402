"""What a law or a controller needs of the loop around it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from skylimb.base.errors import ConfigError

PACE = "pace"
"""Signal with which a controller sets the pace of the mission's clock at the next tick."""

TORQUE = "torque"
"""Purpose of the paper's vectoring angles."""


@dataclass(frozen=True)
class Needs:
    """What has to be there before the first tick.

    Attributes:
        paced: whether it sets the pace of the mission's clock, by a signal "pace": 1 is its own, 0 waits.
        preview: times ahead on the mission's own clock, s, at which it wants the reference, which is handed
            over as `reference.ahead`, in this order; each law of several sees its own.
        vectoring: purpose of the vectoring angles that the robot takes off with: "torque", "contact" or
            "online".
        force: normal force that it commands, N; refused before take-off where the robot cannot hold it.
        moves: how far it moves the vectoring angles from those of the posture, rad.
        imu: whether it works on what an IMU measures.
        slowest: pace of a mission that waits for its pen all the way; its flight has patience for that.
        supervised: whether its simulated flights are, where their experiment does not say.
        memory: control ticks by which a frame of the motion capture may be old for the law to learn of it.
    """

    paced: bool = False
    preview: tuple[float, ...] = ()
    vectoring: str = TORQUE
    force: float = 0.0
    moves: float = 0.0
    imu: bool = False
    slowest: float = 1.0
    supervised: bool = False
    memory: float = math.inf


def needs_of(controller: Any) -> Needs:
    """The needs that a controller declares as `needs`; none for one that declares nothing."""
    return declared_needs(getattr(controller, "needs", Needs()), "the controller's needs")


def declared_needs(needs: Any, what: str) -> Needs:
    """Needs as a user declares them; a `ConfigError` that begins with `what` where they are none."""
    if not isinstance(needs, Needs):
        raise ConfigError(f"{what}: got {type(needs).__name__}, expected skylimb.control.needs.Needs(...)")
    return needs


def require_imu(controller: Any, there: bool, where: str) -> None:
    """Raise a `ConfigError` where a controller works on an IMU and there is none; `where` says what to do."""
    if needs_of(controller).imu and not there:
        raise ConfigError(f"controller '{controller.name}' works on what an IMU measures: {where}")


def require_memory(controller: Any, latency: float, period: float) -> None:
    """Raise a `ConfigError` where every frame of the motion capture would be too old to correct anything.

    Args:
        controller: any.
        latency: age of a frame when it comes, s.
        period: of the control, s.
    """
    longest = needs_of(controller).memory * period
    if latency >= longest:
        raise ConfigError(
            f"sensors.latency = {latency:g} s: controller '{controller.name}' holds a frame against where "
            f"the robot was then, which it remembers for {longest:g} s at {1.0 / period:g} Hz; a lower "
            "controller_rate remembers longer"
        )


def merged(needs: Iterable[Needs]) -> Needs:
    """The needs of several laws together.

    Raises:
        ConfigError: when two laws want different vectoring angles.
    """
    needs = list(needs)
    purposes = {need.vectoring for need in needs if need.vectoring != TORQUE}
    if len(purposes) > 1:
        raise ConfigError(f"two laws want different vectoring angles: {' and '.join(sorted(purposes))}")
    return Needs(
        any(need.paced for need in needs),
        tuple(sorted({time for need in needs for time in need.preview})),
        next(iter(purposes), TORQUE),
        max((need.force for need in needs), default=0.0),
        max((need.moves for need in needs), default=0.0),
        any(need.imu for need in needs),
        min((need.slowest for need in needs), default=1.0),
        any(need.supervised for need in needs),
        min((need.memory for need in needs), default=math.inf),
    )
