"""A run whole as messages: what is not a row of signals once in front, then one row a tick.

    /skylimb/record   the log with its first row alone, as NetCDF: names, units, frames, configuration, scores
    /skylimb/source   a copy of a file that produced the run
    /skylimb/row      all signals of a tick, as 64-bit numbers

So a bag or an MCAP file gives back the run to the bit, while the topics of the lab, in 32 bits where the lab
has 32 bits, stand beside it for everybody's tools.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from skylimb.analysis.exchange.lab_topics import RECORD, ROW, SOURCE, Topic
from skylimb.analysis.recording.run import STOPPED, Run
from skylimb.base.errors import OutputError
from skylimb.base.packing import Layout

if TYPE_CHECKING:
    import xarray as xr


TICKS = "ticks"
"""Attribute of a record: how many rows follow it."""


def record_messages(run: Run) -> Iterator[tuple[Topic, dict[str, Any]]]:
    """Topic and fields of everything but the rows."""
    skeleton = dataclasses.replace(run, log=run.log.isel(time=slice(0)))
    if run.log.sizes["time"]:  # one that is still flown has none yet
        skeleton = dataclasses.replace(
            skeleton, log=skeleton.log.assign_attrs({TICKS: run.log.sizes["time"]})
        )
    for topic, name, content in (
        (RECORD, "log.nc", skeleton.content()),
        *((SOURCE, *source) for source in run.sources.items()),
    ):
        dimension = {"label": name, "size": len(content), "stride": 1}
        yield topic, {"layout.dim": [dimension], "data": content}


class RowMessages:
    """The messages of a flight that is not over yet.

    Args:
        run: without rows; it has all signals.
        layout: where each of them stands in a row as it is flown.

    Attributes:
        begin: topic and fields of everything but the rows.
    """

    def __init__(self, run: Run, layout: Layout[Any]) -> None:
        self.begin = list(record_messages(run))
        names = row_names(run.log)[1:]
        self._order = np.concatenate([np.arange(layout.size)[layout.slices[name]] for name in names])

    def row(self, time: float, flown: np.ndarray) -> tuple[Topic, dict[str, Any]]:
        """Topic and fields of a tick: its time since take-off, s, and its row as it was flown."""
        return ROW, {"data": np.concatenate([[time], flown[self._order]])}


def row_names(log: xr.Dataset) -> list[str]:
    """What a row holds, in this order: time, then every number over time."""
    signals = [str(name) for name in log.data_vars if "time" in log[name].dims]
    return ["time", *(name for name in signals if log[name].dtype.kind in "fiub")]


def row_table(log: xr.Dataset) -> np.ndarray:
    """Every row, (ticks, width)."""
    count = log.sizes["time"]
    columns = (log[name].transpose("time", ...).values.reshape(count, -1) for name in row_names(log))
    return np.concatenate([np.asarray(column, dtype=float) for column in columns], axis=1)


def run_of(record: bytes, rows: np.ndarray, sources: Mapping[str, bytes], called: str) -> Run:
    """The run of a record and its rows; one that lacks rows is as if stopped: it is not judged.

    Args:
        record: content of the message on `RECORD`.
        rows: of those on `ROW`, (ticks, width).
        sources: copies of files, by name.
        called: what messages call it.

    Raises:
        OutputError: when the rows are not those of the record.
    """
    import xarray as xr

    run = Run.of_content(record, called)
    log, at, filled = run.log, 0, dict[str, Any]()
    for name in row_names(log):
        was = log.variables[name]
        dims = ("time", *(str(dim) for dim in was.dims if dim != "time"))
        shape = tuple(log.sizes[dim] for dim in dims[1:])
        width = int(np.prod(shape, dtype=int))
        values = rows[:, at : at + width]
        if values.shape[1] != width:
            raise OutputError(f"'{called}': a row has {rows.shape[1]} numbers, its record asks for more")
        filled[name] = xr.Variable(
            dims, values.reshape(len(rows), *shape).astype(was.dtype), was.attrs
        ).transpose(*was.dims)
        at += width
    if at != rows.shape[1]:
        raise OutputError(f"'{called}': a row has {rows.shape[1]} numbers, its record asks for {at}")
    variables = {
        name: filled.get(str(name), variable)
        for name, variable in log.variables.items()
        if str(name) in filled or "time" not in variable.dims
    }
    coords = {name: variables.pop(name) for name in list(variables) if name in log.coords}
    ticks, metrics = int(log.attrs.pop(TICKS, len(rows))), run.metrics
    if len(rows) < ticks:
        if not run.failed:
            cause = f"lacks ticks, as its log was cut off or has gaps: {len(rows)} of {ticks} are there"
            log.attrs.update(status=STOPPED, cause=cause)
        metrics = {}  # those of all its ticks
    whole = xr.Dataset(variables, coords, log.attrs)
    return dataclasses.replace(run, log=whole, metrics=metrics, sources=dict(sources))


def content_of(message: Any) -> tuple[str, bytes]:
    """Name and content of a message with bytes."""
    return message.layout.dim[0].label, np.asarray(message.data, dtype=np.uint8).tobytes()
