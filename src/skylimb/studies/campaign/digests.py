"""Digests by which a campaign knows that a user's file is still the one that it was begun with."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path

from skylimb.base.keys import files_of
from skylimb.base.user_modules import load_module, sources_of_module
from skylimb.flight.experiments.experiment import Experiment


def file_digests(experiments: Sequence[Experiment]) -> dict[str, str]:
    """Digest of what lies under each key that names a file; a robot has its own."""
    return {key: one_digest(sorted(digests)) for key, digests in files_read(experiments).items()}


def files_read(experiments: Sequence[Experiment]) -> dict[str, set[str]]:
    """The digests of all files that experiments read under each of these keys."""
    read: dict[str, set[str]] = {}
    for experiment in experiments:
        for key, owner in files_of(experiment):
            if key != "robot":
                read.setdefault(key, set()).update(source.digest for source in owner.sources)
    return read


def code_digest(path: Path) -> str:
    """Digest of a user's Python file, and of the modules that it imports from its own folder."""
    return one_digest([source.digest for source in sources_of_module(load_module(path, ()))])


def one_digest(digests: Sequence[str]) -> str:
    """The digest of several; of one alone itself."""
    return digests[0] if len(digests) == 1 else hashlib.sha256("".join(digests).encode()).hexdigest()
