"""Words on the pictures of a video: who flies, when, and what is felt."""

from __future__ import annotations

from pathlib import Path

import matplotlib
import numpy as np
from PIL import Image, ImageColor, ImageDraw, ImageFont

from skylimb.analysis.figures import palette
from skylimb.analysis.recording import Run
from skylimb.analysis.scores.signals import contact_axis, phase_names

PAPER = np.array([255.0, 255.0, 255.0])
OPACITY = 0.78

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
        self._name = palette.label(run.name) + (" (failed)" if run.failed else "")
        self._colour = ImageColor.getrgb(palette.colours({run.name: run})[run.name])
        self._speed = "" if speed == 1 else f"{speed:g} times real time"
        log = run.log
        self._times = log.time.values
        names = {number: PHASE_LABELS.get(name, name) for name, number in phase_names(log).items()}
        self._phases = [names.get(int(number), "") for number in log.phase.values] if names else []
        self._readings: list[tuple[str, np.ndarray, str]] = []
        axis = contact_axis(log)
        if {"cog_position", "cog_position_reference"} <= set(log.variables):
            away = axis.along(log.cog_position.values - log.cog_position_reference.values)
            self._readings.append((f"CoG displacement {axis}", 1000 * away, "{:+.0f} mm"))
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
        pixels = pixels.copy()
        edge, wide, inner = self._px(24), self._px(340), self._px(16)
        head = pixels[edge : edge + self._px(104), edge : edge + wide]
        with _Brush(head) as brush:
            brush.text((inner, self._px(10)), self._name, self._colour, self._title)
            phase = self._phases[sample] if self._phases else ""
            line = f"t = {self._times[sample]:4.1f} s    {phase}"
            brush.text((inner, self._px(52)), line, "#1A1A1A", self._text)
            brush.text((inner, self._px(78)), self._speed, "#666666", self._small)
        if not self._readings:
            return pixels
        bottom = pixels.shape[0] - edge
        foot = pixels[bottom - self._px(20 + 30 * len(self._readings)) : bottom, edge : edge + wide]
        with _Brush(foot) as brush:
            for row, (name, values, form) in enumerate(self._readings):
                place = wide - inner, self._px(10 + 30 * row)
                brush.text((inner, place[1]), name, "#444444", self._text)
                brush.text(place, form.format(values[sample]), "#1A1A1A", self._text, anchor="ra")
        return pixels

    def _font(self, name: str, points: float) -> ImageFont.FreeTypeFont:
        path = Path(matplotlib.get_data_path()) / "fonts" / "ttf" / f"{name}.ttf"
        return ImageFont.truetype(str(path), max(self._px(points), 6))

    def _px(self, length: float) -> int:
        return round(length * self._unit)


class _Brush:
    """Draws on a part of a picture that is first covered by a translucent white panel."""

    def __init__(self, part: np.ndarray) -> None:
        self._part = part
        self._image = Image.fromarray((OPACITY * PAPER + (1 - OPACITY) * part).astype(np.uint8))

    def __enter__(self) -> ImageDraw.ImageDraw:
        return ImageDraw.Draw(self._image)

    def __exit__(self, *error: object) -> None:
        self._part[:] = np.asarray(self._image)
