"""How runs are shown. What draws them stands above the record, so it is named here from outside.

`skylimb.analysis` names it as soon as anything of it is imported; nothing is loaded before it is used.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from skylimb.analysis.recording.run import Run


@dataclass(frozen=True)
class Views:
    """The ways to show runs.

    Attributes:
        plot: some runs by name, and a figure's or a signal's name, to a matplotlib figure.
        show: some runs by name, to what a notebook shows of them in three dimensions.
        html: a run, to HTML for a notebook.
    """

    plot: Callable[[Mapping[str, Run], str], Any]
    show: Callable[[Mapping[str, Run]], Any]
    html: Callable[[Run], str]


_used: list[Views] = []


def use_views(views: Views) -> None:
    """Show runs in these ways from now on."""
    _used[:] = [views]


def views() -> Views:
    """The ways to show runs."""
    return _used[0]
