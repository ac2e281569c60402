"""The call that draws: the path of an experiment replaced by a drawing or by words, and flown."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

from skylimb.analysis.recording.run import Run
from skylimb.base.errors import ConfigError
from skylimb.control.controller import Controller
from skylimb.flight.experiments.experiment import experiment_from_mapping, experiment_tables, put
from skylimb.flight.public import Keep, Progress, run

_ACCELERATION = 0.05
"""Of the pen, m/s^2: where a stroke begins faster, friction holds the pen back, then lets it go at once."""


def draw(
    file: str | Path = "",
    text: str = "",
    surface: str = "paper",
    controller: str | Controller = "drawing",
    *,
    font: str = "futural",
    width: float = 0.60,
    height: float = 0.0,
    speed: float = 0.05,
    order: Literal["given", "nearest"] = "given",
    seed: int | None = None,
    set: Mapping[str, Any] | None = None,
    progress: Progress | None = None,
    keep: Keep | None = None,
) -> Run:
    """Draw an SVG file, or words, on a surface.

    Args:
        file: an SVG file; or `text`.
        text: words to draw, on one line.
        surface: the experiment, or its TOML file, on whose surface to draw.
        controller: as of `skylimb.run`.
        font: of the words, a Hershey font.
        width: of the box that the drawing fills, its proportions kept, m; 0: no limit.
        height: of that box, m; 0: no limit.
        speed: of the pen on smooth lines, m/s.
        order: of the strokes: the file's, or for short ways between them.
        seed: of the sensors' noise; the experiment's own when None.
        set: dotted keys of the experiment and of the controller with new values.
        progress: called with how far the flight is.
        keep: as of `skylimb.run`.

    Returns:
        The run; `pen_line_rms` and `line_frechet` are among its metrics.

    Raises:
        SkylimbError: when it cannot be drawn; nothing has flown then.
    """
    if bool(file) == bool(text):
        raise ConfigError("draw needs either a file or a text" + (", not both" if file else ""))
    tables = experiment_tables(surface)
    on = Path(surface).stem if surface.endswith(".toml") else surface
    tables["name"] = f"{Path(file).stem if file else text} on {on}"
    source = f"The file {Path(file).name}" if file else f"The words {text!r}"
    tables["description"] = f"{source} drawn by the pen"
    tables["trajectory"] = {
        "shape": "drawing",
        "file": str(file),
        "text": text,
        "font": font,
        "width": width,
        "height": height,
        "order": order,
        "speed": speed,
        "acceleration": _ACCELERATION,
        "feedforward": "full",
    }
    tables.pop("controller", None)
    gains = {}
    for key, value in (set or {}).items():
        if key.startswith("controller."):
            gains[key] = value
        else:
            put(tables, key, value)
    return run(
        experiment_from_mapping(tables, f"experiment {on}"), controller, seed, gains, progress, keep=keep
    )
