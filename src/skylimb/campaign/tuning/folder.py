"""A search's folder: every flight is kept as it comes, and what was found stands beside it at the end."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType

from skylimb.campaign.bench import Job
from skylimb.campaign.disk import SPEC_FILE, full_disk, lock, replacing
from skylimb.campaign.frozen import Campaign
from skylimb.campaign.journal import Journal
from skylimb.campaign.rows import CHECKSUM, QUARANTINED, Row, checksum
from skylimb.campaign.store import require_same
from skylimb.config import write_toml
from skylimb.errors import OutputError
from skylimb.recording.files import new_folder

FLIGHTS_FILE = "flights.jsonl"
"""A line a flight: gains, row and checksum."""


class Memory:
    """The flights of a search. Use it in a `with` block.

    Attributes:
        folder: where they are kept.
        rows: by job.
        damaged: how many entries were found torn or altered when it was opened.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.rows: dict[Job, Row] = {}
        self.damaged = 0
        self._lock = lock(folder)
        try:
            with full_disk(folder):
                self._read()
                self._rewrite()
                self._journal = Journal(folder / FLIGHTS_FILE)
        except BaseException:
            self._lock.close()
            raise

    def __enter__(self) -> Memory:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._journal.close()
        self._lock.close()

    def add(self, rows: Mapping[Job, Row]) -> None:
        """Keep flights, and see them to the disk.

        Raises:
            OutputError: when the disk is full, for one; everything kept before stays readable.
        """
        with full_disk(self.folder):
            self._journal.add([_entry(job, row) for job, row in rows.items()])
        self.rows.update(rows)

    def _read(self) -> None:
        path = self.folder / FLIGHTS_FILE
        for line in path.read_bytes().split(b"\n") if path.is_file() else ():
            if not line:
                continue
            try:
                entry = json.loads(line)
                row, sound = entry["row"], entry[CHECKSUM] == checksum(entry)
                job = Job(row["flight"], tuple((key, value) for key, value in entry["gains"]))
            except (ValueError, TypeError, KeyError):
                self.damaged += 1
                continue
            if not sound:
                self.damaged += 1
            elif row["status"] != QUARANTINED:  # whatever killed its worker may be gone
                self.rows.setdefault(job, row)

    def _rewrite(self) -> None:
        with replacing(self.folder / FLIGHTS_FILE) as aside:
            aside.touch()
            journal = Journal(aside)
            journal.add([_entry(job, row) for job, row in self.rows.items()])
            journal.close()


def open_memory(folder: Path, campaign: Campaign, resume: bool) -> Memory:
    """Begin a search's folder, or go on with it.

    Raises:
        OutputError: when the folder is there and should not be, is no search's, is in use, or was begun with
            something else; the message shows the difference, and nothing is touched.
    """
    if folder.exists():
        begun = (folder / FLIGHTS_FILE).is_file()
        if not resume:
            hint = "; --resume goes on with it" if begun else ""
            raise OutputError(f"output folder '{folder}' exists already{hint}")
        if not begun:
            raise OutputError(f"folder '{folder}' holds no search (it has no {FLIGHTS_FILE})")
        require_same(folder, campaign)
    else:
        with new_folder(folder) as aside:
            (aside / SPEC_FILE).write_text(write_toml(campaign.to_mapping()), encoding="utf-8")
            (aside / FLIGHTS_FILE).touch()
    return Memory(folder)


def _entry(job: Job, row: Row) -> Row:
    entry = {"gains": [list(pair) for pair in job.gains], "row": row}
    return {**entry, CHECKSUM: checksum(entry)}
