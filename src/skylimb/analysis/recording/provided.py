"""What a record needs of code that stands above it: its pictures.

Whoever makes one of them provides it here, from above; so the record imports none of it, and nothing is
loaded before it is used. `skylimb.analysis` provides `plot`, `show` and `html`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from skylimb.base.errors import of_an_extra

if TYPE_CHECKING:
    from collections.abc import Callable

_makers: dict[str, Callable[..., Any]] = {}


def provide(**makers: Callable[..., Any]) -> None:
    """Provide things by name, each by the function that makes it."""
    _makers.update(makers)


def provided(name: str, *arguments: Any) -> Any:
    """The thing of that name, made from some arguments.

    Raises:
        MissingExtraError: a package that only an extra installs is missing; the message names it.
    """
    try:
        return _makers[name](*arguments)
    except ImportError as error:
        raise of_an_extra(error) or error from None
