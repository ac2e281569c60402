"""The one function through which every file of a user's is read, and what a record keeps of such a file.

Whoever reads a file that a flight depends on holds its `Source`: content and digest as they were read. So the
record of a run has what really flew, also when the file is edited while it flies. A configuration with a key
that names a file (`Key(file=True)`) has an attribute `sources` with what was read for it.
"""

from __future__ import annotations

import hashlib
import os
import stat
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from skylimb.base.errors import UnreadableError, did_you_mean, nearest

_MESHES = (".stl", ".obj", ".ply", ".off", ".gltf", ".glb")

_MEGABYTES = {
    ".toml": 0.25, ".py": 1.0, ".yaml": 0.25, ".yml": 0.25, ".msg": 0.1, ".json": 4.0,
    ".svg": 4.0, ".urdf": 4.0, ".xacro": 4.0,
    **dict.fromkeys(_MESHES, 10.0),
    ".npy": 32.0, ".csv": 8.0, ".txt": 8.0,
    ".png": 16.0, ".jpg": 16.0, ".jpeg": 16.0, ".tif": 16.0, ".tiff": 16.0, ".bmp": 16.0,
}  # fmt: skip
_MEGABYTES_OF_OTHERS = 16.0
"""Largest size of a file by its ending: what its reader takes in 2 s and 300 MB."""

PACKAGE = Path(__file__).parents[1]
"""Files in here come with skylimb; its version stands for them."""


@dataclass(frozen=True)
class Source:
    """A file as it was read.

    Attributes:
        path: where it was, absolute and without symbolic links.
        content: its bytes.
    """

    path: Path
    content: bytes = field(repr=False)

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the content, hexadecimal."""
        return hashlib.sha256(self.content).hexdigest()

    @property
    def shipped(self) -> bool:
        """Whether it is a part of this package."""
        return self.path.is_relative_to(PACKAGE)


def read_source(path: str | Path) -> Source:
    """Read a file that a user named.

    Raises:
        UnreadableError: when it is not there, with the nearest name beside it, is no regular file, is
            larger than files of its kind may be, or cannot be read.
    """
    path = Path(path)
    try:
        resolved = path.resolve()
        str(resolved).encode()  # records name their files in UTF-8
        return Source(resolved, _content(path, _MEGABYTES.get(path.suffix.lower(), _MEGABYTES_OF_OTHERS)))
    except FileNotFoundError:
        raise UnreadableError(f"no such file: '{path}'{_guess(path)}") from None
    except OSError as error:
        raise UnreadableError(f"cannot read '{path}': {error.strerror or error}") from error
    except UnicodeEncodeError:
        raise UnreadableError(f"cannot read {str(path)!r}: its name is not UTF-8") from None
    except (ValueError, RuntimeError) as error:  # no name that a file can have, or links in a circle
        raise UnreadableError(f"cannot read {str(path)!r}: {error}") from error


def content_of(path: Path) -> bytes | None:
    """The content of a file that nobody misses: None where it is not there or cannot be read."""
    try:
        return read_source(path).content if path.is_file() else None
    except UnreadableError:
        return None


def _content(path: Path, megabytes: float) -> bytes:
    """The bytes of a regular file. Nothing else is read: a pipe would never end, a device may do anything."""
    # Without waiting: a pipe opens only when somebody writes into it.
    with open(
        path, "rb", opener=lambda name, flags: os.open(name, flags | getattr(os, "O_NONBLOCK", 0))
    ) as file:
        if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
            raise UnreadableError(f"cannot read '{path}': it is no regular file")
        most = int(1e6 * megabytes)
        # One more than allowed, whatever its size was said to be: files below /proc have none, others grow.
        content = file.read(most + 1)
        if len(content) > most:
            kind = path.suffix.lower()
            remedy = "; a mesh of fewer triangles does as well" if kind in _MESHES else ""
            raise UnreadableError(
                f"cannot read '{path}': it has more than {megabytes:g} MB, the most for a "
                f"{kind or 'plain'} file{remedy}"
            )
        return content


def _guess(path: Path) -> str:
    """The name of a file of the same kind beside the missing one, as a question."""
    there: Iterable[Path] = path.parent.glob(f"*{path.suffix}") if path.parent.is_dir() else ()
    # Compared without the ending, in which all are alike.
    guess = nearest(path.stem, [entry.stem for entry in there])
    return did_you_mean(guess and f"{path.parent / guess}{path.suffix}")
