"""A campaign's folder: what is in it is whole at any moment, and one coordinator at a time writes to it.

While it flies: spec.toml, journal.jsonl, logs/. When it rests: spec.toml, flights.parquet, summary.json,
report.html, logs/.
"""

from __future__ import annotations

import shutil
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from types import TracebackType

from skylimb.campaign.bench import Flown
from skylimb.campaign.disk import SPEC_FILE, full_disk, lock, replacing, write_texts
from skylimb.campaign.frozen import Campaign, campaign_from_mapping, differences
from skylimb.campaign.journal import Journal, read_journal
from skylimb.campaign.rows import QUARANTINED, Row
from skylimb.campaign.table import read_table, write_table
from skylimb.config import read_toml, write_toml
from skylimb.errors import ConfigError, OutputError
from skylimb.recording.files import new_folder

TABLE_FILE = "flights.parquet"
JOURNAL_FILE = "journal.jsonl"
SUMMARY_FILE = "summary.json"
REPORT_FILE = "report.html"
LOGS = "logs"


class Store:
    """An open folder. Use it in a `with` block.

    Attributes:
        folder: where.
        campaign: what it is of.
        rows: sound rows by flight.
        deaths: flight -> workers that it has taken down.
        damaged: how many entries were found torn or altered when it was opened.
    """

    def __init__(self, folder: Path, campaign: Campaign) -> None:
        self.folder, self.campaign = folder, campaign
        self._lock = lock(folder)
        try:
            with full_disk(folder):
                self._read()
        except BaseException:
            self._lock.close()
            raise

    def _read(self) -> None:
        stored = read_table(self.folder / TABLE_FILE, self.campaign)
        journalled = read_journal(self.folder / JOURNAL_FILE, self.campaign)
        rows = journalled.rows | stored.rows
        # Whatever kept a flight from coming back may be gone: it gets its three tries again.
        self.rows: dict[int, Row] = {f: row for f, row in rows.items() if row["status"] != QUARANTINED}
        self.deaths: Counter[int] = Counter(
            {f: n for f, n in journalled.deaths.items() if rows.get(f, {}).get("status") != QUARANTINED}
        )
        self.damaged = stored.damaged + journalled.damaged
        for stale in self.folder.glob(f"{LOGS}/.*.partial"):
            shutil.rmtree(stale, ignore_errors=True)
        self._write_journal()
        self._journal = Journal(self.folder / JOURNAL_FILE)

    def __enter__(self) -> Store:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._journal.close()
        self._lock.close()

    def add(self, flown: Sequence[Flown]) -> None:
        """Keep what came back: logs first, then the rows, so that a row never lacks the log it promises.

        Raises:
            OutputError: when the disk is full, for one; everything kept before stays readable.
        """
        with full_disk(self.folder):
            for item in flown:
                if item.log is not None:
                    self.keep_log(item.row, item.log)
            self._journal.add([item.row for item in flown])
        for item in flown:
            self.rows.setdefault(item.row["flight"], item.row)

    def add_death(self, flight: int) -> int:
        """Note that a flight took its worker down; returns how often it has."""
        with full_disk(self.folder):
            self._journal.add_death(flight)
        self.deaths[flight] += 1
        return self.deaths[flight]

    def keep_log(self, row: Row, log: bytes) -> None:
        """Write a flight's log under its name, where it is not there yet."""
        place = self.folder / log_name(row)
        if place.exists():
            return
        with full_disk(self.folder), new_folder(place) as aside:
            (aside / "log.nc").write_bytes(log)

    def settle(self) -> None:
        """Turn the journal into the table; deaths of flights that are not done yet stay journalled."""
        with full_disk(self.folder):
            if self.rows:
                with replacing(self.folder / TABLE_FILE) as aside:
                    write_table(self.rows, aside)
            self._journal.close()
            self._write_journal(rows=False)
            self._journal = Journal(self.folder / JOURNAL_FILE)

    def finish(self, texts: dict[str, str]) -> None:
        """Leave the folder at rest: the table, and the texts under their names.

        Args:
            texts: file name -> content, the summary and the report.
        """
        self.settle()
        with full_disk(self.folder):
            write_texts(self.folder, texts)
            (self.folder / LOGS).mkdir(exist_ok=True)
            (self.folder / JOURNAL_FILE).unlink(missing_ok=True)

    def _write_journal(self, rows: bool = True) -> None:
        """Write the journal anew without what was damaged, quarantined or settled."""
        path = self.folder / JOURNAL_FILE
        with replacing(path) as aside:
            aside.touch()
            journal = Journal(aside)
            if rows:
                journal.add([self.rows[flight] for flight in sorted(self.rows)])
            for flight in self.deaths.elements():
                if flight not in self.rows:
                    journal.add_death(flight)
            journal.close()


def open_store(folder: Path, campaign: Campaign, resume: bool) -> Store:
    """Begin a campaign's folder, or go on with it.

    Args:
        folder: where.
        campaign: what to fly.
        resume: whether the folder may be there already.

    Raises:
        OutputError: when the folder is there and should not be, is no campaign's, is in use, or was begun
            with something else; the message shows the difference, and nothing is touched.
    """
    if folder.exists():
        if not resume:
            hint = "; --resume goes on with it" if (folder / SPEC_FILE).is_file() else ""
            raise OutputError(f"output folder '{folder}' exists already{hint}")
        require_same(folder, campaign)
    else:
        with new_folder(folder) as aside:
            (aside / SPEC_FILE).write_text(write_toml(campaign.to_mapping()), encoding="utf-8")
            (aside / LOGS).mkdir()
    return Store(folder, campaign)


def require_same(folder: Path, campaign: Campaign) -> None:
    """Raise an `OutputError` that shows the difference unless the folder was begun with this campaign."""
    begun = load_campaign(folder)
    changes = differences(begun.to_mapping(), campaign.to_mapping())
    if changes:
        more = f"; and {len(changes) - 8} more" if len(changes) > 8 else ""
        raise OutputError(
            f"'{folder}' was begun with another campaign: {'; '.join(changes[:8])}{more}. "
            "Nothing was touched; choose another folder, or take the change back"
        )


def load_campaign(folder: Path) -> Campaign:
    """The campaign that a folder was begun with.

    Raises:
        OutputError: when it is no campaign's folder, or one of another version.
    """
    path = folder / SPEC_FILE
    if not path.is_file():
        what = f"holds no campaign (no {SPEC_FILE})" if folder.is_dir() else "does not exist"
        raise OutputError(f"campaign folder '{folder}' {what}")
    try:
        return campaign_from_mapping(read_toml(path), f"'{path}'")
    except ConfigError as error:
        raise OutputError(str(error)) from error


def load_rows(folder: Path, campaign: Campaign) -> tuple[dict[int, Row], int]:
    """The sound rows of a folder, finished or not, and how many entries were damaged; changes nothing."""
    stored = read_table(folder / TABLE_FILE, campaign)
    journalled = read_journal(folder / JOURNAL_FILE, campaign)
    return journalled.rows | stored.rows, stored.damaged + journalled.damaged


def log_name(row: Row) -> str:
    """Where a flight's log lies in the folder."""
    return f"{LOGS}/{row['flight']:06d}-{row['controller']}"


def logged(folder: Path, rows: Iterable[Row]) -> set[int]:
    """Those of the flights whose log is there."""
    return {row["flight"] for row in rows if (folder / log_name(row) / "log.nc").is_file()}
