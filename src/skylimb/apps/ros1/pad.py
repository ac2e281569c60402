"""Which buttons and axes of a radio mean what; by default as ROS's `joy_node` numbers a pad of two sticks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from skylimb.base.errors import ConfigError, unknown_name


@dataclass(frozen=True)
class Pad:
    """Numbers of buttons and axes, from 0.

    Attributes:
        land: button that lands.
        halt: button that stops the motors.
        yaw: axis of the heading; left is positive, as of all others.
        up: axis of the height.
        left: axis to the side.
        forward: axis ahead.
    """

    land: int = 0
    halt: int = 1
    yaw: int = 0
    up: int = 1
    left: int = 3
    forward: int = 4


def pad_of(values: Mapping[str, Any]) -> Pad:
    """A pad some of whose numbers are others.

    Raises:
        ConfigError: for an unknown name, what is no such number, or one button for two orders.
    """
    names = [field.name for field in fields(Pad)]
    for name, value in values.items():
        if name not in names:
            raise unknown_name("button or axis of a pad", name, names)
        if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value < 100:
            raise ConfigError(f"--pad {name}={value}: wanted is a number of a button or axis, 0 .. 99")
    pad = Pad(**values)
    axes = (pad.yaw, pad.up, pad.left, pad.forward)
    if pad.land == pad.halt or len({*axes}) < len(axes):
        raise ConfigError(f"--pad: one button or axis means two things ({pad})")
    return pad
