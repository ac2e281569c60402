"""The verb that looks after the folders of flights: `runs`."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

from skylimb.apps.cli import output
from skylimb.apps.cli.arguments import arg
from skylimb.base.errors import OutputError


def runs(
    folder: Annotated[str, arg("Where to look, and in what lies below.", "DIR")] = "out",
    *,
    clean: Annotated[bool, arg("Whether to clear away what killed processes left.")] = False,
) -> None:
    """List the flights below a folder: how each ended, what failed after it, and what killed processes left.

    With --clean, what a killed process had written aside is removed; where it holds a whole record, it is
    kept as NAME-interrupted instead. What a process still writes, also on another machine, is left alone.

    Examples:
        skylimb runs
        skylimb runs out/tuesday --clean
    """
    from skylimb.base.files import orphans

    home = Path(folder)
    if not home.is_dir():
        raise OutputError(f"folder '{folder}' does not exist")
    left = orphans(home)
    rows = [(str(place), _state(place)) for place in sorted(_records(home))]
    if rows:
        output.show_table(rows, "Run", "State")
        print("`skylimb score FOLDER` scores a run or a comparison, and makes anew what failed")
    for path, name in left:
        done = _cleared(path, name) if clean else "`skylimb runs --clean` clears it away"
        print(f"{path}: left by a process that was killed; {done}")
    if not rows and not left:
        print(f"no flight below '{folder}'")


def _records(home: Path) -> Iterator[Path]:
    """Every folder at or below one that holds a record or says what failed; none that is still written."""
    from skylimb.analysis.recording import LOG_FILE
    from skylimb.analysis.report.attempts import FAILED_FILE

    for place, folders, files in os.walk(home):
        folders[:] = [name for name in folders if not name.startswith(".")]
        if {LOG_FILE, FAILED_FILE} & {*files}:
            yield Path(place)


def _state(place: Path) -> str:
    """How a flight ended, and what could not be made afterwards; of a comparison's folder only the latter."""
    from skylimb.analysis.recording import LOG_FILE
    from skylimb.analysis.report.attempts import marked_failed
    from skylimb.analysis.report.folder_kinds import other_than_flight
    from skylimb.analysis.report.output import METRICS_FILE

    failed = marked_failed(place)
    if not (place / LOG_FILE).is_file():
        return "; ".join(failed)
    if other := other_than_flight(place):
        return "; ".join([other, *failed])
    try:
        found = json.loads((place / METRICS_FILE).read_text("utf-8"))
    except FileNotFoundError:
        return "not scored"
    except (OSError, ValueError):
        return f"{METRICS_FILE} cannot be read"
    state = found.get("cause") or ("not done as commanded" if found.get("missed") else "finished")
    return "; ".join([f"{found['status']}, {state}", *failed])


def _cleared(path: Path, name: str) -> str:
    """Remove what a killed process left, or give it a name where it holds a whole record; which of them."""
    from skylimb.analysis.recording import load_runs
    from skylimb.base.files import interrupted_name, rename_new

    inside = path / name
    recorded = [*inside.rglob("*.mcap")]  # as it was flown; whole up to the last chunk
    try:
        if not recorded:
            load_runs(inside)
    except OutputError:
        shutil.rmtree(path) if path.is_dir() else path.unlink()
        return "removed"
    place = interrupted_name(path.with_name(name))
    rename_new(inside, place)
    path.rmdir()
    return f"kept as '{place}'" + "; `skylimb convert FILE.mcap LOG.nc` reads it" * bool(recorded)
