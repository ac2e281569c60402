"""The files of a campaign's folder, which others may read at any time and one process at a time writes.

While it flies: spec.toml, flights.sqlite, logs/. When it is through: spec.toml, flights.parquet,
summary.json, report.html, logs/.
"""

from __future__ import annotations

import errno
import sqlite3
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

from skylimb.analysis.recording import LOG_FILE
from skylimb.base.config import read_toml, write_toml
from skylimb.base.errors import ConfigError, OutputError
from skylimb.base.files import new_folder
from skylimb.studies.campaign.digests import changed_files
from skylimb.studies.campaign.frozen import Campaign, campaign_from_mapping, differences

SPEC_FILE = "spec.toml"
"""The spec with all that it resolved to; the file that is locked."""

STORE_FILE = "flights.sqlite"
TABLE_FILE = "flights.parquet"
SUMMARY_FILE = "summary.json"
REPORT_FILE = "report.html"
LOGS = "logs"
CONFIG_FILE = "config.toml"
"""Beside each log: flies the flight again."""


def begin_folder(folder: Path, campaign: Campaign, resume: bool) -> None:
    """Make a campaign's folder, or see that it was begun with the same campaign.

    Raises:
        OutputError: when the folder is there and should not be, is no campaign's, or was begun with something
            else; the message shows the difference, and nothing is touched.
    """
    if not folder.exists():
        with new_folder(folder) as aside:
            (aside / SPEC_FILE).write_text(write_toml(campaign.tables), encoding="utf-8")
        return
    if not resume:
        hint = "; --resume goes on with it" if (folder / SPEC_FILE).is_file() else ""
        raise OutputError(f"output folder '{folder}' exists already{hint}")
    begun = load_campaign(folder)
    changes = differences(begun.to_mapping(), campaign.to_mapping())
    if changes:
        more = f"; and {len(changes) - 8} more" if len(changes) > 8 else ""
        more += changed_files(begun.read)
        raise OutputError(
            f"'{folder}' was begun with another campaign: {'; '.join(changes[:8])}{more}. "
            "Nothing was touched; choose another folder, or take the change back"
        )


def load_campaign(folder: Path) -> Campaign:
    """The campaign that a folder was begun with.

    Raises:
        OutputError: when it is no campaign's folder, or one of another format.
    """
    path = folder / SPEC_FILE
    if not path.is_file():
        what = f"holds no campaign (no {SPEC_FILE})" if folder.is_dir() else "does not exist"
        raise OutputError(f"campaign folder '{folder}' {what}")
    try:
        return campaign_from_mapping(read_toml(path), f"'{path}'")
    except ConfigError as error:
        raise OutputError(str(error)) from error


def log_name(row: Mapping[str, Any]) -> str:
    """Where a flight's log lies in the folder."""
    return f"{LOGS}/{row['flight']:06d}-{row['controller']}"


def logged(folder: Path, rows: Iterable[Mapping[str, Any]]) -> set[int]:
    """Those of the flights whose log is there."""
    return {row["flight"] for row in rows if (folder / log_name(row) / LOG_FILE).is_file()}


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Keep other coordinators out while this process lives; the system opens the lock at its end.

    Raises:
        OutputError: when another process has it, or the folder cannot be written.
    """
    with complaints(folder):
        file = (folder / SPEC_FILE).open("ab")
    with file:
        try:
            _lock(file)
        except OSError:
            raise OutputError(f"campaign folder '{folder}' is in use by another process") from None
        yield


def _lock(file: IO[bytes]) -> None:
    if sys.platform == "win32":
        import msvcrt

        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
    else:
        import fcntl

        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


@contextmanager
def complaints(folder: Path) -> Iterator[None]:
    """Turn the system's complaints into one line that says what is kept.

    Raises:
        OutputError: for every OSError and every error of SQLite within.
    """
    try:
        yield
    except (OSError, sqlite3.Error) as error:
        if getattr(error, "sqlite_errorname", "") in ("SQLITE_CORRUPT", "SQLITE_NOTADB"):
            raise OutputError(
                f"'{folder / STORE_FILE}' is damaged ({error}): move it away, and --resume flies anew"
            ) from error
        full = (errno.ENOSPC, errno.EDQUOT)
        is_full = getattr(error, "errno", None) in full or "disk is full" in str(error)
        what = "the disk is full" if is_full else getattr(error, "strerror", None) or str(error)
        raise OutputError(
            f"cannot write to '{folder}': {what}; what was flown is kept there, and --resume goes on"
        ) from error
