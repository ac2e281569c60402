"""The verbs that look at what there is: `list`, `show`, `report`, `view` and `verify-contact`."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from skylimb.apps.cli import output
from skylimb.apps.cli.arguments import Positional, arg
from skylimb.apps.cli.options import Folder, new_folder
from skylimb.base.errors import ConfigError

if TYPE_CHECKING:
    from skylimb.apps.catalogue.entries import Entry


@dataclass(frozen=True)
class List:
    """List what there is: experiments, controllers, robots, surfaces, events, paths, laws, metrics, ..."""

    examples: ClassVar[str] = "skylimb list"

    def __call__(self) -> int:
        """Print the lists; `skylimb show` takes each name."""
        from skylimb.apps.catalogue.entries import KINDS, entries

        found = entries()
        for kind, title in KINDS.items():
            output.names(title, {entry.name: entry.meaning for entry in found if entry.kind == kind})
        return 0


@dataclass(frozen=True)
class Show:
    """Show every key of an experiment, a controller, a robot: value, unit, range and meaning.

    Surfaces, events, paths, laws, tables and metrics are shown as well, by the names that `skylimb list` has;
    so does this verb without a name. For an experiment and a controller these are the keys that --set can
    change. Into a file, it is written as that file would have to be. `skylimb keys WORD` searches all keys.
    """

    examples: ClassVar[str] = """
        skylimb show paper
        skylimb show hybrid
        skylimb show surface.cylinder
        skylimb show event.push
        skylimb show robots/my_robot        whatever run takes: a folder, a TOML file, a Python file
        skylimb show paper > mine.toml      a start for an experiment of your own
    """

    name: Annotated[
        Positional[str],
        arg(metavar="NAME", help="As `skylimb list` has it, or what `run` takes; every name without it."),
    ] = ""

    def __call__(self) -> int:
        """Print it."""
        if not self.name:
            return List()()
        kind = _kind_of_path(self.name)
        if not kind:
            from skylimb.apps.catalogue.entries import find_entry

            entry = find_entry(self.name)
            kind = entry.kind
            if kind not in _SHOWN:
                _show_entry(entry)
                return 0
        _SHOWN[kind](self.name)
        return 0


def _kind_of_path(name: str) -> str:
    """Whether a file or folder holds an experiment, a controller or a robot; empty for what is no path."""
    from skylimb.base.config import read_toml
    from skylimb.control.slots import SLOTS
    from skylimb.robots.loader import list_robots

    if name.endswith(".toml"):
        keys = read_toml(name).keys()
        return "robot" if "urdf" in keys else "controller" if keys & {*SLOTS, "file"} else "experiment"
    if name.endswith(".py"):
        return "controller"
    return "robot" if Path(name).is_dir() and name not in list_robots() else ""


def _show_entry(entry: Entry) -> None:
    """A surface, an event, a path, a law, a table of an experiment, a file of the user's, a metric."""
    from skylimb.apps.catalogue.entries import tables_of_entry
    from skylimb.apps.cli import key_tables

    if entry.kind == "metric":
        print(f"{entry.short}: {entry.meaning}")
        return
    tables = tables_of_entry(entry)
    hints = {
        "surface": f"Use it: skylimb run --set surface.kind={entry.short}",
        "event": "Use it: a table like this in an experiment's file; --set events.0.KEY=VALUE changes one",
        "path": f"Use it: skylimb run --set trajectory.shape={entry.short}",
        "law": f"Use it: skylimb run --set controller.{entry.name.partition('.')[0]}.law={entry.short}",
        "table": f"Change a key: skylimb run --set {key_tables.example(tables)}",
    }
    key_tables.show(
        f"{entry.name}: {entry.meaning}", tables, hints.get(entry.kind, "Every key with its default")
    )


def _show_experiment(name: str) -> None:
    from skylimb.apps.cli import key_tables
    from skylimb.base.keys import tables_of
    from skylimb.flight.experiments.experiment import load_experiment

    experiment = load_experiment(name)
    tables = list(tables_of(experiment))
    hint = f"Change a key: skylimb run {name} --set {key_tables.example(tables)}"
    key_tables.show(f"{experiment.name}: {experiment.description}", tables, hint)


def _show_controller(name: str) -> None:
    from skylimb.apps.cli import key_tables
    from skylimb.base.config import read_toml
    from skylimb.control.preset import ROBOTS, preset_from_mapping, preset_mapping
    from skylimb.control.preset_keys import preset_tables

    if name.endswith(".py") or (name.endswith(".toml") and "file" in read_toml(name)):
        _show_own_controller(name)
        return
    mapping, path = preset_mapping(name)
    preset = preset_from_mapping(mapping, path)
    tables = list(preset_tables(preset, mapping.get(ROBOTS)))
    setting = f"--set controller.{key_tables.example(tables)}"
    hint = f"Change a key: skylimb run --controller {name} {setting}"
    key_tables.show(f"{preset.name}: {preset.description}", tables, hint)


def _show_own_controller(name: str) -> None:
    """The gains of a controller in a Python file, or of a TOML file that keeps a set of them."""
    import skylimb
    from skylimb.apps.cli import key_tables

    controller: Any = skylimb.load_controller(name, skylimb.load_robot("hydrus_xi_quad"))
    tables = list(controller.key_tables()) if hasattr(controller, "key_tables") else []
    hint = f"Fly it: skylimb run --controller {name}"
    key_tables.show(f"{controller.name}: a controller of your own", tables, hint)


def _show_robot(name: str) -> None:
    from skylimb.apps.cli import key_tables
    from skylimb.base.keys import tables_of
    from skylimb.robots.loader import load_flight_file, load_robot

    robot = load_robot(name)
    if sys.stdout.isatty():
        output.robot(robot)
    title = f"{robot.name}: {robot.description.summary}; {robot.mass:.4f} kg"
    hint = "A robot of your own: a folder with a URDF and a file like this one, flight.toml"
    key_tables.show(title, tables_of(load_flight_file(name)), hint)


_SHOWN: dict[str, Callable[[str], None]] = {
    "experiment": _show_experiment,
    "controller": _show_controller,
    "robot": _show_robot,
}


@dataclass(frozen=True)
class Report:
    """Write a folder's report and figures anew, from its logs alone."""

    examples: ClassVar[str] = "skylimb report out/demo"

    folder: Folder

    def __call__(self) -> int:
        """Draw again."""
        from skylimb.analysis import write_report
        from skylimb.analysis.recording import load_runs

        runs = load_runs(self.folder)
        with output.working("drawing figures and report"):
            write_report(runs, self.folder)
        output.scores(runs)
        output.places(Path(self.folder))
        return 0


@dataclass(frozen=True)
class View:
    """Watch a flight again in MuJoCo's viewer; without a display, as a page in the browser.

    The page is replay.html in the folder, one file that needs no network.
    """

    examples: ClassVar[str] = """
        skylimb view out/demo/hybrid
        skylimb view out/demo --speed 0.5
    """

    folder: Folder
    speed: Annotated[float, arg(metavar="X", help="Times the real speed.")] = 1.0

    def __call__(self) -> int:
        """Play."""
        from skylimb.analysis.recording import load_runs
        from skylimb.apps.cli.viewer import replay

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
        ),
    ] = ""

    def __call__(self) -> int:
        """Run every rig."""
        folder = new_folder(self.out, "") if self.out else None
        from skylimb.studies.verification import verify_contact

        with output.claims() as progress:
            rows = verify_contact(folder, progress)
        code = output.verification(rows)
        if folder:
            output.places(folder)
        return code
