"""Reading back a folder that a run or a comparison left."""

from __future__ import annotations

import csv
from pathlib import Path

from skylimb.analysis.recording.run import LOG_FILE, AnyRun, Run
from skylimb.base.errors import OutputError


def load_runs(folder: str | Path, kind: type[AnyRun] = Run) -> dict[str, AnyRun]:
    """Every run in `folder`, by name: the folder's own log.nc, or one in each of its subfolders.

    A comparison's order is kept (metrics.csv lists it); other subfolders come by name.

    Raises:
        OutputError: if the folder doesn't exist, holds no run, or a run cannot be read.
    """
    folder = Path(folder)
    if not folder.is_dir():
        what = "is a file, not a folder" if folder.exists() else "does not exist"
        raise OutputError(f"run folder '{folder}' {what}")
    if (folder / LOG_FILE).is_file():
        run = kind.load(folder)
        return {run.name: run}
    try:
        found = sorted(
            path.parent for path in folder.glob(f"*/{LOG_FILE}") if not path.parent.name.startswith(".")
        )
    except OSError as error:
        raise OutputError(f"cannot read run folder '{folder}': {error.strerror or error}") from error
    if not found:
        raise OutputError(f"folder '{folder}' holds no run (no {LOG_FILE} in it or one level below)")
    order = _listed(folder / "metrics.csv")
    found.sort(key=lambda path: order.index(path.name) if path.name in order else len(order))
    return {path.name: kind.load(path) for path in found}


def _listed(table: Path) -> list[str]:
    """The first column of a comparison's table: its runs in the order in which they flew."""
    if not table.is_file():
        return []
    with table.open(encoding="utf-8", newline="") as file:
        return [row[0] for row in csv.reader(file) if row][1:]
