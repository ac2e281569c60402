"""The folder of flights that are still to be flown: each record is on the disk before it is scored."""

from __future__ import annotations

import tempfile
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType

from skylimb.analysis.recording import Run
from skylimb.analysis.report.output import record, write_records
from skylimb.base.errors import OutputError
from skylimb.base.files import first_free, interrupted_name, rename_new, require_new, staging, writing


class KeptFlights:
    """Takes records as flights end. The folder has its name as soon as the last one is in it.

    When the block is left before that, by Ctrl-C or by an error, what was flown is kept in
    FOLDER-interrupted, and a note on the exception says so. Where the disk has no room, a record goes to the
    folder for temporary files.

        with KeptFlights(folder, 1) as kept:
            run = skylimb.run("paper", keep=kept.keep)

    Args:
        folder: must not exist.
        count: of the flights.
        apart: whether each has a subfolder of its name, as in a comparison.

    Raises:
        OutputError: when the folder exists or cannot be written.
    """

    def __init__(self, folder: str | Path, count: int, apart: bool = False) -> None:
        self.folder, self._count, self._apart = require_new(folder), count, apart
        self._names: list[str] = []
        self._open, self._named = ExitStack(), False

    def __enter__(self) -> KeptFlights:
        with writing(self.folder):
            self._aside = self._open.enter_context(staging(self.folder)) / self.folder.name
            self._aside.mkdir()
        return self

    def keep(self, run: Run) -> None:
        """Write the record of a flight.

        Raises:
            OutputError: when it cannot be written; it says where the record is kept instead.
        """
        try:
            with writing(self.folder):
                record(run.name, run, self._aside, self._apart)
        except OutputError as error:
            raise OutputError(f"{error}; {_elsewhere(run, self.folder.name)}") from error
        self._names.append(run.name)
        if len(self._names) == self._count and not run.failed:  # one that failed may have been interrupted
            self._name(self.folder)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with self._open:
            if self._named or not self._names:
                return
            if error is None:
                self._name(self.folder)
                return
            place = interrupted_name(self.folder)
            self._name(place)
            error.add_note(f"what was flown is kept in '{place}'")

    def _name(self, place: Path) -> None:
        with writing(place):
            rename_new(self._aside, place)
        self._named = True


def _elsewhere(run: Run, name: str) -> str:
    """Keep a record where temporary files lie, and say so."""
    place = first_free(Path(tempfile.gettempdir()), f"skylimb-{name}-{{}}")
    try:
        write_records({run.name: run}, place)
    except OutputError as error:
        return f"nor could the flight be kept elsewhere: {error}"
    return f"the flight is kept in '{place}'"
