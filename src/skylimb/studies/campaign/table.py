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
    raise missing_extra("pyarrow", "campaign") from None

ROW_GROUP = 256
"""Rows that are stored together: as many are flown again when a part of the file cannot be read."""

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


def read_table(path: Path, campaign: Campaign) -> tuple[list[Row], int]:
    """The sound rows of a table, and how many are damaged; no file is an empty table.

    A part of the file that cannot be read is left out. Where all can be read, and is not what was written for
    this campaign, nothing in the file can be trusted.
    """
    if not path.is_file():
        return [], 0
    rows: list[Row] = []
    damaged = 0
    try:
        with pq.ParquetFile(path, page_checksum_verification=True) as file:
            for group in range(file.num_row_groups):
                try:
                    rows += file.read_row_group(group).to_pylist()
                except (pa.ArrowException, OSError):
                    damaged += file.metadata.row_group(group).num_rows
            digest = (file.schema_arrow.metadata or {}).get(_DIGEST)
    except (pa.ArrowException, OSError, UnicodeDecodeError):
        return [], 1
    if not damaged and digest != _digest(campaign, rows):
        return [], len(rows)
    return rows, damaged
