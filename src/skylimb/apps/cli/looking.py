"""The verbs that look at what there is: `list`, `show`, `report`, `view` and `verify-...`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from skylimb.apps.cli import output
from skylimb.apps.cli.arguments import arg
from skylimb.apps.cli.options import Folder, Use, new_folder
from skylimb.base.errors import ConfigError, unknown_name

if TYPE_CHECKING:
    from skylimb.apps.catalogue.entries import Entry


def list_all(
    kind: Annotated[str, arg("Only these: experiments, controllers, ...; all without it.", "KIND")] = "",
) -> None:
    """List what there is: experiments, controllers, robots, surfaces, events, paths, laws, metrics, ...

    Examples:
        skylimb list
        skylimb list controllers
    """
    from skylimb.apps.catalogue.added import added_rows
    from skylimb.apps.catalogue.entries import KINDS, entries

    asked = [each for each in KINDS if kind in ("", each, f"{each}s")]
    if not asked:
        raise unknown_name("kind of thing", kind, (f"{each}s" for each in KINDS))
    found = entries()
    for each in asked:
        rows = [(entry.name, entry.meaning) for entry in found if entry.kind == each]
        output.show_table(rows, title=KINDS[each])
    if not kind and (added := added_rows()):
        output.show_table(added, title="Added by installed packages")


def show(
    name: Annotated[
        str, arg("As `skylimb list` has it, or what `run` takes; every name without it.", "NAME")
    ] = "",
    *,
    physics: Annotated[bool, arg("Of an experiment: what acts in it, in SI, instead of its keys.")] = False,
) -> None:
    """Show every key of an experiment, a controller, a robot: value, unit, range and meaning.

    Surfaces, events, paths, laws, tables and metrics are shown as well, by the names that `skylimb list` has;
    so does this verb without a name. For an experiment and a controller these are the keys that --set can
    change. Into a file, it is written as that file would have to be. `skylimb keys WORD` searches all keys.

    Examples:
        skylimb show paper
        skylimb show hybrid
        skylimb show surface.cylinder
        skylimb show event.push
        skylimb show paper --physics
        skylimb show robots/my_robot        whatever run takes: a folder, a TOML file, a Python file
        skylimb show paper > mine.toml      a start for an experiment of your own
    """
    if physics:
        _show_physics(name or "paper")
        return
    if not name:
        list_all()
        return
    kind = _kind_of_path(name)
    if not kind:
        from skylimb.apps.catalogue.entries import find_entry

        entry = find_entry(name)
        kind = entry.kind
        if kind not in _SHOWN:
            _show_entry(entry)
            return
    _SHOWN[kind](name)


def _kind_of_path(name: str) -> str:
    """Whether a file, a folder or a package's name is that of an experiment, a controller or a robot.

    Empty for all other names.
    """
    from skylimb.base.config import read_toml
    from skylimb.base.plugins import added_names
    from skylimb.control.laws.file_kinds import kind_of_tables
    from skylimb.robots.loader import list_robots

    if name.endswith(".toml"):
        kind = kind_of_tables(read_toml(name))
        return kind if kind in _SHOWN else "experiment"
    if name.endswith(".py"):
        return "controller"
    if Path(name).is_dir() and name not in list_robots():
        return "robot"
    return next((kind for kind in _SHOWN if name in added_names(f"{kind}s")), "")


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
    hint = hints.get(entry.kind, "Every key with its default")
    key_tables.show_keys(f"{entry.name}: {entry.meaning}", tables, hint)


def _show_experiment(name: str) -> None:
    from skylimb.apps.cli import key_tables
    from skylimb.base.keys import tables_of
    from skylimb.flight.experiments.experiment import load_experiment

    experiment = load_experiment(name)
    tables = list(tables_of(experiment))
    hint = f"Change a key: skylimb run {name} --set {key_tables.example(tables)}"
    key_tables.show_keys(f"{experiment.name}: {experiment.description}", tables, hint)


def _show_physics(name: str) -> None:
    """What acts in an experiment, computed from the model that flies."""
    from itertools import groupby

    from skylimb.flight.physics_sheet import physics_sheet
    from skylimb.flight.takeoff import take_off

    (takeoff,) = take_off(name, (None,))
    for group, lines in groupby(physics_sheet(takeoff), key=lambda line: line.group):
        output.show_table([line[1:] for line in lines], title=f"{takeoff.experiment.name}: {group}")


def _show_controller(name: str) -> None:
    """The gains of a preset, of a controller in a Python file, or of a TOML file that keeps a set of them."""
    from skylimb.apps.cli import key_tables
    from skylimb.control.laws.preset import preset_from_mapping, preset_mapping

    mapping, path = preset_mapping(name)
    if "file" in mapping:
        import skylimb

        controller: Any = skylimb.load_controller(name, skylimb.load_robot("hydrus_xi_quad"))
        tables = list(controller.key_tables()) if hasattr(controller, "key_tables") else []
        title = f"{controller.name}: a controller of your own"
        hint = f"Fly it: skylimb run --controller {name}"
    else:
        from skylimb.control.laws.preset_keys import preset_tables

        preset = preset_from_mapping(mapping, path)
        tables = list(preset_tables(preset, mapping))
        title = f"{preset.name}: {preset.description}"
        setting = f"--set controller.{key_tables.example(tables)}"
        hint = f"Change a key: skylimb run --controller {name} {setting}"
    key_tables.show_keys(title, tables, hint)


def _show_robot(name: str) -> None:
    """A robot's figures, in a terminal, and its flight file."""
    from skylimb.apps.cli import key_tables
    from skylimb.apps.robot_import.report import joints_text, rotors_text
    from skylimb.base.keys import tables_of
    from skylimb.robots.loader import load_flight_file, load_robot

    robot = load_robot(name)
    description = robot.description
    title = f"{robot.name}: {description.summary}; {robot.mass:.4f} kg"
    if key_tables.for_a_person():
        at, tip = ", ".join(f"{value:g}" for value in description.tip.position), description.tip
        print(f"  mass      {robot.mass:.4f} kg in {len(robot.bodies)} moving bodies")
        print(rotors_text(description))
        print(joints_text(description))
        print(f"  tip       ({at}) m on '{tip.link}', radius {1e3 * tip.radius:g} mm\n")
    hint = "A robot of your own: a folder with a URDF and a file like this one, flight.toml"
    key_tables.show_keys(title, tables_of(load_flight_file(name)), hint)


_SHOWN: dict[str, Callable[[str], None]] = {
    "experiment": _show_experiment,
    "controller": _show_controller,
    "robot": _show_robot,
}


def report(folder: Folder) -> int:
    """Write a folder's report and figures anew, from its logs alone.

    The exit code is 1 when something failed, which failed.txt names.

    Examples:
        skylimb report out/demo
    """
    return score(folder)


def score(folder: Folder, *, use: Use = ()) -> int:
    """Score the flights of a folder again, and write its figures and report anew, from its logs alone.

    Metrics and figures of --use are computed and drawn besides; numbers of a user's metrics that are in a log
    already stay otherwise. The exit code is 1 when something failed, which failed.txt names.

    What is no flight, as the folders of `calibrate` and `replay`, is refused, and so are flights of different
    experiments: a comparison is of one.

    Examples:
        skylimb score out/demo
        skylimb score out/demo-interrupted
        skylimb score out/demo --use overshoot.py
    """
    from skylimb.analysis.recording import load_runs
    from skylimb.analysis.report.folder_kinds import require_flights
    from skylimb.analysis.report.places import configurations, films
    from skylimb.analysis.scores.user_scores import figures_of, load_user_scores, scored

    own, found = load_user_scores(use), load_runs(folder)
    require_flights(found, Path(folder))
    runs = {name: scored(run, own) for name, run in found.items()}
    failed = output.written(runs, Path(folder), figures_of(own))
    output.scores(runs)
    _, others = configurations(runs, Path(folder))
    output.notes(f"'{file}' is not what flew: it was edited, or is another flight's" for file in others)
    output.notes(f"'{file}' shows another flight" for file in films(runs, Path(folder))[1])
    return int(output.hand_over(runs, Path(folder), failed=failed) and bool(failed))


def view(folder: Folder, *, speed: Annotated[float, arg("Times the real speed.", "X")] = 1.0) -> None:
    """Watch a flight again in MuJoCo's viewer; without a display, as a page in the browser.

    The page is view.html in the folder, one file that needs no network.

    Examples:
        skylimb view out/demo/hybrid
        skylimb view out/demo --speed 0.5
    """
    from skylimb.analysis.recording import load_runs
    from skylimb.apps.cli.viewer import show_runs

    if not speed > 0.0:
        raise ConfigError(f"--speed = {speed:g} must be positive")
    show_runs(load_runs(folder), Path(folder), speed)


def verify_contact(
    *, out: Annotated[str, arg("New folder for the table and its figures; by default none.", "DIR")] = ""
) -> int:
    """Compare the simulated contact with theory, row by row.

    Each row is a small test rig and the figure that mechanics predicts for it. The exit code is 1 when a row
    fails.

    Examples:
        skylimb verify-contact
        skylimb verify-contact --out out/contact
    """
    return _verified("verify_contact", out)


def verify_rotors(
    *, out: Annotated[str, arg("New folder for the table and its figures; by default none.", "DIR")] = ""
) -> int:
    """Compare rotors that have a speed and an inertia with theory, row by row.

    They are those of plant.rotors = "speed". The exit code is 1 when a row fails.

    Examples:
        skylimb verify-rotors
        skylimb verify-rotors --out out/rotors
    """
    return _verified("verify_rotors", out)


def _verified(suite: str, out: str) -> int:
    """Measure every claim of a suite and print the table; 1 when one fails."""
    folder = new_folder(out, "") if out else None
    from skylimb.studies import verification

    with output.flights() as progress:
        verify = getattr(verification, suite)
        rows = verify(folder, lambda done, total, _: progress("verifying", done, total))
    bounds = {"below": "at most ", "above": "at least "}
    cells = [
        (
            row.claim,
            f"{row.measured:.5g} {row.unit}",
            f"{bounds.get(row.bound, '')}{row.theory:.5g}",
            f"{row.tolerance:g}",
            str(row.cases),
            "holds" if row.passed else "[red]FAILS[/red]",
        )
        for row in rows
    ]
    output.show_table(cells, "Claim", "Measured", "Theory", "Tolerance", "Cases", "")
    print(f"{sum(row.passed for row in rows)} of {len(rows)} claims hold")
    if folder:
        output.places(folder)
    return int(not all(row.passed for row in rows))
