"""What is built once and kept: an entry with a digest of its content beside it, compared before it is used.

A disk that was full, a copy that broke off or a bit that flipped leaves an entry that would be believed, or
that ends the process when it is loaded. Such an entry counts as absent: who asks for it builds it anew.
"""

from __future__ import annotations

import hashlib
import warnings
from pathlib import Path

from skylimb.base.files import replacing
from skylimb.base.sources import content_of


def cache_folder() -> Path:
    """Where a user's machine keeps what can be computed again; it may not be there, or not writable."""
    import platformdirs  # a robot that ships flies without it

    return platformdirs.user_cache_path("skylimb")


def kept(path: Path) -> bytes | None:
    """The content of an entry as it was kept; None where there is none, or another content by now."""
    content, digest = content_of(path), content_of(_digest_file(path))
    if content is None or digest is None:
        return None
    if hashlib.sha256(content).hexdigest().encode() == digest:
        return content
    warnings.warn(f"'{path}' was damaged since it was kept, and is made anew", UserWarning, stacklevel=2)
    return None


def keep(path: Path, content: bytes) -> None:
    """Keep an entry, in the place of one that may be there.

    Raises:
        OSError: it cannot be written; what is read later is what stood there before, or nothing.
    """
    if not path.is_absolute():
        # Without a home the cache's path begins with "~", which would be a folder in the working directory.
        raise FileNotFoundError(f"the user's cache '{path}' has no place")
    path.parent.mkdir(parents=True, exist_ok=True)
    for file, written in (
        (path, content),
        (_digest_file(path), hashlib.sha256(content).hexdigest().encode()),
    ):
        # What can be made again, and is compared first, need not survive a power cut.
        with replacing(file, durable=False) as aside:
            aside.write_bytes(written)


def _digest_file(path: Path) -> Path:
    return path.with_name(f"{path.name}.sha256")
