"""The table of a campaign as a Parquet file: the same rows give the same bytes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from skylimb.campaign.frozen import Campaign
from skylimb.campaign.journal import Found
from skylimb.campaign.rows import Row, is_sound

ROW_GROUP = 256
"""Rows that are stored together: as many are flown again when a part of the file cannot be read."""


def table_of(rows: dict[int, Row]) -> pa.Table:
    """Rows as an Arrow table, in the order of the flights.

    A column's type follows from its values, which are all of one kind; see `skylimb.campaign.rows`.
    """
    ordered = [rows[flight] for flight in sorted(rows)]
    names = list(ordered[0]) if ordered else []
    return pa.table({name: _column([row[name] for row in ordered]) for name in names})


def _column(values: list[Any]) -> pa.Array:
    kinds = {type(value) for value in values} - {type(None)}
    if not kinds:
        return pa.nulls(len(values), pa.float64())
    if len(kinds) > 1:
        raise TypeError(f"a column holds {sorted(kind.__name__ for kind in kinds)}")
    return pa.array(
        values, {int: pa.int64(), float: pa.float64(), bool: pa.bool_(), str: pa.string()}[kinds.pop()]
    )


def write_table(rows: dict[int, Row], path: Path) -> None:
    """Write the table; `path` is a place aside, to be renamed by the caller."""
    pq.write_table(
        table_of(rows), path, row_group_size=ROW_GROUP, compression="zstd", write_page_checksum=True
    )


def read_table(path: Path, campaign: Campaign) -> Found:
    """Every sound row of a table; what cannot be read or was altered is counted as damaged."""
    found = Found()
    if not path.is_file():
        return found
    try:
        file = pq.ParquetFile(path, page_checksum_verification=True)
    except (pa.ArrowException, OSError):
        found.damaged = 1
        return found
    with file:
        for group in range(file.num_row_groups):
            try:
                rows = file.read_row_group(group).to_pylist()
            except (pa.ArrowException, OSError):
                found.damaged += file.metadata.row_group(group).num_rows
                continue
            for row in rows:
                if is_sound(campaign, row):
                    found.rows.setdefault(row["flight"], row)
                else:
                    found.damaged += 1
    return found
