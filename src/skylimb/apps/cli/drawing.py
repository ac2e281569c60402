"""The verb `draw`: a drawing or words on a surface."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from skylimb.apps.cli import output
from skylimb.apps.cli.arguments import Positional, arg
from skylimb.apps.cli.options import (
    Assignments,
    Out,
    Seed,
    Video,
    new_folder,
    settings_of,
    stem,
    whole_number,
)
from skylimb.base.errors import ConfigError

if TYPE_CHECKING:
    from skylimb.analysis.recording.run import Run as RunRecord

_WANTED = "drawing"
"""The controller that is made for it."""

_ACCELERATION = 0.05
"""Of the pen, m/s^2: where a stroke begins faster, friction holds the pen back, then lets it go at once."""


@dataclass(frozen=True)
class Draw:
    """Draw an SVG file, or words, on a surface.

    The robot draws its lines with the pen. Leaves log.nc, metrics.json, config.toml, figures/ (drawing.png
    shows the drawn line and its reference) and report.html; with --video video.mp4. The exit code is 1 for a
    lost flight.
    """

    examples: ClassVar[str] = """
        skylimb draw examples/skylimb.svg --surface paper
        skylimb draw --text skylimb --surface cylinder_convex --width 0.8
        skylimb draw --text hello --font scripts --height 0.2 --set surface.slope=0
    """

    file: Annotated[
        Positional[str],
        arg(metavar="FILE.svg", help="What to draw; or see --text."),
    ] = ""
    text: Annotated[str, arg(metavar="WORDS", help="Words to draw, on one line.")] = ""
    font: Annotated[
        str, arg(metavar="NAME", help="A Hershey font; futural, rowmans, scripts and cursive are thin.")
    ] = "futural"
    surface: Annotated[
        str,
        arg(metavar="NAME", help="The experiment, or its TOML file, on whose surface to draw."),
    ] = "paper"
    width: Annotated[
        float,
        arg(metavar="M", help="Of the box that the drawing fills, its proportions kept, m; 0: no limit."),
    ] = 0.60
    height: Annotated[float, arg(metavar="M", help="Of that box, m; 0: no limit.")] = 0.0
    speed: Annotated[float, arg(metavar="V", help="Of the pen on smooth lines, m/s.")] = 0.05
    order: Annotated[
        Literal["given", "nearest"], arg(help="Of the strokes: the file's, or for short ways between them.")
    ] = "given"
    controller: Annotated[
        str,
        arg(
            metavar="NAME",
            help=f"A controller's name, its TOML file, or a Python file; by default {_WANTED}.",
        ),
    ] = ""
    seed: Seed = ""
    set: Assignments = ()
    out: Out = ""
    video: Video = False

    def __call__(self) -> int:
        """Fly, record, draw what was drawn."""
        if bool(self.file) == bool(self.text):
            both = "not both" if self.file else "for example --text hello"
            raise ConfigError(f"draw needs either an SVG file or --text, {both}; see skylimb draw --help")
        settings, seed = settings_of(self.set), whole_number("--seed", self.seed)
        what = Path(self.file).stem if self.file else self.text
        folder = new_folder(self.out, f"{_word(what)}-on-{_word(stem(self.surface))}")
        import skylimb

        experiment = self._experiment(what, settings)
        gains = {key: value for key, value in settings.items() if key.startswith("controller.")}
        with output.flights() as progress:
            run = skylimb.run(experiment, self.controller or _WANTED, seed, gains, progress)
        with output.working("writing log, figures and report"):
            from skylimb.analysis import write_run

            write_run(run, folder, videos_follow=self.video)
        output.drawing(experiment.name, _rows(run))
        if run.failed:
            print(f"{run.name} FAILED: {run.cause}")
        elif run.missed:
            print(f"{run.name} was not done as commanded: {'; '.join(run.missed)}")
        output.notes({run.name: run})
        output.places(folder)
        if self.video:
            output.videos({run.name: run}, folder)
        return 1 if run.failed else 0

    def _experiment(self, what: str, settings: dict[str, Any]) -> Any:
        """The surface's experiment with its path replaced by the drawing, then the user's own changes."""
        from skylimb.flight.experiments.experiment import experiment_from_mapping, experiment_tables, put

        tables = experiment_tables(self.surface)
        tables["name"] = f"{what} on {stem(self.surface)}"
        source = f"The file {Path(self.file).name}" if self.file else f"The words {what!r}"
        tables["description"] = f"{source} drawn by the pen"
        tables["trajectory"] = {
            "shape": "drawing",
            "file": self.file,
            "text": self.text,
            "font": self.font,
            "width": self.width,
            "height": self.height,
            "order": self.order,
            "speed": self.speed,
            "acceleration": _ACCELERATION,
            "feedforward": "full",
        }
        tables.pop("controller", None)
        for key, value in settings.items():
            if not key.startswith("controller."):
                put(tables, key, value)
        return experiment_from_mapping(tables, f"experiment {stem(self.surface)}")


def _word(name: str) -> str:
    """A name that can be a part of a folder's name."""
    kept = "".join(letter if letter.isalnum() or letter in "_-." else "_" for letter in name)
    return kept.strip("._")[:40] or "drawing"


def _rows(run: RunRecord) -> list[tuple[str, str]]:
    """What the terminal shows of a drawing; no numbers of a failed flight."""
    from skylimb.analysis.scores.pen_line import DRAWN_WITHIN, drawn_fraction
    from skylimb.analysis.scores.signals import in_phase

    rows = [("Status", f"[red]{run.status}[/red]" if run.failed else run.status), ("Controller", run.name)]
    if run.failed:
        return rows
    drawn = drawn_fraction(run.log)
    time = run.log.time.values[in_phase(run.log, "slide")]
    within = f"within {1e3 * DRAWN_WITHIN:g} mm"
    return [
        *rows,
        ("Pen off its reference, root mean square", _number(run.metrics["pen_line_rms"], ".1f", "mm", 1e3)),
        ("Pen off its reference, largest", _number(run.metrics["pen_line_max"], ".1f", "mm", 1e3)),
        (f"Reference line drawn {within}", _number(drawn, ".0f", "%", 100.0)),
        *_faithful(run),
        ("Time for the drawing", f"{float(time[-1] - time[0]):.1f} s" if len(time) else "-"),
    ]


def _faithful(run: RunRecord) -> list[tuple[str, str]]:
    """In which order, what is missing, what is too much, and what was drawn in the air."""
    scores, strokes = run.metrics, run.metrics["strokes"]
    if scores["line_frechet"] is None:
        return []
    length, drawn = scores["line_length"], scores["line_length_drawn"]
    lifted, touch = scores["lift_time"], scores["lift_touch_time"]
    missing = _number(scores["line_missing_max"], ".1f", "mm", 1e3)
    share = f"{drawn:.2f} of {length:.2f} m ({100.0 * drawn / length:.0f} %)"
    rows = [
        ("Frechet distance, in the strokes' order", _number(scores["line_frechet"], ".1f", "mm", 1e3)),
        ("Farthest place of the reference from what was drawn", missing),
        ("Length drawn, of the reference's", share),
        ("Touch while lifted", f"{touch:.1f} of {lifted:.1f} s"),
    ]
    leashes = [math.inf if stroke["frechet"] is None else stroke["frechet"] for stroke in strokes]
    if len(leashes) > 1:
        worst = max(range(len(leashes)), key=leashes.__getitem__)
        apart = "not drawn" if math.isinf(leashes[worst]) else f"{1e3 * leashes[worst]:.1f} mm"
        which = f"number {worst + 1} of {len(leashes)}, {1e3 * strokes[worst]['length']:.0f} mm long"
        rows.append(("Worst stroke by its Frechet distance", f"{apart} ({which})"))
    return rows


def _number(value: float | None, form: str, unit: str, scale: float) -> str:
    return "-" if value is None or math.isnan(value) else f"{scale * value:{form}} {unit}"
