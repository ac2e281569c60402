"""Which buttons and axes of a radio mean what; by default as ROS's `joy_node` numbers a pad of two sticks."""

from __future__ import annotations

from typing import Annotated

from skylimb.base.keys import Key, configuration, refused


@configuration
class Pad:
    """Numbers of buttons and axes, from 0; left, up and ahead are positive."""

    land: Annotated[int, Key("", "button that lands", low=0, high=99)] = 0
    halt: Annotated[int, Key("", "button that stops the motors", low=0, high=99)] = 1
    yaw: Annotated[int, Key("", "axis of the heading", low=0, high=99)] = 0
    up: Annotated[int, Key("", "axis of the height", low=0, high=99)] = 1
    left: Annotated[int, Key("", "axis to the side", low=0, high=99)] = 3
    forward: Annotated[int, Key("", "axis ahead", low=0, high=99)] = 4

    def check(self) -> None:
        """Refuse a button or an axis that means two things."""
        if self.land == self.halt:
            raise refused(self, "halt", "is that of land")
        if len({self.yaw, self.up, self.left, self.forward}) < 4:
            raise refused(self, "forward", "or another axis means two things")
