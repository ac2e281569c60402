"""The table of a campaign as a Parquet file: the same rows give the same bytes."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from skylimb.base.errors import missing_extra
from skylimb.studies.campaign.frozen import Campaign
from skylimb.studies.campaign.rows import Row

try:
    import pyarrow as pa
    import pyarrow.parquet as pq
except ImportError:
    raise missing_extra("pyarrow") from None

ROW_GROUP = 256
"""Rows that are stored together."""

_DIGEST = b"skylimb"
"""Under this name the file has the digest of its campaign and its rows."""

_TYPES = {int: pa.int64(), float: pa.float64(), bool: pa.bool_(), str: pa.string()}


def write_table(path: Path, rows: Iterable[Row], campaign: Campaign) -> None:
    """Write rows, in the order given.

    A column's type follows from its values, which are all of one kind; see `skylimb.studies.campaign.rows`.
    """
    ordered = list(rows)
    names = list(ordered[0]) if ordered else []
    table = pa.table({name: _column(name, [row[name] for row in ordered]) for name in names})
    table = table.replace_schema_metadata({_DIGEST: _digest(campaign, ordered)})
    pq.write_table(table, path, row_group_size=ROW_GROUP, compression="zstd", write_page_checksum=True)


def _column(name: str, values: list[Any]) -> pa.Array:
    kinds = {type(value) for value in values} - {type(None)}
    if len(kinds) > 1:
        raise TypeError(f"column '{name}' holds {sorted(kind.__name__ for kind in kinds)}")
    return pa.array(values, _TYPES[kinds.pop()] if kinds else pa.float64())


def _digest(campaign: Campaign, rows: Sequence[Row]) -> bytes:
    text = json.dumps([campaign.to_mapping(), rows], sort_keys=True, default=repr)
    return hashlib.sha256(text.encode()).hexdigest().encode()


def read_table(path: Path, campaign: Campaign) -> tuple[list[Row], bool]:
    """The rows of a table, and whether it is damaged; no file is an empty table.

    Where the file cannot be read, or holds something else than was written for this campaign, nothing in it
    can be trusted.
    """
    if not path.is_file():
        return [], False
    try:
        table = pq.read_table(path, page_checksum_verification=True)
        rows, digest = table.to_pylist(), (table.schema.metadata or {}).get(_DIGEST)
    except (pa.ArrowException, OSError, UnicodeDecodeError):
        return [], True
    return (rows, False) if digest == _digest(campaign, rows) else ([], True)
