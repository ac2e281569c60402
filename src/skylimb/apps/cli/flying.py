"""The verbs that fly: `run`, `compare` and `draw`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from skylimb.apps.cli import output
from skylimb.apps.cli.arguments import arg
from skylimb.apps.cli.options import (
    Calibration,
    Controller,
    Experiment,
    Out,
    Seed,
    Settings,
    Use,
    Video,
    new_folder,
    stem,
)
from skylimb.base.errors import ConfigError

if TYPE_CHECKING:
    from skylimb.analysis.recording.run import Run
    from skylimb.analysis.scores.user_scores import UserFigure


def run(
    experiment: Experiment = "paper",
    *,
    controller: Controller = None,
    seed: Seed = None,
    set: Settings = None,
    use: Use = (),
    calibration: Calibration = None,
    out: Out = "",
    video: Video = False,
    bag: Annotated[bool, arg("Whether to write log.bag too, with the lab's topics.")] = False,
) -> int:
    """Fly one controller through one experiment.

    Leaves log.nc, metrics.json, config.toml, figures/ and report.html, in which one can watch the flight;
    with --video video.mp4 after all of them. The exit code is 1 for a lost flight, and 0 for one that came to
    its end, done as commanded or not.

    Examples:
        skylimb run --controller hybrid
        skylimb run paper --set surface.friction=0.2 trajectory.direction=-1 --out out/slippery
        skylimb run mine.toml --controller my_controller.py --seed 4
        skylimb run out/slippery/config.toml        the same flight again
        skylimb run --set 'controller.translation.normalized_stiffness=[4, 4, 2]'
    """
    folder = new_folder(out, "-".join(stem(name) for name in (experiment, controller) if name))
    if bag:
        from skylimb.analysis.exchange.message_types import message_types

        message_types()  # what is not installed is said before anything flies
    import skylimb

    with output.flights() as progress:
        flown = skylimb.run(experiment, controller, seed, set, progress, use, calibration)
    with output.working("writing log, figures and report"):
        from skylimb.analysis import write_run

        write_run(flown, folder, videos_follow=video, figures=_figures_of(use))
    if bag:
        with output.working("writing log.bag"):
            from skylimb.analysis.exchange.convert import write_log

            write_log(flown, folder / "log.bag")
    output.scores({flown.name: flown})
    return output.hand_over({flown.name: flown}, folder, video)


def compare(
    experiment: Experiment = "paper",
    *,
    controllers: Annotated[
        tuple[str, ...], arg("Names, TOML files or Python files of controllers.", "NAME ...")
    ] = ("pid", "impedance", "admittance", "hybrid"),
    seed: Seed = None,
    set: Settings = None,
    use: Use = (),
    calibration: Calibration = None,
    out: Out = "",
    video: Video = False,
) -> int:
    """Fly several controllers through the same experiment with the same seed.

    Leaves a folder per controller, metrics.csv, the figures that compare them and report.html, in which one
    can watch the flights beside each other; with --video a video per controller after all of them. The exit
    code is 1 when a flight was lost.

    Examples:
        skylimb compare
        skylimb compare paper --controllers hybrid my_gains.toml --out out/mine-or-theirs
        skylimb compare --set surface.slope=-0.35 --video
    """
    if not controllers:
        raise ConfigError("--controllers names no controller; `skylimb list` shows them")
    called = [stem(name) for name in controllers]
    if len(frozenset(called)) < len(called):
        raise ConfigError(f"--controllers names two that are called alike: {', '.join(called)}")
    folder = new_folder(out, f"{stem(experiment)}-comparison")
    import skylimb

    with output.flights() as progress:
        runs = skylimb.compare(experiment, controllers, seed, set, progress, use, calibration)
    with output.working("writing logs, figures and report"):
        from skylimb.analysis import write_comparison

        write_comparison(runs, folder, videos_follow=video, figures=_figures_of(use))
    output.scores(runs)
    return output.hand_over(runs, folder, video)


def _figures_of(use: tuple[str, ...]) -> list[UserFigure]:
    """The figures in some files of the user's."""
    from skylimb.analysis.scores.user_scores import figures_of, load_user_scores

    return figures_of(load_user_scores(use))


def draw(
    file: Annotated[str, arg("What to draw; or see --text.", "FILE.svg")] = "",
    *,
    text: Annotated[str, arg("Words to draw, on one line.", "WORDS")] = "",
    font: Annotated[
        str, arg("A Hershey font; futural, rowmans, scripts and cursive are thin.", "NAME")
    ] = "futural",
    surface: Annotated[
        str, arg("The experiment, or its TOML file, on whose surface to draw.", "NAME")
    ] = "paper",
    width: Annotated[
        float, arg("Of the box that the drawing fills, its proportions kept, m; 0: no limit.", "M")
    ] = 0.60,
    height: Annotated[float, arg("Of that box, m; 0: no limit.", "M")] = 0.0,
    speed: Annotated[float, arg("Of the pen on smooth lines, m/s.", "V")] = 0.05,
    order: Annotated[
        Literal["given", "nearest"], arg("Of the strokes: the file's, or for short ways between them.")
    ] = "given",
    controller: Annotated[
        str, arg("A controller's name, its TOML file, or a Python file.", "NAME")
    ] = "drawing",
    seed: Seed = None,
    set: Settings = None,
    out: Out = "",
    video: Video = False,
) -> int:
    """Draw an SVG file, or words, on a surface.

    The robot draws its lines with the pen. Leaves log.nc, metrics.json, config.toml, figures/ (drawing.png
    shows the drawn line and its reference) and report.html; with --video video.mp4. The exit code is 1 for a
    lost flight.

    Examples:
        skylimb draw examples/skylimb.svg --surface paper
        skylimb draw --text skylimb --surface cylinder_convex --width 0.8
        skylimb draw --text hello --font scripts --height 0.2 --set surface.slope=0
    """
    if bool(file) == bool(text):
        both = "not both" if file else "for example --text hello"
        raise ConfigError(f"draw needs either an SVG file or --text, {both}; see skylimb draw --help")
    folder = new_folder(out, f"{_word(Path(file).stem or text)}-on-{_word(stem(surface))}")
    import skylimb

    with output.flights() as progress:
        drawn = skylimb.draw(
            file, text, surface, controller, seed=seed, set=set, progress=progress,
            font=font, width=width, height=height, speed=speed, order=order,
        )  # fmt: skip
    with output.working("writing log, figures and report"):
        from skylimb.analysis import write_run

        write_run(drawn, folder, videos_follow=video)
    output.show_table(_rows(drawn), title=drawn.log.attrs["experiment"], justify="lr")
    output.verdicts({drawn.name: drawn})
    return output.hand_over({drawn.name: drawn}, folder, video)


def _word(name: str) -> str:
    """A name that can be a part of a folder's name."""
    kept = "".join(letter if letter.isalnum() or letter in "_-." else "_" for letter in name)
    return kept.strip("._")[:40] or "drawing"


def _rows(drawn: Run) -> list[tuple[str, str]]:
    """What the terminal shows of a drawing; no numbers of a failed flight."""
    from skylimb.analysis.scores.pen_line import DRAWN_WITHIN, drawn_fraction
    from skylimb.analysis.scores.signals import in_phase

    rows = [("Status", output.status(drawn)), ("Controller", drawn.name)]
    if drawn.failed:
        return rows
    time = drawn.log.time.values[in_phase(drawn.log, "slide")]
    within = f"within {1e3 * DRAWN_WITHIN:g} mm"
    return [
        *rows,
        ("Pen off its reference, root mean square", _millimetres(drawn.metrics["pen_line_rms"])),
        ("Pen off its reference, largest", _millimetres(drawn.metrics["pen_line_max"])),
        (f"Reference line drawn {within}", f"{100.0 * drawn_fraction(drawn.log):.0f} %"),
        *_faithful(drawn),
        ("Time for the drawing", f"{float(time[-1] - time[0]):.1f} s" if len(time) else "-"),
    ]


def _faithful(drawn: Run) -> list[tuple[str, str]]:
    """In which order, what is missing, what is too much, and what was drawn in the air."""
    scores, strokes = drawn.metrics, drawn.metrics["strokes"]
    if scores["line_frechet"] is None:
        return []
    length, found = scores["line_length"], scores["line_length_drawn"]
    rows = [
        ("Frechet distance, in the strokes' order", _millimetres(scores["line_frechet"])),
        ("Farthest place of the reference from what was drawn", _millimetres(scores["line_missing_max"])),
        (
            "Length drawn, of the reference's",
            f"{found:.2f} of {length:.2f} m ({100.0 * found / length:.0f} %)",
        ),
        ("Touch while lifted", f"{scores['lift_touch_time']:.1f} of {scores['lift_time']:.1f} s"),
    ]
    distances = [math.inf if stroke["frechet"] is None else stroke["frechet"] for stroke in strokes]
    if len(distances) > 1:
        worst = max(range(len(distances)), key=distances.__getitem__)
        apart = "not drawn" if math.isinf(distances[worst]) else _millimetres(distances[worst])
        which = f"number {worst + 1} of {len(strokes)}, {1e3 * strokes[worst]['length']:.0f} mm long"
        rows.append(("Worst stroke by its Frechet distance", f"{apart} ({which})"))
    return rows


def _millimetres(length: float | None) -> str:
    return "-" if length is None or math.isnan(length) else f"{1e3 * length:.1f} mm"
