"""The file formats that hold messages, by the ending of a file."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

from skylimb.analysis.exchange.bag import Bag
from skylimb.analysis.exchange.mcap_file import Mcap
from skylimb.base.errors import choice_error

CONTAINERS: dict[str, type[Bag] | type[Mcap]] = {".bag": Bag, ".mcap": Mcap}

ENDINGS = (".nc", *CONTAINERS)
"""Of all logs."""


def ending_of(path: str | Path, known: Collection[str] = ENDINGS) -> str:
    """The ending of a log's name.

    Raises:
        ConfigError: for an ending that is none of those.
    """
    ending = Path(path).suffix
    if ending not in known:
        raise choice_error("ending of a log", ending or str(path), known)
    return ending


def container_of(path: str | Path) -> Bag | Mcap:
    """The container that a file's ending names.

    Raises:
        ConfigError: for an ending that is none of them.
    """
    return CONTAINERS[ending_of(path, CONTAINERS)]()
