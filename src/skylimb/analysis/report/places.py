"""Where the files of runs lie in a folder of results."""

from __future__ import annotations

from pathlib import Path

from skylimb.analysis.recording import LOG_FILE

CONFIG_FILE = "config.toml"
"""The configuration of a run, which flies it again."""

CALIBRATION_FILE = "calibration.toml"
"""What a calibration found, beside the log of its flight."""

DIFFERENCES_FILE = "differences.csv"
"""How a replay differs from the flight, beside the replayed log."""


def home(folder: Path, name: str) -> Path:
    """Where a run's own files are: the folder itself, or its subfolder in that of a comparison."""
    return folder if (folder / LOG_FILE).is_file() else folder / name
