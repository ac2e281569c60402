"""Where the files of runs lie in a folder of results."""

from __future__ import annotations

from pathlib import Path

from skylimb.analysis.recording import LOG_FILE

CONFIG_FILE = "config.toml"
"""The configuration of a run, which flies it again."""


def home(folder: Path, name: str) -> Path:
    """Where a run's own files are: the folder itself, or its subfolder in that of a comparison."""
    return folder if (folder / LOG_FILE).is_file() else folder / name
