"""The verbs: each a record of its options that does its work when called and returns the exit code."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from tyro.conf import Positional, UseAppendAction, arg

from skylimb.cli import output
from skylimb.errors import ConfigError, OutputError, unknown_name

if TYPE_CHECKING:
    from skylimb.recording.run import Run as RunRecord

Experiment = Annotated[Positional[str], arg(metavar="EXPERIMENT", help="An experiment's name or TOML file.")]
Assignments = Annotated[
    UseAppendAction[tuple[tuple[str, ...], ...]],
    arg(
        metavar="KEY=VALUE ...",
        help="Change the experiment; `skylimb show EXPERIMENT` lists the keys.",
        help_behavior_hint="",
    ),
]
Seed = Annotated[
    str,
    arg(
        metavar="N",
        help="Seed of the sensors' noise; by default the experiment's own.",
        help_behavior_hint="",
    ),
]
Out = Annotated[
    str,
    arg(
        metavar="DIR",
        help="New folder for the results; by default a fresh one below out/.",
        help_behavior_hint="",
    ),
]
Video = Annotated[bool, arg(help="Whether to draw the video, which takes longer than the flight.")]
Folder = Annotated[Positional[str], arg(metavar="DIR", help="A folder that run or compare left.")]


@dataclass(frozen=True)
class List:
    """List the experiments, controllers and robots that ship."""

    examples: ClassVar[str] = "skylimb list"

    def __call__(self) -> int:
        """Print the three lists."""
        import skylimb

        output.names("Experiments", skylimb.list_experiments())
        output.names("Controllers", skylimb.list_controllers())
        output.names("Robots", skylimb.list_robots())
        return 0


@dataclass(frozen=True)
class Show:
    """Show an experiment, a controller or a robot in full.

    For an experiment that is every key that --set can change, with its value.
    """

    examples: ClassVar[str] = """
        skylimb show paper
        skylimb show hybrid
        skylimb show hydrus_xi_quad
        skylimb show paper > mine.toml      a start for an experiment of your own
    """

    name: Annotated[
        Positional[str], arg(metavar="NAME", help="As `skylimb list` has it, or an experiment file.")
    ]

    def __call__(self) -> int:
        """Print it."""
        import skylimb
        from skylimb.config import write_toml
        from skylimb.control.preset import preset_mapping

        experiments, controllers, robots = (
            skylimb.list_experiments(),
            skylimb.list_controllers(),
            skylimb.list_robots(),
        )
        if self.name in experiments or self.name.endswith(".toml"):
            output.toml(write_toml(skylimb.load_experiment(self.name).to_mapping()))
        elif self.name in controllers:
            output.toml(preset_mapping(self.name)[1].read_text(encoding="utf-8"))
        elif self.name in robots:
            output.robot(skylimb.load_robot(self.name))
        else:
            known = [*experiments, *controllers, *robots]
            raise unknown_name("experiment, controller or robot", self.name, known)
        return 0


@dataclass(frozen=True)
class Run:
    """Fly one controller through one experiment.

    Leaves log.nc, metrics.json, config.toml, figures/ and video.mp4. The exit code is 1 for a failed flight.
    """

    examples: ClassVar[str] = """
        skylimb run --controller hybrid
        skylimb run paper --set surface.friction=0.2 trajectory.direction=-1 --out out/slippery
        skylimb run mine.toml --controller my_controller.py --seed 4 --no-video
        skylimb run --set 'controller.translation.normalized_stiffness=[4, 4, 2]'
    """

    experiment: Experiment = "paper"
    controller: Annotated[
        str, arg(metavar="NAME", help="A controller's name, its TOML file, or a Python file.")
    ] = "hybrid"
    seed: Seed = ""
    set: Assignments = ()
    out: Out = ""
    video: Video = True

    def __call__(self) -> int:
        """Fly, record, draw."""
        settings, seed = _settings(self.set), _whole_number("--seed", self.seed)
        folder = _new_folder(self.out, f"{_stem(self.experiment)}-{_stem(self.controller)}")
        import skylimb
        from skylimb.analysis import write_run

        with output.flights() as progress:
            run = skylimb.run(self.experiment, self.controller, seed=seed, set=settings, progress=progress)
        with output.working("drawing figures and video" if self.video else "drawing figures"):
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
        settings, seed = _settings(self.set), _whole_number("--seed", self.seed)
        folder = _new_folder(self.out, f"{_stem(self.experiment)}-comparison")
        import skylimb
        from skylimb.analysis import write_comparison

        with output.flights() as progress:
            runs = skylimb.compare(
                self.experiment, self.controllers, seed=seed, set=settings, progress=progress
            )
        with output.working(
            "drawing figures, videos and report" if self.video else "drawing figures and report"
        ):
            written = write_comparison(runs, folder, video=self.video)
        return _summary(runs, folder, written.warnings)


@dataclass(frozen=True)
class Report:
    """Write a folder's report and figures anew, from its logs alone."""

    examples: ClassVar[str] = "skylimb report out/demo"

    folder: Folder

    def __call__(self) -> int:
        """Draw again."""
        from skylimb.analysis import write_report
        from skylimb.recording import load_runs

        runs = load_runs(self.folder)
        with output.working("drawing figures and report"):
            write_report(runs, self.folder)
        return _summary(runs, Path(self.folder))


@dataclass(frozen=True)
class View:
    """Watch a flight again in MuJoCo's viewer; without a display, say which files to open."""

    examples: ClassVar[str] = """
        skylimb view out/demo/hybrid
        skylimb view out/demo --speed 0.5
    """

    folder: Folder
    speed: Annotated[float, arg(metavar="X", help="Times the real speed.")] = 1.0

    def __call__(self) -> int:
        """Play."""
        from skylimb.cli.viewer import replay
        from skylimb.recording import load_runs

        if not self.speed > 0.0:
            raise ConfigError(f"--speed = {self.speed:g} must be positive")
        replay(load_runs(self.folder), Path(self.folder), self.speed)
        return 0


@dataclass(frozen=True)
class VerifyContact:
    """Hold the simulated contact against theory, row by row.

    Each row is a small test rig and the figure that mechanics predicts for it. The exit code is 1 when a row
    fails.
    """

    examples: ClassVar[str] = """
        skylimb verify-contact
        skylimb verify-contact --out out/contact
    """

    out: Annotated[
        str,
        arg(
            metavar="DIR",
            help="New folder for the table and its figures; by default none.",
            help_behavior_hint="",
        ),
    ] = ""

    def __call__(self) -> int:
        """Run every rig."""
        folder = _new_folder(self.out, "") if self.out else None
        from skylimb.verification import verify_contact

        with output.working("running the test rigs"):
            rows = verify_contact(folder)
        return output.verification(rows)


VERBS: dict[str, Any] = {
    "run": Run,
    "compare": Compare,
    "list": List,
    "show": Show,
    "report": Report,
    "view": View,
    "verify-contact": VerifyContact,
}


def _settings(assignments: tuple[tuple[str, ...], ...]) -> dict[str, Any]:
    from skylimb.config import parse_assignment

    settings: dict[str, Any] = {}
    for text in (text for group in assignments for text in group):
        key, value = parse_assignment(text)
        if key in settings:
            raise ConfigError(f"--set gives '{key}' twice")
        settings[key] = value
    return settings


def _whole_number(option: str, text: str) -> int | None:
    if not text:
        return None
    try:
        return int(text)
    except ValueError:
        raise ConfigError(f"{option} = '{text}' is not a whole number") from None


def _stem(name: str) -> str:
    return Path(name).stem if name.endswith((".toml", ".py")) else name


def _new_folder(given: str, usual: str) -> Path:
    """The folder asked for, which must not exist; else the first free one of its usual names below out/."""
    from skylimb.recording.files import require_new

    if given:
        return require_new(given)
    for count in range(1, 10_000):
        folder = Path("out") / (usual if count == 1 else f"{usual}-{count}")
        if not folder.exists():
            return require_new(folder)
    raise OutputError(f"out/ holds thousands of folders called '{usual}'; name one with --out")


def _summary(runs: Mapping[str, RunRecord], folder: Path, warnings: Sequence[str] = ()) -> int:
    output.scores(runs)
    output.places(folder, warnings)
    return 1 if any(run.failed for run in runs.values()) else 0
