"""Which controllers may fly beside each other; light, as it is asked before a page opens."""

from __future__ import annotations

from collections.abc import Sequence

from skylimb.base.errors import ConfigError

MOST_FLIGHTS = 2
"""Flights beside each other at most: a page has room for two."""


def require_beside(controllers: Sequence[object]) -> None:
    """Check that these controllers can fly beside each other.

    One may be named twice: its gains are turned beside each other.

    Args:
        controllers: a name for each flight, or what else says which it is.

    Raises:
        ConfigError: when there are too many.
    """
    if len(controllers) > MOST_FLIGHTS:
        raise ConfigError(
            f"{len(controllers)} controllers are too many beside each other: at most {MOST_FLIGHTS}"
        )
