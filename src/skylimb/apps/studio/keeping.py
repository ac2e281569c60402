"""Keep live flights: the runs so far in a folder, each with the experiment that repeats it to the bit."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from skylimb.analysis.recording import Run
from skylimb.analysis.report.output import write_records, write_scores
from skylimb.analysis.report.places import CONFIG_FILE, home
from skylimb.analysis.scores.user_scores import scored
from skylimb.apps.studio.changes import settled_gains
from skylimb.apps.studio.live_flight import LiveFlight
from skylimb.base.config import write_toml
from skylimb.base.errors import ConfigError
from skylimb.base.files import first_free
from skylimb.control.controller import is_configurable
from skylimb.flight.simulated_run import simulated_run, with_origin

PRESET_FILE = "preset.toml"
"""The controller with its gains as they were in the end, to be named with --controller."""

_NAME = re.compile(r"\w(?:[\w .+-]{0,78}[\w+-])?")


@dataclass(frozen=True)
class KeptFlights:
    """What was kept.

    Attributes:
        folder: that holds it.
        commands: each repeats one of the flights.
        report: draws figures and report into the folder; it works beside this process.
    """

    folder: Path
    commands: tuple[str, ...]
    report: subprocess.Popen[bytes]

    @property
    def drawn(self) -> bool:
        """Whether the report's process has ended."""
        return self.report.poll() is not None

    def mistake(self) -> str:
        """Why the report could not be drawn, in a line; empty where it was. Waits for its process."""
        _, said = self.report.communicate()
        # 1 is a flight that was lost: its report is drawn all the same.
        return said.decode(errors="replace").strip().rpartition("\n")[2] if self.report.returncode > 1 else ""


def keep(flights: Sequence[LiveFlight], names: Sequence[str], out: Path, name: str = "") -> KeptFlights:
    """Write the flights so far into a new folder.

    A flight that is not over is kept as stopped here, and so is repeated: its experiment has `stop_at`.

    Args:
        flights: in the order of their names.
        names: of their subfolders, where there are several.
        out: folder of the new one; it is made where it is not there.
        name: of the new folder; a free number when empty.

    Raises:
        ConfigError: when the name is no plain name.
        OutputError: when the folder exists or cannot be written.
    """
    if name and not _NAME.fullmatch(name):
        raise ConfigError(
            f"name = {name!r}: letters, digits, spaces and . + - _ are allowed, at most 80, with a "
            "letter or digit in front and no space or . at the end"
        )
    folder = out / name if name else first_free(out, "kept-{}")
    runs = {
        called: replace(so_far(flight), name=called) for called, flight in zip(names, flights, strict=True)
    }
    presets = [{PRESET_FILE: preset} if (preset := preset_now(flight)) else {} for flight in flights]
    write_records(runs, folder, dict(zip(names, presets, strict=True)))
    own = {called: flight.takeoff.own for called, flight in zip(names, flights, strict=True)}
    write_scores({called: scored(run, own[called]) for called, run in runs.items()}, folder)
    configs = [home(folder, called) / CONFIG_FILE for called in names]
    # Figures take seconds and cores: another process draws them while the flights go on.
    report = subprocess.Popen(
        [sys.executable, "-m", "skylimb", "report", str(folder)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
    )
    return KeptFlights(folder, tuple(f"skylimb run {shlex.quote(str(config))}" for config in configs), report)


def so_far(flight: LiveFlight) -> Run:
    """The run of what a flight has flown, before it is scored."""
    takeoff, flown = flight.takeoff, flight.flight()
    if not flight.over:
        takeoff = takeoff.changed(replace(flight.experiment, stop_at=flight.time))
    return with_origin(simulated_run(takeoff, flown), takeoff)


def preset_now(flight: LiveFlight) -> str:
    """The flight's controller as a file, its gains as they have become; empty where it has no such keys."""
    controller = flight.takeoff.controller
    if not is_configurable(controller):
        return ""
    tables = controller.with_gains(settled_gains(flight.experiment)).tables()
    return "" if "file" in tables else write_toml(tables)
