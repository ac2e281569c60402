"""Message types: ROS 1's own, and the few of the lab's that a log is written with.

The lab's definitions have changed more than once, and with them their digests. A bag brings the definitions
of its own messages, and is read with those. A node on ROS takes those of the robot's own checkout.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from skylimb.analysis.exchange.codec import message_of, plain_of
from skylimb.base.errors import ConfigError, extra_module
from skylimb.base.sources import read_source

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

IMU, FOUR_AXES = "spinal/msg/Imu", "spinal/msg/FourAxisCommand"

TF = {"tf2_msgs/msg/TFMessage": "geometry_msgs/TransformStamped[] transforms\n"}
"""Of ROS 1, though rosbags lacks it."""

DEFINITIONS = {
    IMU: "time stamp\nfloat32[3] acc\nfloat32[3] gyro\nfloat32[3] mag\nfloat32[4] quaternion\n",
    FOUR_AXES: "float32[3] angles\nfloat32[] base_thrust\n",
}
"""As of February 2026; whoever has others passes theirs."""


def message_types(definitions: dict[str, str] | None = None) -> Typestore:
    """ROS 1's message types, and those of some definitions, by default the lab's.

    Raises:
        MissingExtraError: without the extra `logs`.
    """
    typesys = extra_module("rosbags.typesys")
    store = typesys.get_typestore(typesys.Stores.ROS1_NOETIC)
    for name, text in {**TF, **(DEFINITIONS if definitions is None else definitions)}.items():
        new = typesys.get_types_from_msg(text, name)
        store.register({kind: fields for kind, fields in new.items() if kind not in store.fielddefs})
    return store


class Types(Protocol):
    """Types of messages, and how these travel."""

    def knows(self, kind: str) -> bool:
        """Whether a type is defined, for example "sensor_msgs/msg/Imu"."""
        ...

    def described(self, kind: str) -> tuple[str, str, str]:
        """Name, digest and text of a known type, as the middleware has them."""
        ...

    def read(self, kind: str, data: bytes) -> Any:
        """The plain value of a message as it travels."""
        ...

    def write(self, kind: str, value: Any, seq: int) -> bytes:
        """A plain value as it travels, its header numbered."""
        ...


class Definitions:
    """The types of ROS 1, and those of .msg files; a file is read when its type is asked for.

    Args:
        folders: of .msg files as PACKAGE/msg/NAME.msg at any depth, for example a checkout of the lab's.
            Folders of a ROS workspace that was sourced come after them.

    Attributes:
        types: known so far.

    Raises:
        ConfigError: for a folder that does not exist.
    """

    def __init__(self, folders: Sequence[str | Path] = ()) -> None:
        for folder in folders:
            if not Path(folder).is_dir():
                raise ConfigError(f"folder of messages '{folder}' does not exist")
        workspaces = os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)
        prefixes = os.environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep)
        workspaces += [f"{prefix}/share" for prefix in prefixes if prefix]
        self.types, self._files = message_types({}), dict[str, Path]()
        for folder in (*folders, *filter(None, workspaces)):
            for path in sorted(Path(folder).rglob("msg/*.msg")):
                self._files.setdefault(f"{path.parent.parent.name}/msg/{path.stem}", path)

    def knows(self, kind: str) -> bool:
        """Whether a type is defined, for example "spinal/msg/Imu".

        Raises:
            ConfigError: for a definition that cannot be read, or needs another one that is not there.
        """
        if kind in self.types.fielddefs:
            return True
        if kind not in self._files:
            return False
        from rosbags.typesys import get_types_from_msg

        try:
            new = get_types_from_msg(read_source(self._files[kind]).content.decode("utf-8"), kind)
            for part in _parts(new[kind]):
                if not self.knows(part):
                    raise ConfigError(f"it needs '{part}', of which no definition is known")
            self.types.register(new)
        except Exception as error:  # rosbags has several of its own
            raise ConfigError(f"'{self._files[kind]}' is no message definition: {error}") from error
        return True

    def described(self, kind: str) -> tuple[str, str, str]:
        """Name, digest and text of a known type, as ROS 1 has them."""
        text, digest = self.types.generate_msgdef(kind, ros_version=1)
        return kind.replace("/msg/", "/"), digest, text

    def read(self, kind: str, data: bytes) -> Any:
        """The plain value of a message as it travels."""
        return plain_of(self.types.deserialize_ros1(data, kind))

    def write(self, kind: str, value: Any, seq: int) -> bytes:
        """A plain value as it travels, its header numbered."""
        return bytes(self.types.serialize_ros1(message_of(self.types, kind, value, seq), kind))


def _parts(definition: object) -> list[str]:
    """Types of a definition's fields that are messages themselves."""
    from rosbags.interfaces import Nodetype

    _, fields = definition  # type: ignore[misc]
    elements = [form[1][0] if form[0] in (Nodetype.ARRAY, Nodetype.SEQUENCE) else form for _, form in fields]
    return [kind for node, kind in elements if node == Nodetype.NAME]
