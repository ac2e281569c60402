"""Digests by which a campaign knows that a user's file is still the one that it was begun with."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from skylimb.base.keys import files_of
from skylimb.base.sources import Source, content_of
from skylimb.base.user_modules import load_module, sources_of_module
from skylimb.flight.experiments.experiment import Experiment


def file_digests(experiments: Sequence[Experiment]) -> dict[str, str]:
    """Digest of what lies under each key that names a file; a robot has its own."""
    return {key: one_digest(sorted(digests)) for key, digests in files_read(experiments).items()}


def files_read(experiments: Sequence[Experiment]) -> dict[str, set[str]]:
    """The digests of all files that experiments read under each of these keys."""
    return {key: {source.digest for source in sources} for key, sources in sources_read(experiments).items()}


def sources_read(experiments: Sequence[Experiment]) -> dict[str, list[Source]]:
    """The files themselves."""
    read: dict[str, list[Source]] = {}
    for experiment in experiments:
        for key, owner in files_of(experiment):
            if key != "robot":
                read.setdefault(key, []).extend(owner.sources)
    return read


def code_digest(path: Path) -> str:
    """Digest of a user's Python file, and of the modules that it imports from its own folder."""
    return one_digest([source.digest for source in code_sources(path)])


def code_sources(path: Path) -> tuple[Source, ...]:
    """These files themselves."""
    return sources_of_module(load_module(path, ()))


def by_path(sources: Iterable[Source]) -> dict[str, str]:
    """Where each file of a user's lies -> its digest."""
    return {source.path.as_posix(): source.digest for source in sources if not source.shipped}


def changed_files(read: Mapping[str, str]) -> str:
    """Which files are others than they were read, for the end of a sentence; nothing where none is known."""
    now = {name: content_of(Path(name)) for name in read}
    changed = [
        f"'{name}' {'has changed' if content is not None else 'is not there any more'}"
        for name, content in now.items()
        if content is None or hashlib.sha256(content).hexdigest() != read[name]
    ]
    return f" ({', '.join(changed)})" if changed else ""


def one_digest(digests: Sequence[str]) -> str:
    """The digest of several; of one alone itself."""
    return digests[0] if len(digests) == 1 else hashlib.sha256("".join(digests).encode()).hexdigest()
