"""Message types of ROS 2: its own, and `skylimb_msgs` for what has no standard type."""

from __future__ import annotations

from typing import Any

from skylimb.analysis.exchange.codec import message_of, plain_of
from skylimb.base.errors import extra_module

SKYLIMB_MSGS = {
    "RotorThrusts": "# Thrusts, N, in the order of the rotors. For a flight controller that holds attitude:\n"
    "# roll and pitch targets, rad, and a yaw term, N\nfloat64[3] attitude_terms\nfloat64[] thrusts\n",
    "MotorDuties": "# What motors are driven with, 0 .. 2000; 1000 stands\n"
    "builtin_interfaces/Time stamp\nuint16[] duties\n",
    "ControlledAxes": "# Axes that are controlled, seen from the flight controller, rad\n"
    "float64 roll\nfloat64 pitch\nfloat64 yaw\n",
    "Terms": "# What a law adds up along an axis, m/s^2 or rad/s^2, and what it adds it up of\n"
    "float32[] total\nfloat32[] p_term\nfloat32[] i_term\nfloat32[] d_term\n"
    "float32 target_p\nfloat32 err_p\nfloat32 target_d\nfloat32 err_d\n",
    "PoseTerms": "# Of the centre of gravity along the axes of world, and of roll, pitch and yaw\n"
    "std_msgs/Header header\nTerms x\nTerms y\nTerms z\nTerms roll\nTerms pitch\nTerms yaw\n",
    "Arming": "# What a flight controller is commanded, and acknowledges\n"
    "uint8 ON=0\nuint8 OFF=1\nuint8 FORCE_LANDING=2\nuint8 command\n",
}
"""Text of skylimb_msgs/msg/NAME.msg, by NAME; a package of these files is built in any ROS 2."""


class Ros2Types:
    """ROS 2's types; messages travel as CDR.

    Attributes:
        types: the type store.

    Raises:
        MissingExtraError: without the extra `ros2`.
    """

    def __init__(self) -> None:
        typesys = extra_module("rosbags.typesys")
        self.types: Any = typesys.get_typestore(typesys.Stores.ROS2_JAZZY)
        for name, text in SKYLIMB_MSGS.items():
            self.types.register(typesys.get_types_from_msg(text, f"skylimb_msgs/msg/{name}"))

    def knows(self, kind: str) -> bool:
        """Whether a type is defined."""
        return kind in self.types.fielddefs

    def described(self, kind: str) -> tuple[str, str, str]:
        """Name of a type; ROS 2 compares no digest."""
        return kind, "", ""

    def read(self, kind: str, data: bytes) -> Any:
        """The plain value of a message as it travels."""
        return plain_of(self.types.deserialize_cdr(data, kind))

    def write(self, kind: str, value: Any, seq: int) -> bytes:
        """A plain value as it travels."""
        return bytes(self.types.serialize_cdr(message_of(self.types, kind, value, seq), kind))
