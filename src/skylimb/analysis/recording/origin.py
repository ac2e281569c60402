"""What produced a run, inside of its configuration: files with their digests, versions, and a check of both.

A run's config.toml ends with a table:

    [recorded]
    config = "SHA-256 of all the rest"
    not_repeatable = ["why this run cannot be flown again from here"]     # only where that is so
    use = ["sources/overshoot-5e6f7a8b/overshoot.py"]                     # files with metrics of one's own
    [recorded.versions]
    mujoco = "4.0.1"
    [recorded.files]
    "sources/spring-1a2b3c4d/spring.py" = "SHA-256"

The files are copies that lie in the run's folder, and the configuration names them there. So a run can be
flown again from any place, and says what has changed since.
"""

from __future__ import annotations

import hashlib
import json
import os
import tomllib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import tomli_w

from skylimb.base.errors import OutputError
from skylimb.base.files import replacing

TABLE = "recorded"
SOURCES = "sources"
"""The folder with the copies."""

_BESIDE = {"xarray", "h5netcdf", "h5py", "compiler"}
"""Versions that are recorded and decide no bit of a flight."""


def origin_text(
    tables: Mapping[str, Any],
    files: Mapping[str, bytes],
    versions: Mapping[str, str],
    problems: Sequence[str] = (),
    use: Sequence[str] = (),
) -> str:
    """The text of a run's config.toml.

    Args:
        tables: the configuration; it names files by their place in the run's folder.
        files: place of each copy -> its content.
        versions: of everything that computes.
        problems: why the run cannot be flown again, one line each.
        use: places of the files with metrics of the user's own.
    """
    recorded: dict[str, Any] = {"config": _digest_of(tables)}
    if problems:
        recorded["not_repeatable"] = list(problems)
    if use:
        recorded["use"] = list(use)
    recorded["versions"] = dict(versions)
    if files:
        recorded["files"] = {name: hashlib.sha256(files[name]).hexdigest() for name in sorted(files)}
    return tomli_w.dumps({**tables, TABLE: recorded})


def moved(text: str, prefix: str) -> str:
    """A config.toml whose copies lie in another folder: `prefix` comes before the name of each."""
    tables = tomllib.loads(text)
    recorded = tables.pop(TABLE, {})
    files = recorded.get("files", {})
    if not files:
        return text
    changed = _mapped(tables, lambda value: f"{prefix}{value}" if value in files else value)
    recorded |= {
        "config": _digest_of(changed),
        "files": {f"{prefix}{name}": digest for name, digest in files.items()},
        **({"use": [f"{prefix}{name}" for name in recorded["use"]]} if "use" in recorded else {}),
    }
    return tomli_w.dumps({**changed, TABLE: recorded})


def same_flight(text: str, recorded: str) -> bool:
    """Whether a config.toml flies what a record says flew, in a comparison's subfolder as well.

    Args:
        text: of the file.
        recorded: the configuration in the record.
    """
    tables, flown = tables_of_text(text), tables_of_text(recorded)
    return bool(flown) and (tables == flown or tables == tomllib.loads(moved(recorded, "../")))


def changes_since(tables: Mapping[str, Any], folder: Path, versions: Mapping[str, str]) -> list[str]:
    """What has changed since a run was recorded, one line each; nothing where the tables are no run's.

    Args:
        tables: of a config.toml as they stand in it.
        folder: where it lies.
        versions: of everything that computes, here and now.
    """
    recorded = tables.get(TABLE, {})
    rest = {key: value for key, value in tables.items() if key != TABLE}
    changes = []
    if recorded.get("config", "") not in ("", _digest_of(rest)):
        changes.append("its configuration was edited since it was recorded")
    for name, digest in recorded.get("files", {}).items():
        found = _file_digest(folder / name)
        if found is None:
            changes.append(f"'{name}' is missing")
        elif found != digest:
            changes.append(f"'{name}' was edited since it was recorded")
    for name, then in recorded.get("versions", {}).items():
        now = versions.get(name, "none")
        if name not in _BESIDE and now != then:
            changes.append(f"{name.replace('_', ' ')} was {then}, here it is {now}")
    return changes


def absolute(tables: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """The configuration of a run without the table of its origin, its copies named by their whole paths."""
    files = tables.get(TABLE, {}).get("files", {})
    rest = {key: value for key, value in tables.items() if key != TABLE}
    whole = Path(os.path.abspath(folder))
    return _mapped(rest, lambda value: (whole / value).as_posix() if value in files else value)


def used_files(tables: Mapping[str, Any], folder: Path) -> list[str]:
    """The files with metrics of the user's own that scored a run, by their whole paths."""
    return [Path(os.path.abspath(folder / name)).as_posix() for name in tables.get(TABLE, {}).get("use", ())]


def write_sources(files: Mapping[str, bytes], folder: Path) -> None:
    """Write the copies into a folder; a copy that is there already stays.

    Raises:
        OutputError: when a name leads out of the folder.
        OSError: when one cannot be written.
    """
    for name, content in files.items():
        path = folder / name
        if not Path(os.path.normpath(path)).is_relative_to(os.path.normpath(folder)):
            raise OutputError(f"the copy '{name}' of a run's file would lie outside of '{folder}'")
        if not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            with replacing(path) as aside:
                aside.write_bytes(content)


def read_sources(text: str, folder: Path) -> dict[str, bytes]:
    """The copies that a config.toml names, those that are there."""
    files = tables_of_text(text).get(TABLE, {}).get("files", {})
    return {name: (folder / name).read_bytes() for name in files if (folder / name).is_file()}


def tables_of_text(text: str) -> dict[str, Any]:
    """A recorded configuration as tables; none of a foreign log, which may describe itself in other words."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return {}


def _digest_of(tables: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(tables, sort_keys=True, default=str).encode()).hexdigest()


def _file_digest(path: Path) -> str | None:
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError:
        return None


def _mapped(value: Any, change: Callable[[Any], Any]) -> Any:
    """Tables with `change` applied to every text in them."""
    if isinstance(value, Mapping):
        return {key: _mapped(entry, change) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_mapped(entry, change) for entry in value]
    return change(value) if isinstance(value, str) else value
