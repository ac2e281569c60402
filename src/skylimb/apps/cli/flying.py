"""The verbs that fly: `run` and `compare`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar

from skylimb.apps.cli import output
from skylimb.apps.cli.arguments import arg
from skylimb.apps.cli.options import (
    Assignments,
    Calibration,
    Experiment,
    Out,
    Seed,
    Use,
    Video,
    new_folder,
    settings_of,
    stem,
    whole_number,
)
from skylimb.base.errors import ConfigError

if TYPE_CHECKING:
    from skylimb.analysis.recording.run import Run as RunRecord
    from skylimb.analysis.scores.user_scores import UserFigure


@dataclass(frozen=True)
class Run:
    """Fly one controller through one experiment.

    Leaves log.nc, metrics.json, config.toml, figures/ and report.html, in which one can watch the flight;
    with --video video.mp4 after all of them. The exit code is 1 for a lost flight, and 0 for one that came to
    its end, done as commanded or not.
    """

    examples: ClassVar[str] = """
        skylimb run --controller hybrid
        skylimb run paper --set surface.friction=0.2 trajectory.direction=-1 --out out/slippery
        skylimb run mine.toml --controller my_controller.py --seed 4
        skylimb run out/slippery/config.toml        the same flight again
        skylimb run --set 'controller.translation.normalized_stiffness=[4, 4, 2]'
    """

    experiment: Experiment = "paper"
    controller: Annotated[
        str,
        arg(
            metavar="NAME",
            help="A controller's name, its TOML file, or a Python file; by default the one in the "
            "experiment's file, else hybrid.",
        ),
    ] = ""
    seed: Seed = ""
    set: Assignments = ()
    use: Use = ()
    calibration: Calibration = ""
    out: Out = ""
    video: Video = False
    bag: Annotated[bool, arg(help="Whether to write log.bag too, with the lab's topics.")] = False

    def __call__(self) -> int:
        """Fly, record, draw."""
        settings, seed = settings_of(self.set), whole_number("--seed", self.seed)
        folder = new_folder(
            self.out, "-".join(stem(name) for name in (self.experiment, self.controller) if name)
        )
        if self.bag:
            from skylimb.analysis.exchange.message_types import message_types

            message_types()  # what is not installed is said before anything flies
        import skylimb

        with output.flights() as progress:
            run = skylimb.run(
                self.experiment,
                self.controller or None,
                seed=seed,
                set=settings,
                progress=progress,
                use=self.use,
                calibration=self.calibration or None,
            )
        with output.working("writing log, figures and report"):
            from skylimb.analysis import write_run

            write_run(run, folder, videos_follow=self.video, figures=own_figures(self.use))
        if self.bag:
            with output.working("writing log.bag"):
                from skylimb.analysis.exchange.convert import write_log

                write_log(run, folder / "log.bag")
        return _hand_over({run.name: run}, folder, self.video)


@dataclass(frozen=True)
class Compare:
    """Fly several controllers through the same experiment with the same seed.

    Leaves a folder per controller, metrics.csv, the figures that compare them and report.html, in which one
    can watch the flights beside each other; with --video a video per controller after all of them. The exit
    code is 1 when a flight was lost.
    """

    examples: ClassVar[str] = """
        skylimb compare
        skylimb compare paper --controllers hybrid my_gains.toml --out out/mine-or-theirs
        skylimb compare --set surface.slope=-0.35 --video
    """

    experiment: Experiment = "paper"
    controllers: Annotated[
        tuple[str, ...], arg(metavar="NAME ...", help="Names, TOML files or Python files of controllers.")
    ] = ("pid", "impedance", "admittance", "hybrid")
    seed: Seed = ""
    set: Assignments = ()
    use: Use = ()
    calibration: Calibration = ""
    out: Out = ""
    video: Video = False

    def __call__(self) -> int:
        """Fly all, record, draw."""
        if not self.controllers:
            raise ConfigError("--controllers names no controller; `skylimb list` shows them")
        called = [stem(name) for name in self.controllers]
        if len(set(called)) < len(called):
            raise ConfigError(f"--controllers names two that are called alike: {', '.join(called)}")
        settings, seed = settings_of(self.set), whole_number("--seed", self.seed)
        folder = new_folder(self.out, f"{stem(self.experiment)}-comparison")
        import skylimb

        with output.flights() as progress:
            runs = skylimb.compare(
                self.experiment,
                self.controllers,
                seed=seed,
                set=settings,
                progress=progress,
                use=self.use,
                calibration=self.calibration or None,
            )
        with output.working("writing logs, figures and report"):
            from skylimb.analysis import write_comparison

            write_comparison(runs, folder, videos_follow=self.video, figures=own_figures(self.use))
        return _hand_over(runs, folder, self.video)


def own_figures(use: tuple[str, ...]) -> list[UserFigure]:
    """The figures in some files of the user's."""
    from skylimb.analysis.scores.user_scores import figures_of, load_user_scores

    return figures_of(load_user_scores(use))


def _hand_over(runs: Mapping[str, RunRecord], folder: Path, video: bool) -> int:
    """Show the scores and where the results lie, then draw the videos."""
    output.scores(runs)
    output.notes(runs)
    output.places(folder)
    if video:
        output.videos(runs, folder)
    return 1 if any(run.failed for run in runs.values()) else 0
