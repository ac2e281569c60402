"""Several runs by name."""

from __future__ import annotations

from typing import Any

from skylimb.analysis.recording.provided import provided
from skylimb.analysis.recording.run import Run


class Runs(dict[str, Run]):
    """Runs by name, in the order in which they were asked for."""

    def plot(self, what: str = "") -> Any:
        """A matplotlib figure of all of them: one of the report's figures by name, or a signal over time.

        Args:
            what: "cog_tracking" (the usual one), "pen_traces", ..., or a signal's name.

        Raises:
            UnknownNameError: when it is neither.
        """
        return provided("plot", self, what)

    def show(self) -> Any:
        """The flights to watch beside each other in a notebook, with plots that follow the time."""
        return provided("show", self)
