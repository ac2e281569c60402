"""Message classes: ROS's own, and those that are made at run time from the user's .msg files.

The lab's definitions have changed more than once, and with them their digests. So the robot's own checkout
decides, never a copy of ours.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from skylimb.base.errors import ConfigError
from skylimb.base.sources import read_source

_RULE = "=" * 80


class Definitions:
    """Finds the class of a type.

    Args:
        folders: of .msg files as PACKAGE/msg/NAME.msg at any depth, for example a checkout of the lab's.
    """

    def __init__(self, folders: Sequence[str | Path] = ()) -> None:
        places = [Path(folder) for folder in folders]
        for place in places:
            if not place.is_dir():
                raise ConfigError(f"folder of messages '{place}' does not exist")
        self._files: dict[str, Path] = {}
        for place in [*places, *map(Path, _workspaces())]:
            for path in sorted(place.rglob("msg/*.msg")) if place.is_dir() else ():
                self._files.setdefault(f"{path.parent.parent.name}/{path.stem}", path)
        self._classes: dict[str, Any] = {}

    def find(self, name: str) -> Any | None:
        """The class of a type, for example "spinal/Imu"; None where no definition of it is known.

        Raises:
            ConfigError: for a definition that cannot be read.
        """
        if name not in self._classes:
            made = self._generated(name) if name in self._files else None
            self._classes[name] = made or _installed(name)
        return self._classes[name]

    def _generated(self, name: str) -> Any:
        import genpy.dynamic

        try:
            parts = [self._text(name)]
            parts += [f"MSG: {other}\n{self._text(other)}" for other in self._needed(name)]
            return genpy.dynamic.generate_dynamic(name, f"\n{_RULE}\n".join(parts))[name]
        except Exception as error:  # genmsg and genpy have several of their own
            raise ConfigError(f"'{self._files[name]}' is no message definition: {error}") from error

    def _text(self, name: str) -> str:
        if name in self._files:
            return read_source(self._files[name]).content.decode("utf-8")
        cls = _installed(name)
        if cls is None:
            raise ConfigError(f"it needs '{name}', of which no definition is known")
        return str(cls._full_text).split(_RULE)[0]

    def _needed(self, name: str) -> list[str]:
        """Types that a type is made of, each once, whatever they are made of themselves."""
        found: list[str] = []
        waiting = [name]
        while waiting:
            package = waiting[0].partition("/")[0]
            for other in _fields(self._text(waiting.pop(0)), package, self._files):
                if other not in found:
                    found.append(other)
                    waiting.append(other)
        return found


def _fields(text: str, package: str, known: Iterable[str]) -> list[str]:
    """Types of a definition's fields that are no built-in ones, with their package."""
    import genmsg.msgs

    found = []
    for line in text.splitlines():
        words = line.partition("#")[0].split()
        if len(words) < 2 or "=" in words[1:2] or "=" in line.partition("#")[0]:
            continue
        kind = words[0].partition("[")[0]
        if genmsg.msgs.is_builtin(kind):
            continue
        if kind == "Header":
            kind = "std_msgs/Header"
        found.append(kind if "/" in kind else f"{package}/{kind}")
    return found


def _installed(name: str) -> Any | None:
    package, _, kind = name.partition("/")
    try:
        return getattr(import_module(f"{package}.msg"), kind, None)
    except ImportError:
        return None


def _workspaces() -> list[str]:
    """Folders of a workspace that was sourced."""
    found = os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)
    found += [
        f"{prefix}/share" for prefix in os.environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep) if prefix
    ]
    return [folder for folder in found if folder]
