"""The verbs that fly: `run` and `compare`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar

from tyro.conf import arg

from skylimb.cli import output
from skylimb.cli.options import (
    Assignments,
    Experiment,
    Out,
    Seed,
    Video,
    new_folder,
    settings_of,
    stem,
    whole_number,
)
from skylimb.errors import ConfigError

if TYPE_CHECKING:
    from skylimb.recording.run import Run as RunRecord


@dataclass(frozen=True)
class Run:
    """Fly one controller through one experiment.

    Leaves log.nc, metrics.json, config.toml, figures/ and video.mp4. The exit code is 1 for a failed flight.
    """

    examples: ClassVar[str] = """
        skylimb run --controller hybrid
        skylimb run paper --set surface.friction=0.2 trajectory.direction=-1 --out out/slippery
        skylimb run mine.toml --controller my_controller.py --seed 4 --no-video
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
            help_behavior_hint="",
        ),
    ] = ""
    seed: Seed = ""
    set: Assignments = ()
    out: Out = ""
    video: Video = True

    def __call__(self) -> int:
        """Fly, record, draw."""
        settings, seed = settings_of(self.set), whole_number("--seed", self.seed)
        folder = new_folder(
            self.out, "-".join(stem(name) for name in (self.experiment, self.controller) if name)
        )
        import skylimb
        from skylimb.analysis import write_run

        with output.flights() as progress:
            run = skylimb.run(
                self.experiment, self.controller or None, seed=seed, set=settings, progress=progress
            )
        with output.working(
            "drawing figures and video (a minute without a graphics card)"
            if self.video
            else "drawing figures"
        ):
            written = write_run(run, folder, video=self.video)
        return _summary({run.name: run}, folder, written.warnings)


@dataclass(frozen=True)
class Compare:
    """Fly several controllers through the same experiment with the same seed.

    Leaves a folder per controller, metrics.csv, the figures that compare them and report.html. The exit code
    is 1 when a flight failed.
    """

    examples: ClassVar[str] = """
        skylimb compare
        skylimb compare paper --controllers hybrid my_gains.toml --out out/mine-or-theirs
        skylimb compare --set surface.slope=-0.35 --no-video
    """

    experiment: Experiment = "paper"
    controllers: Annotated[
        tuple[str, ...], arg(metavar="NAME ...", help="Names, TOML files or Python files of controllers.")
    ] = ("pid", "impedance", "admittance", "hybrid")
    seed: Seed = ""
    set: Assignments = ()
    out: Out = ""
    video: Video = True

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
        from skylimb.analysis import write_comparison

        with output.flights() as progress:
            runs = skylimb.compare(
                self.experiment, self.controllers, seed=seed, set=settings, progress=progress
            )
        with output.working(
            "drawing figures, report and videos (a minute each without a graphics card)"
            if self.video
            else "drawing figures and report"
        ):
            written = write_comparison(runs, folder, video=self.video)
        return _summary(runs, folder, written.warnings)


def _summary(runs: Mapping[str, RunRecord], folder: Path, warnings: Sequence[str] = ()) -> int:
    output.scores(runs)
    output.places(folder, warnings)
    return 1 if any(run.failed for run in runs.values()) else 0
