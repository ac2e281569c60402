"""The file formats that hold messages, by the ending of a file."""

from __future__ import annotations

from pathlib import Path

from skylimb.analysis.exchange.bag import Bag
from skylimb.analysis.exchange.mcap_file import Mcap
from skylimb.base.errors import choice_error

_CONTAINERS: dict[str, type[Bag] | type[Mcap]] = {".bag": Bag, ".mcap": Mcap}

ENDINGS = (".nc", *_CONTAINERS)
"""Of all logs."""


def container_of(path: str | Path) -> Bag | Mcap:
    """The container that a file's ending names.

    Raises:
        ConfigError: for an ending that is none of them.
    """
    ending = Path(path).suffix
    if ending not in _CONTAINERS:
        raise choice_error("ending of a log", ending or str(path), _CONTAINERS)
    return _CONTAINERS[ending]()
