"""Metrics, figures, video and report of recorded flights.

It reads runs and nothing else, so that a real flight's log is as welcome as a simulated one. The names of
`__init__.pyi` are loaded when they are first used: scoring a flight should not pay for drawing it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import lazy_loader

from skylimb.analysis.recording.provided import provide

if TYPE_CHECKING:
    from collections.abc import Mapping

    from skylimb.analysis.recording.run import Run

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def _plot(runs: Mapping[str, Run], what: str) -> Any:
    from skylimb.analysis.figures.plotting import plotted

    return plotted(runs, what)


def _show(runs: Mapping[str, Run]) -> Any:
    from skylimb.analysis.viewer.page import FlightViewer

    return FlightViewer(runs)


def _html(run: Run) -> str:
    from skylimb.analysis.figures.notebook import run_html

    return run_html(run)


provide(plot=_plot, show=_show, html=_html)
