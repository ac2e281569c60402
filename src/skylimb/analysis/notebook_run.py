"""Runs as a user holds them in Python: records that draw themselves. Who reads records needs no pictures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from skylimb.analysis.recording import folder as recorded
from skylimb.analysis.recording.run import Run as Record
from skylimb.base.errors import of_extras, unknown_key


class Run(Record):
    """A record with its pictures."""

    def _repr_html_(self) -> str:
        """Verdict, scores and small plots, for a notebook."""
        with of_extras():
            from skylimb.analysis.figures.notebook import run_html

            return run_html(self)

    def plot(self, what: str = "") -> Any:
        """A matplotlib figure of the run: one of the report's figures by name, or a signal over time.

        Args:
            what: "cog_tracking" (the usual one), "pen_traces", ..., or a signal's name.

        Raises:
            UnknownNameError: when it is neither.
            MissingExtraError: a package that only an extra installs is missing; the message names it.
        """
        return Runs({self.name: self}).plot(what)

    def show(self) -> Any:
        """The flight to watch in a notebook, in three dimensions, with plots that follow the time."""
        return Runs({self.name: self}).show()


class Runs(dict[str, Run]):
    """Runs by name, in the order in which they were asked for."""

    def __missing__(self, name: object) -> Run:
        """Raise an `UnknownKeyError` with the nearest name."""
        raise unknown_key("run", name, self)

    def plot(self, what: str = "") -> Any:
        """A matplotlib figure of all of them; see `Run.plot`."""
        with of_extras():
            from skylimb.analysis.figures.plotting import plotted

            return plotted(self, what)

    def show(self) -> Any:
        """The flights to watch beside each other in a notebook, with plots that follow the time."""
        with of_extras():
            from skylimb.analysis.viewer.page import FlightViewer

            return FlightViewer(self)


def load_runs(folder: str | Path) -> Runs:
    """The runs that `run`, `compare` or `draw` left in a folder, by name.

    Raises:
        OutputError: if the folder doesn't exist, holds no run, or a run cannot be read.
    """
    return Runs(recorded.load_runs(folder, Run))
