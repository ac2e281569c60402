"""ROS 2's message types as DDS knows them; what travels is made and read elsewhere, as bytes."""

from __future__ import annotations

from functools import cache
from typing import Any

_OTHERWISE = {"bool": bool, "string": str}
"""What Python has itself."""


class DdsTypes:
    """Makes a class of cyclonedds of each type, with all its fields: others compare them.

    Args:
        types: rosbags' type store.
    """

    def __init__(self, types: Any) -> None:
        self._fields = types.fielddefs
        self.of = cache(self._made)

    def _made(self, kind: str) -> Any:
        """The class of "geometry_msgs/msg/Pose": its objects hold `content`, the message as it travels."""
        from cyclonedds.idl import make_idl_struct

        package, _, name = kind.split("/")
        fields = {field: self._form(*form) for field, form in self._fields[kind][1]}
        made: Any = make_idl_struct(name, f"{package}.msg.dds_.{name}_", fields, dataclassify=False)

        def serialize(message: Any, *args: Any, **kwargs: Any) -> bytes:
            return message.content

        def deserialize(cls: Any, data: bytes, *args: Any, **kwargs: Any) -> Any:
            message = cls()
            message.content = bytes(data)
            return message

        made.serialize = serialize
        made.deserialize = made.deserialize_key = classmethod(deserialize)
        return made

    def _form(self, node: Any, detail: Any) -> Any:
        """A field's type, of rosbags' form of it."""
        from cyclonedds.idl import types as idl
        from rosbags.interfaces import Nodetype

        if node == Nodetype.NAME:
            return self.of(detail)
        if node == Nodetype.BASE:
            name = str(detail[0])
            return _OTHERWISE.get(name) or getattr(idl, name)
        element, length = detail
        inner = self._form(*element)
        if node == Nodetype.ARRAY:
            return idl.array[inner, length]
        return idl.sequence[inner, length] if length else idl.sequence[inner]
