"""One flight's record: every signal under its own name, with units and frames, and what produced it."""

from __future__ import annotations

import dataclasses
import io
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, TypeVar

from skylimb.analysis.recording.netcdf import netcdf_bytes, read_netcdf
from skylimb.analysis.recording.origin import moved, read_sources, tables_of_text
from skylimb.base.errors import OutputError, unknown_key, unknown_name
from skylimb.base.files import new_file, readable

if TYPE_CHECKING:
    import xarray as xr

FORMAT = "skylimb run"
_MOST_UNPACKED = 4 * 10**9
"""Bytes of a record in memory at most: twice the longest flight that may be flown."""
FORMAT_VERSION = 1
"""Raised when a file that this version writes could no longer be read by the one before."""

LOG_FILE = "log.nc"
"""The name of the record inside a run's folder."""

NOTES = "notes"
"""Attribute of a log, and entry of the scores' file: what has to be said of the run."""

PROBLEMS = "problems"
"""Of a run's metrics: why a user's metric has no number, by the metric's name."""

OK = "OK"
"""Status of a flight that came to its mission's end."""
STOPPED = "STOPPED"
"""Status of a flight that its experiment has stopped (`stop_at`): it is scored as far as it flew."""
UNFINISHED = "UNFINISHED"
"""Status of a flight whose controller held its mission back until all its time was over; it still flew."""
FAILED = "FAILED"
"""Status of a flight that was lost: it crashed or diverged, or its controller's own code failed."""

_OWN_ATTRIBUTES = ("format", "name", "metrics")


class Metrics(dict[str, Any]):
    """A run's figures of merit by name; one that is not there is named with the nearest.

    Args:
        numbers: by name.
        of: whose they are, as in "hybrid (OK)".
    """

    def __init__(self, numbers: Mapping[str, Any], of: str) -> None:
        super().__init__(numbers)
        self._of = of

    def __missing__(self, name: object) -> Any:
        """Raise an `UnknownKeyError` with the nearest name."""
        raise unknown_key(f"metric of run {self._of}", name, self)


@dataclass(frozen=True, repr=False)
class Run:
    """A recorded flight, simulated or real.

    Attributes:
        name: what the run is called among others; by default its controller.
        controller: the name of the controller that flew.
        log: signals over `time` (s), with named axes; each variable's attributes hold `units` (SI), `frame`,
            `long_name` and `kind` (truth, estimate, reference, command or measurement). The dataset's
            attributes hold `status`, `cause`, `seed`, `config` (the resolved configuration as TOML),
            `config_units` (JSON), `versions` (JSON) and `scene` (what a viewer needs).
        metrics: the figures of merit, see `skylimb.analysis.scores.metrics`; empty before the flight is
            scored.
        sources: copies of the files that produced it, by the name that `config` has for each; they are
            written beside the record (`write_run`), not into it.
        file: from which it was read; None for one that was not.
        twin: the same flight without its events, where one was flown: what it moves by itself is no event's
            doing.
    """

    name: str
    controller: str
    log: xr.Dataset
    metrics: Mapping[str, Any] = field(default_factory=dict)
    sources: Mapping[str, bytes] = field(default_factory=dict)
    file: Path | None = field(default=None, compare=False)
    twin: Run | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        if isinstance(self.metrics, dict):  # one that is to be read alone stays as it is
            object.__setattr__(self, "metrics", Metrics(self.metrics, f"{self.name} ({self.status})"))

    @property
    def status(self) -> str:
        """How it ended: `OK`, `STOPPED`, `UNFINISHED` or `FAILED`."""
        return str(self.log.attrs.get("status", OK))

    @property
    def cause(self) -> str:
        """Why a flight ended before its time, in one line; empty for one that did not."""
        return str(self.log.attrs.get("cause", ""))

    @property
    def failed(self) -> bool:
        """Whether it did not come to its mission's end, and nobody wanted that: lost, or not finished."""
        return self.status not in (OK, STOPPED)

    @property
    def lost(self) -> bool:
        """Whether it was lost: it crashed or diverged, or its controller's own code failed."""
        return self.failed and self.status != UNFINISHED

    @property
    def mark(self) -> str:
        """What stands behind the name of a flight that failed: failed or unfinished; empty for any other."""
        return ("failed" if self.lost else "unfinished") if self.failed else ""

    @property
    def stopped(self) -> bool:
        """Whether it was stopped on purpose; it is scored as far as it flew, and not judged."""
        return self.status == STOPPED

    @property
    def done(self) -> bool | None:
        """Whether the flight did what was commanded, within its experiment's tolerances.

        None where nothing was commanded that could be judged, or the flight is not scored.
        """
        return self.metrics.get("done")

    @property
    def missed(self) -> list[str]:
        """What the flight did not do as commanded, and by how much; empty where it missed nothing."""
        return list(self.metrics.get("missed", []))

    @property
    def problems(self) -> dict[str, str]:
        """Why a user's metric could not be computed, by what failed; empty where all could."""
        return dict(self.metrics.get(PROBLEMS, {}))

    @property
    def config(self) -> str:
        """The resolved configuration as TOML text."""
        return str(self.log.attrs.get("config", ""))

    @property
    def tables(self) -> dict[str, Any]:
        """The same as tables; none where a foreign log describes itself in other words."""
        return tables_of_text(self.config)

    @property
    def config_units(self) -> dict[str, str]:
        """Unit of every value of the configuration that has one, by dotted key."""
        return dict(json.loads(self.log.attrs.get("config_units", "") or "{}"))

    @property
    def versions(self) -> dict[str, str]:
        """What produced the run, by package."""
        return dict(json.loads(self.log.attrs.get("versions", "") or "{}"))

    @property
    def notes(self) -> tuple[str, ...]:
        """What whoever reads or repeats the run has to know, one line each.

        What had changed since the run that it repeats, why it cannot be repeated itself, and what its numbers
        do not show.
        """
        return tuple(json.loads(self.log.attrs.get(NOTES, "") or "[]"))

    @property
    def verdict(self) -> str:
        """How the flight ended, and whether it did what was commanded, in a line."""
        if self.failed or self.stopped:
            return f"{self.status}: {self.cause}"
        if self.missed:
            return f"finished, not done as commanded: {'; '.join(self.missed)}"
        return "done as commanded" if self.done else "finished"

    def numbers(self) -> dict[str, str]:
        """The scores that are numbers, by name, to four digits."""
        kept = {name: value for name, value in self.metrics.items() if isinstance(value, int | float)}
        return {name: f"{value:.4g}" for name, value in kept.items() if not isinstance(value, bool)}

    def __repr__(self) -> str:
        """Status, controller and experiment, the first scores, and where the record is; five lines."""
        experiment = self.log.attrs.get("experiment", "unknown")
        seconds = self.log.time.values if "time" in self.log else [0.0]
        scores = [f"{name} = {value}" for name, value in list(self.numbers().items())[:4]]
        return "\n".join(
            [
                f"Run '{self.name}': {self.status}; {self.verdict.removeprefix(f'{self.status}: ')}",
                f"  controller {self.controller or 'unknown'}, experiment {experiment}",
                f"  scores: {', '.join(scores) or 'none'}",
                f"  log: {len(self.log.data_vars)} signals over {seconds[-1] - seconds[0]:.2f} s",
                f"  file: {self.file or 'not written; run.save(...) writes one'}",
            ]
        )

    def signal(self, name: str) -> xr.DataArray:
        """The signal called `name`.

        Raises:
            UnknownNameError: with the nearest name, if nothing of that name was recorded.
        """
        if name not in self.log.variables:
            raise unknown_name("signal", name, [str(known) for known in self.log.data_vars])
        return self.log[name]

    def save(self, path: str | Path) -> Path:
        """Write the run as one compressed NetCDF-4 file; numbers keep every bit.

        Args:
            path: a file that doesn't exist yet. It appears under this name only when it is complete.

        Returns:
            The path written.

        Raises:
            OutputError: if the file exists or cannot be written, or a signal is neither number nor word.
        """
        content = self.content()
        with new_file(path) as aside:
            aside.write_bytes(content)
        return Path(path)

    def content(self) -> bytes:
        """The bytes of the file that `save` writes.

        Raises:
            OutputError: when a signal is neither number nor word.
        """
        log = self.log.assign_attrs(
            format=FORMAT,
            format_version=FORMAT_VERSION,
            name=self.name,
            controller=self.controller,
            metrics=json.dumps(dict(self.metrics), allow_nan=False),
        )
        try:
            return netcdf_bytes(log)
        except TypeError as error:
            raise OutputError(f"cannot write a file of run '{self.name}': {error}") from error

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a run back, from its file or from the folder that holds its log.nc.

        Raises:
            OutputError: if there is no such file, or it is not a run of this format.
        """
        path = Path(path)
        file = path / LOG_FILE if path.is_dir() else path
        run = cls._of(_dataset(file, str(file)))
        return dataclasses.replace(run, sources=read_sources(run.config, file.parent), file=file)

    @classmethod
    def of_content(cls, content: bytes, called: str) -> Self:
        """The run whose `content` this is, without copies of its files.

        Args:
            content: of a run's file.
            called: what messages call it.

        Raises:
            OutputError: if it is not a run of this format.
        """
        return cls._of(_dataset(io.BytesIO(content), called))

    @classmethod
    def _of(cls, log: xr.Dataset) -> Self:
        own = {name: log.attrs.pop(name, None) for name in _OWN_ATTRIBUTES}
        controller = str(log.attrs.get("controller", ""))
        return cls(
            name=str(own["name"] or controller),
            controller=controller,
            log=log,
            metrics=json.loads(own["metrics"] or "{}"),
        )

    def with_sources_at(self, prefix: str) -> Self:
        """The same run for a folder in which `prefix`, such as "../", leads to the copies of its files."""
        log = self.log.assign_attrs(config=moved(self.config, prefix))
        files = {f"{prefix}{name}": content for name, content in self.sources.items()}
        return dataclasses.replace(self, log=log, sources=files)


AnyRun = TypeVar("AnyRun", bound=Run)
"""A run of whatever class; what is made of it is of the same."""


def _dataset(source: Path | io.BytesIO, path: str) -> xr.Dataset:
    """The dataset of a run's file, or of its bytes; `path` is what messages call it."""
    with readable(source, "NetCDF-4 file", path) as file:
        log = read_netcdf(file, _MOST_UNPACKED)
    if log.attrs.get("format") != FORMAT:
        raise OutputError(f"'{path}' is a NetCDF file but not a {FORMAT} (no attribute format = '{FORMAT}')")
    version = int(log.attrs.get("format_version", 0))
    if version > FORMAT_VERSION:
        raise OutputError(
            f"'{path}' has format version {version}, skylimb here reads up to {FORMAT_VERSION}: update it"
        )
    return log


def lines_of_runs(lines: Mapping[str, Iterable[str]]) -> tuple[str, ...]:
    """What is said of some runs, each line once; in front the runs that it is of, where not of all.

    Args:
        lines: by the name of a run.
    """
    of: dict[str, list[str]] = {}
    for name, said in lines.items():
        for line in dict.fromkeys(said):
            of.setdefault(line, []).append(name)
    return tuple(
        line if len(names) == len(lines) else f"{', '.join(names)}: {line}" for line, names in of.items()
    )
