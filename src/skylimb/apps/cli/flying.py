"""The verbs that fly: `run`, `compare` and `draw`."""

from __future__ import annotations

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
    from skylimb.analysis.recording import Run
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
    with --video video.mp4 after all of them. The log comes first: a metric, a figure or a video that fails
    is named, also in failed.txt, and the rest is there. What Ctrl-C ends is kept in FOLDER-interrupted. The
    exit code is 1 for a lost flight and where something failed, and 0 for a flight that came to its end, done
    as commanded or not.

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
    from skylimb.analysis import KeptFlights

    with KeptFlights(folder, 1) as kept, output.flights() as progress:
        flown = skylimb.run(experiment, controller, seed, set, progress, use, calibration, kept.keep)
    runs = {flown.name: flown}
    failed = output.written(runs, folder, figures_of(use), video)
    if bag:
        failed += _bag(flown, folder)
    output.scores(runs)
    return output.hand_over(runs, folder, video, failed)


def _bag(run: Run, folder: Path) -> tuple[str, ...]:
    """Write log.bag beside the other files; why it could not be written, in a line."""
    from skylimb.analysis.exchange.convert import write_log
    from skylimb.analysis.report.attempts import Attempts, mark_more_failed

    parts = Attempts()
    with output.working("writing log.bag"), parts.part("log.bag"):
        write_log(run, folder / "log.bag")
    mark_more_failed(folder, parts.lines())
    return parts.lines()


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
    from skylimb.analysis import KeptFlights

    with KeptFlights(folder, len(controllers), apart=True) as kept, output.flights() as progress:
        runs = skylimb.compare(experiment, controllers, seed, set, progress, use, calibration, kept.keep)
    failed = output.written(runs, folder, figures_of(use), video)
    output.scores(runs)
    return output.hand_over(runs, folder, video, failed)


def figures_of(use: tuple[str, ...]) -> list[UserFigure]:
    """The figures in some files of the user's."""
    from skylimb.analysis.scores import user_scores

    return user_scores.figures_of(user_scores.load_user_scores(use))


def draw(
    file: Annotated[str, arg("What to draw; or see --text.", "FILE.svg")] = "",
    *,
    text: Annotated[str, arg("Words to draw, on one line.", "WORDS")] = "",
    font: Annotated[
        str | None,
        arg("A Hershey font, by default futural; rowmans, scripts and cursive are thin too.", "NAME"),
    ] = None,
    surface: Annotated[
        str, arg("The experiment, or its TOML file, on whose surface to draw.", "NAME")
    ] = "paper",
    width: Annotated[
        float | None,
        arg("Of the box that the drawing fills, its proportions kept, m; 0: no limit; by default 0.6.", "M"),
    ] = None,
    height: Annotated[float | None, arg("Of that box, m; by default 0: no limit.", "M")] = None,
    speed: Annotated[float | None, arg("Of the pen on smooth lines, m/s; by default 0.05.", "V")] = None,
    order: Annotated[
        Literal["given", "nearest"] | None,
        arg("Of the strokes: the file's, by default, or for short ways between them."),
    ] = None,
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
    from skylimb.analysis import KeptFlights

    with KeptFlights(folder, 1) as kept, output.flights() as progress:
        drawn = skylimb.draw(
            file, text, surface, controller, seed=seed, set=set, progress=progress,
            font=font, width=width, height=height, speed=speed, order=order,
            keep=kept.keep,
        )  # fmt: skip
    runs = {drawn.name: drawn}
    failed = output.written(runs, folder, video=video)
    output.scores(runs)
    return output.hand_over(runs, folder, video, failed)


def _word(name: str) -> str:
    """A name that can be a part of a folder's name."""
    kept = "".join(letter if letter.isalnum() or letter in "_-." else "_" for letter in name)
    return kept.strip("._")[:40] or "drawing"
