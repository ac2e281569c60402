"""The journal of a campaign in flight: a line a flight, each whole or recognisably not.

A line is written by one call and pushed to the disk before the next flight is handed out, so that a kill or a
power cut can tear the last line and no other. Deaths of workers are journalled as well: they count on when
the campaign is resumed.
"""

from __future__ import annotations

import json
import os
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from skylimb.campaign.frozen import Campaign
from skylimb.campaign.rows import CHECKSUM, Row, checksum, is_sound

DIED = "died"


@dataclass
class Found:
    """What a journal or a table holds.

    Attributes:
        rows: sound rows by flight.
        deaths: flight -> workers that it has taken down.
        damaged: how many entries were torn or altered.
    """

    rows: dict[int, Row] = field(default_factory=dict)
    deaths: Counter[int] = field(default_factory=Counter)
    damaged: int = 0


def read_journal(path: Path, campaign: Campaign) -> Found:
    """Every sound entry; a flight that stands there twice counts once."""
    found = Found()
    if not path.is_file():
        return found
    for line in path.read_bytes().split(b"\n"):
        if not line:
            continue
        try:
            entry = json.loads(line)
        except ValueError:
            found.damaged += 1
            continue
        if isinstance(entry, dict) and DIED in entry:
            sound = entry.get(CHECKSUM) == checksum(entry) and isinstance(entry[DIED], int)
            if sound:
                found.deaths[entry[DIED]] += 1
            else:
                found.damaged += 1
        elif is_sound(campaign, entry):
            found.rows.setdefault(entry["flight"], entry)
        else:
            found.damaged += 1
    return found


class Journal:
    """Appends entries to a file that other processes may read at any time."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
        size = os.fstat(self._file).st_size
        if size and not _ends_a_line(path, size):
            # What was torn by a crash stays a line of its own, and what follows is not torn with it.
            self._write(b"\n")

    def add(self, rows: Sequence[Row]) -> None:
        """Write rows and see them to the disk.

        Raises:
            OSError: when the disk is full, for one; what was written before is whole.
        """
        self._write(b"".join(_line(row) for row in rows))

    def add_death(self, flight: int) -> None:
        """Note that a flight took its worker down."""
        entry = {DIED: flight}
        self._write(_line({**entry, CHECKSUM: checksum(entry)}))

    def close(self) -> None:
        """Let go of the file."""
        os.close(self._file)

    def _write(self, text: bytes) -> None:
        left = text
        while left:
            left = left[os.write(self._file, left) :]
        os.fsync(self._file)


def _ends_a_line(path: Path, size: int) -> bool:
    with path.open("rb") as file:
        file.seek(size - 1)
        return file.read(1) == b"\n"


def _line(entry: Mapping[str, Any]) -> bytes:
    return json.dumps(entry, separators=(",", ":"), allow_nan=False).encode() + b"\n"
