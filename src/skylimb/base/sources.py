"""The one function through which every file of a user's is read, and what a record keeps of such a file.

Whoever reads a file that a flight depends on holds its `Source`: content and digest as they were read. So the
record of a run has what really flew, also when the file is edited while it flies. A configuration with a key
that names a file (`Key(file=True)`) has an attribute `sources` with what was read for it.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from skylimb.base.errors import UnreadableError, nearest

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
        UnreadableError: when it is not there, with the nearest name beside it, or cannot be read.
    """
    path = Path(path)
    try:
        return Source(path.resolve(), path.read_bytes())
    except FileNotFoundError:
        raise UnreadableError(f"no such file: '{path}'{_guess(path)}") from None
    except OSError as error:
        raise UnreadableError(f"cannot read '{path}': {error.strerror or error}") from error
    except ValueError as error:  # no name that a file can have
        raise UnreadableError(f"cannot read {str(path)!r}: {error}") from error


def _guess(path: Path) -> str:
    """The name of a file of the same kind beside the missing one, as a question."""
    there: Iterable[Path] = path.parent.glob(f"*{path.suffix}") if path.parent.is_dir() else ()
    # Compared without the ending, in which all are alike.
    guess = nearest(path.stem, [entry.stem for entry in there])
    return f"; did you mean '{path.parent / guess}{path.suffix}'?" if guess else ""
