"""The flights of a campaign: an SQLite file while it flies, a Parquet table when it is through.

A flight is written in one transaction, and is on the disk before the next one is handed out: SQLite keeps it
whole through a kill, a power cut and a full disk. It does not notice a bit that flips on the disk: so each
row has a digest, and one that does not fit it is flown again.
"""

from __future__ import annotations

import hashlib
import json
import sqlite3
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, closing, contextmanager
from functools import partial
from pathlib import Path
from typing import Any

from skylimb.analysis.recording import LOG_FILE, write_sources
from skylimb.base.files import replace_text, replacing
from skylimb.studies.campaign.folder import (
    STORE_FILE,
    TABLE_FILE,
    begin_folder,
    complaints,
    locked,
    log_name,
)
from skylimb.studies.campaign.frozen import Campaign
from skylimb.studies.campaign.rows import QUARANTINED, Row
from skylimb.studies.campaign.table import read_table, write_table
from skylimb.studies.campaign.worker import Flown, Job

_SCHEMA = """
CREATE TABLE IF NOT EXISTS flights (
    flight INTEGER NOT NULL,  -- index in the campaign
    gains TEXT NOT NULL,      -- changes of a search to the controller, as JSON
    status TEXT NOT NULL,     -- of the row
    row TEXT NOT NULL,        -- of the table, as JSON, behind the digest of all that stands in this line
    PRIMARY KEY (flight, gains)
) WITHOUT ROWID
"""

_PATIENCE = 60.0
"""Seconds to wait for another process that reads or writes."""

_GAINS = "gains"
"""The column that the table of a search has more than that of a campaign."""

_NO_GAINS = Job(0).key[1]

Key = tuple[int, str]
"""What a row is of: flight, and the gains of a search as JSON."""


class Store:
    """An open folder.

    Attributes:
        folder: where.
        campaign: what it is of.
        rows: of all that has flown; see `Job.key`.
        damaged: whether something that had flown cannot be read any more, and flies again.
    """

    def __init__(self, folder: Path, campaign: Campaign, database: sqlite3.Connection) -> None:
        self.folder, self.campaign, self._database = folder, campaign, database
        for half_written in folder.rglob(".*.partial"):  # by a process that was killed
            half_written.unlink(missing_ok=True)
        rows, in_table = _rows_of_table(folder, campaign)
        with self._writing():
            database.execute(_SCHEMA)
            begun, in_store = _rows(database)
            if in_store:  # by no key can a damaged row be found
                database.execute("DELETE FROM flights")
                _insert(database, begun)
            _insert(database, rows)
            # Whatever kept a flight from coming back may be over: it gets its tries again.
            database.execute("DELETE FROM flights WHERE status = ?", (QUARANTINED,))
        self.rows = _rows(database)[0]
        self.damaged = in_table or in_store

    @property
    def by_flight(self) -> dict[int, Row]:
        """The rows of a campaign, in order; a search has several rows of a flight."""
        return {flight: self.rows[flight, gains] for flight, gains in sorted(self.rows)}

    def add(self, flown: Iterable[tuple[Job, Flown]]) -> None:
        """Keep what came back: logs first, then the rows, so that a row never lacks the log it promises.

        Raises:
            OutputError: when the disk is full, for one; all that was kept before stays.
        """
        rows = {}
        for job, item in flown:
            if item.log is not None:
                self.keep_log(item.row, item.log, item.files)
            rows[job.key] = item.row
        with self._writing():
            _insert(self._database, rows)
        self.rows |= rows

    def keep_log(self, row: Row, log: bytes, files: Mapping[str, bytes]) -> None:
        """Write a flight's log under its name, and the files that belong to it, where they are missing."""
        place = self.folder / log_name(row) / LOG_FILE
        if not place.exists():
            with complaints(self.folder):
                place.parent.mkdir(parents=True, exist_ok=True)
                write_sources(files, self.folder)
                with replacing(place) as aside:
                    aside.write_bytes(log)

    def finish(self, keys: Iterable[Key], texts: Mapping[str, str]) -> None:
        """Leave the folder at rest: the table of some rows, and texts under their names, in place of SQLite.

        Args:
            keys: rows of the table.
            texts: file name -> content.
        """
        with complaints(self.folder):
            with replacing(self.folder / TABLE_FILE) as aside:
                write_table(aside, (_with_gains(key, self.rows[key]) for key in sorted(keys)), self.campaign)
            for name, text in texts.items():
                replace_text(self.folder / name, text)
            self._database.close()
            (self.folder / STORE_FILE).unlink()

    @contextmanager
    def _writing(self) -> Iterator[None]:
        """A transaction: all of it is on the disk at the end of the block, or nothing."""
        with complaints(self.folder), self._database as database:
            database.execute("BEGIN IMMEDIATE")
            yield


@contextmanager
def open_store(folder: Path, campaign: Campaign, resume: bool) -> Iterator[Store]:
    """Begin a campaign's folder, or go on with it.

    Args:
        folder: where.
        campaign: what to fly.
        resume: whether the folder may be there already.

    Raises:
        OutputError: when the folder cannot be used; see `begin_folder` and `locked`.
    """
    begin_folder(folder, campaign, resume)
    with ExitStack() as stack:
        stack.enter_context(locked(folder))
        with complaints(folder):
            database = stack.enter_context(closing(_connect(folder / STORE_FILE, "rwc")))
            store = Store(folder, campaign, database)
        yield store


def load_rows(folder: Path, campaign: Campaign) -> tuple[dict[int, Row], bool]:
    """The rows of a campaign's folder, through or not, and whether any are damaged; changes nothing."""
    found, damaged = _rows_of_table(folder, campaign)
    if (folder / STORE_FILE).is_file():
        with complaints(folder), closing(_connect(folder / STORE_FILE, "rw")) as database:
            has_begun = database.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]
            begun, in_store = _rows(database) if has_begun else ({}, False)
        found, damaged = found | begun, damaged or in_store
    return {flight: found[flight, gains] for flight, gains in sorted(found) if gains == _NO_GAINS}, damaged


def _connect(path: Path, mode: str) -> sqlite3.Connection:
    address = f"{path.absolute().as_uri()}?mode={mode}"
    database = sqlite3.connect(address, _PATIENCE, isolation_level=None, uri=True)
    database.text_factory = partial(str, encoding="utf-8", errors="replace")  # damage is for the digests
    return database


def _rows(database: sqlite3.Connection) -> tuple[dict[Key, Row], bool]:
    """The rows that are whole, and whether any are not."""
    found, damaged = dict[Key, Row](), False
    for flight, gains, status, kept in database.execute("SELECT flight, gains, status, row FROM flights"):
        digest, _, text = str(kept).partition(" ")
        if digest == _digest(flight, gains, status, text):
            found[flight, gains] = json.loads(text)
        else:
            damaged = True
    return found, damaged


def _digest(*line: Any) -> str:
    """What a line of the file has to fit."""
    return hashlib.sha256(repr(line).encode()).hexdigest()[:16]


def _line(key: Key, row: Row) -> tuple[int, str, str, str]:
    """A row as it stands in the file."""
    text = json.dumps(row, allow_nan=False)
    return (*key, row["status"], f"{_digest(*key, row['status'], text)} {text}")


def _insert(database: sqlite3.Connection, rows: Mapping[Key, Row]) -> None:
    """Add those of the rows that are not there yet."""
    database.executemany(
        "INSERT OR IGNORE INTO flights (flight, gains, status, row) VALUES (?, ?, ?, ?)",
        [_line(key, row) for key, row in rows.items()],
    )


def _rows_of_table(folder: Path, campaign: Campaign) -> tuple[dict[Key, Row], bool]:
    """The rows of a campaign that is through, and whether they are damaged."""
    rows, damaged = read_table(folder / TABLE_FILE, campaign)
    return {(row["flight"], row.pop(_GAINS, _NO_GAINS)): row for row in rows}, damaged


def _with_gains(key: Key, row: Row) -> Row:
    """A row as the table has it: that of a search says its gains."""
    return {**row, _GAINS: key[1]} if key[1] != _NO_GAINS else row
