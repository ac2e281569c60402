"""Where the files of runs lie in a folder of results."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from skylimb.analysis.recording import LOG_FILE, Run
from skylimb.analysis.recording.origin import same_flight

CONFIG_FILE = "config.toml"
"""The configuration of a run, which flies it again."""

CALIBRATION_FILE = "calibration.toml"
"""What a calibration found, beside the log of its flight."""

VIDEO_FILE = "video.mp4"

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


_MARK = "skylimb flight "


def film_mark(run: Run) -> str:
    """What a film says of the flight that it shows, in its container's comment."""
    shown = (run.log.configuration.values, run.log.time.values)
    digest = hashlib.sha256(b"".join(np.ascontiguousarray(values, "<f8").tobytes() for values in shown))
    return f"{_MARK}{digest.hexdigest()[:32]}"


def films(runs: Mapping[str, Run], folder: Path) -> tuple[dict[str, Path], list[Path]]:
    """The films beside some records: those of their flights, by name, and those that show other flights.

    A film without a mark, such as a camera's, is taken for that of the flight beside which it lies.
    """
    ours, others = dict[str, Path](), list[Path]()
    for name, run in runs.items():
        file = home(folder, name) / VIDEO_FILE
        if file.is_file():
            said = re.search(rf"{_MARK}[0-9a-f]{{32}}".encode(), file.read_bytes())
            if said is None or ("configuration" in run.log and said[0].decode() == film_mark(run)):
                ours[name] = file
            else:
                others.append(file)
    return ours, others
