"""Words on the pictures of a video: who flies, when, and what is felt."""

from __future__ import annotations

from pathlib import Path

import matplotlib
import numpy as np
from PIL import Image, ImageColor, ImageDraw, ImageFont

from skylimb.analysis.figures import palette
from skylimb.analysis.recording import Run
from skylimb.analysis.scores.signals import contact_axis, off_mission, phase_names

PAPER = (255, 255, 255, 199)
"""Of the panels behind the words: white, and a little of what is behind it."""

PHASE_LABELS = {"hover_end": "hover"}


class Overlay:
    """Writes on pictures of one run, in place of a graphics library's own and coarser letters.

    Args:
        run: what is shown.
        size: width and height of the pictures.
        speed: seconds of flight in a second of film.
    """

    def __init__(self, run: Run, size: tuple[int, int], speed: float) -> None:
        self._unit = max(size[1] / 720, 0.3)
        self._title, self._text = self._font("DejaVuSans-Bold", 30), self._font("DejaVuSans", 20)
        self._small = self._font("DejaVuSans", 15)
        self._name = palette.label(run.name) + (f" ({run.mark})" if run.failed else "")
        self._colour = ImageColor.getrgb(palette.colours({run.name: run})[run.name])
        self._speed = "" if speed == 1 else f"{speed:g} times real time"
        log = run.log
        self._times = log.time.values
        names = {number: PHASE_LABELS.get(name, name) for name, number in phase_names(log).items()}
        self._phases = [names.get(int(number), "") for number in log.phase.values] if names else []
        self._readings: list[tuple[str, np.ndarray, str]] = []
        axis = contact_axis(log)
        if {"cog_position", "cog_position_reference"} <= set(log.variables):
            self._readings.append((f"CoG displacement {axis}", 1000 * off_mission(log, axis), "{:+.0f} mm"))
        if "reach" in log:
            self._readings.append(("reach", log.reach.values, "{:.3f} m"))
        if "contact_force_normal" in log:
            self._readings.append(("normal force", log.contact_force_normal.values, "{:.1f} N"))

    def draw(self, pixels: np.ndarray, sample: int) -> np.ndarray:
        """Write on a picture.

        Args:
            pixels: RGB bytes, shape (height, width, 3).
            sample: number of the log's sample that it shows.

        Returns:
            A picture of the same shape.
        """
        picture = Image.fromarray(pixels)
        brush = ImageDraw.Draw(picture, "RGBA")
        edge, wide, inner = self._px(24), self._px(340), self._px(16)
        brush.rectangle((edge, edge, edge + wide - 1, edge + self._px(104) - 1), PAPER)
        brush.text((edge + inner, edge + self._px(10)), self._name, self._colour, self._title)
        phase = self._phases[sample] if self._phases else ""
        line = f"t = {self._times[sample]:4.1f} s    {phase}"
        brush.text((edge + inner, edge + self._px(52)), line, "#1A1A1A", self._text)
        brush.text((edge + inner, edge + self._px(78)), self._speed, "#666666", self._small)
        bottom = pixels.shape[0] - edge
        top = bottom - self._px(20 + 30 * len(self._readings))
        if self._readings:
            brush.rectangle((edge, top, edge + wide - 1, bottom - 1), PAPER)
        for row, (name, values, form) in enumerate(self._readings):
            place = top + self._px(10 + 30 * row)
            reading = form.format(values[sample])
            brush.text((edge + inner, place), name, "#444444", self._text)
            brush.text((edge + wide - inner, place), reading, "#1A1A1A", self._text, anchor="ra")
        return np.asarray(picture)

    def _font(self, name: str, points: float) -> ImageFont.FreeTypeFont:
        path = Path(matplotlib.get_data_path()) / "fonts" / "ttf" / f"{name}.ttf"
        return ImageFont.truetype(str(path), max(self._px(points), 6))

    def _px(self, length: float) -> int:
        return round(length * self._unit)
