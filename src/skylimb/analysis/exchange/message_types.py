"""Message classes: ROS 1's own, and the few of the lab's that a log is written with.

The lab's definitions have changed more than once, and with them their digests. A bag brings the definitions
of its own messages, and is read with those.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from skylimb.base.errors import missing_extra

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

IMU, FOUR_AXES = "spinal/msg/Imu", "spinal/msg/FourAxisCommand"

DEFINITIONS = {
    IMU: "time stamp\nfloat32[3] acc\nfloat32[3] gyro\nfloat32[3] mag\nfloat32[4] quaternion\n",
    FOUR_AXES: "float32[3] angles\nfloat32[] base_thrust\n",
}
"""As of February 2026; whoever has others passes theirs."""


def message_types(definitions: dict[str, str] | None = None) -> Typestore:
    """ROS 1's message classes, and those of some definitions, by default the lab's.

    Raises:
        MissingExtraError: without the extra `logs`.
    """
    try:
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore
    except ImportError:
        raise missing_extra("rosbags", "logs") from None
    store = get_typestore(Stores.ROS1_NOETIC)
    known: dict[str, Any] = {}
    for name, text in (DEFINITIONS if definitions is None else definitions).items():
        known.update(get_types_from_msg(text, name))
    store.register({name: fields for name, fields in known.items() if name not in store.fielddefs})
    return store
