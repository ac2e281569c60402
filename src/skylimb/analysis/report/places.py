"""Where the files of runs lie in a folder of results."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from skylimb.analysis.recording import LOG_FILE, Run
from skylimb.analysis.recording.origin import same_flight

CONFIG_FILE = "config.toml"
"""The configuration of a run, which flies it again."""

CALIBRATION_FILE = "calibration.toml"
"""What a calibration found, beside the log of its flight."""

DIFFERENCES_FILE = "differences.csv"
"""How a replay differs from the flight, beside the replayed log."""


def home(folder: Path, name: str) -> Path:
    """Where a run's own files are: the folder itself, or its subfolder in that of a comparison."""
    return folder if (folder / LOG_FILE).is_file() else folder / name


def configurations(runs: Mapping[str, Run], folder: Path) -> tuple[list[Path], list[Path]]:
    """The config.toml files beside some records: those that fly their flights again, and those that do not.

    A file that was edited, or that lies beside the record of another flight, flies something else.
    """
    ours, others = list[Path](), list[Path]()
    for name, run in runs.items():
        file = home(folder, name) / CONFIG_FILE
        if file.is_file():
            same = same_flight(file.read_text(encoding="utf-8", errors="replace"), run.config)
            (ours if same else others).append(file)
    return ours, others
