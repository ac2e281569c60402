"""What a folder with records is: a flight, flights to compare, a calibration's, a replay's."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from skylimb.analysis.recording import Run
from skylimb.analysis.report.places import CALIBRATION_FILE, DIFFERENCES_FILE, home
from skylimb.base.errors import OutputError

_MARKS = {
    CALIBRATION_FILE: ("a calibration", "`skylimb calibrate {log}` makes its report anew"),
    DIFFERENCES_FILE: ("a replay", "nothing flew in it; `skylimb score` takes the flight that was replayed"),
}
"""By a file that no flight leaves: what the folder is, and what to do in place of scoring it."""


def other_than_flight(folder: Path) -> str:
    """What a folder with a record is where that is no flight to be scored, in words; empty for a flight."""
    return next((what for file, (what, _) in _MARKS.items() if (folder / file).is_file()), "")


def require_flights(runs: Mapping[str, Run], folder: Path) -> None:
    """Refuse to score what is no flight, and to compare flights of different experiments.

    Args:
        runs: by name.
        folder: that has their records.

    Raises:
        OutputError: saying what the folder is.
    """
    for name in runs:
        place = home(folder, name)
        for file, (what, instead) in _MARKS.items():
            if (place / file).is_file():
                log = place / "log.nc"
                raise OutputError(f"'{place}' is {what} and is not scored: {instead.format(log=log)}")
    flown: dict[str, str] = {}
    for name, run in runs.items():
        flown.setdefault(str(run.log.attrs.get("experiment", "")), name)
    if len(flown) > 1:
        named = ", ".join(f"{experiment or 'unknown'} ('{name}')" for experiment, name in flown.items())
        raise OutputError(
            f"'{folder}' holds flights of different experiments, which are not compared: {named}; name the "
            "folder of one of them"
        )
