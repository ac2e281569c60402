"""Live flights that draw what people hand them: lines by hand, SVG files, words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from skylimb.apps.studio.branching_flights import BranchingFlights
from skylimb.apps.studio.drawings import (
    FILE,
    FONT,
    SHAPE,
    TEXT,
    drawn_last,
    keep_drawing,
    require_svg,
    strokes_as_svg,
    without,
)
from skylimb.apps.studio.flight_setup import FlightSetup
from skylimb.base.errors import SkylimbError


class DrawingFlights(BranchingFlights):
    """Flights that take off anew with each drawing.

    Args:
        setup: what is flown.
        out: folder for drawings, and for all else that is kept; it is made when something is.

    Attributes:
        begun_with: keys of the experiment that were given when the studio began.
    """

    def __init__(self, setup: FlightSetup, out: Path) -> None:
        self.begun_with = setup.keys
        super().__init__(setup)
        self.out = out
        self._placed: Mapping[str, Any] = {}  # keys of the last drawing by hand

    def draw(self, drawing: str | Sequence[Sequence[Sequence[float]]], name: str = "drawing.svg") -> Path:
        """Draw on the surface, from take-off.

        Args:
            drawing: the text of an SVG file, in the size and at the place that the experiment's path has; or
                strokes of points (u, v) in the surface's axes, m, drawn where they are.
            name: of the SVG file.

        Returns:
            The SVG file that was kept.
        """
        takeoff, place = self.live.flights[0].takeoff, dict[str, Any]()
        if isinstance(drawing, str):
            svg = drawing
            require_svg(svg, name)
        else:
            svg, place = strokes_as_svg(drawing, takeoff.experiment.surface, takeoff.mission.frame)
        path = keep_drawing(svg, self.out)
        try:
            self._draw({FILE: str(path.resolve())}, place, "a new drawing")
        except SkylimbError:
            path.unlink(missing_ok=True)
            raise
        return path

    def write(self, text: str, font: str = "") -> None:
        """Draw words, from take-off, in the size and at the place that the experiment's path has.

        Args:
            text: one line of printable ASCII characters.
            font: a Hershey font; the one that is set where it is empty.
        """
        self._draw({TEXT: text} | ({FONT: font} if font else {}), {}, "new words")

    def _draw(self, what: Mapping[str, Any], place: Mapping[str, Any], why: str) -> None:
        """Take off with a drawing, at a place of its own or else where and as large as usual."""
        keys = without(self.live.setup.keys, self._placed, self.begun_with)
        keys |= {**place, SHAPE: "drawing", **drawn_last(what)}
        self._begin_again(replace(self._setup_now(), keys=keys), why)
        self._placed = place

    def _setup_now(self) -> FlightSetup:
        """What is flown, with the gains as they have become."""
        return replace(self.live.setup, gains=self.live.gains())
