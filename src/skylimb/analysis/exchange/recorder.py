"""Flights on the disk as they are flown: whatever ends the process, what was flown can be read.

A flight is an MCAP file: its record without rows first, then a row a tick, in small chunks with checksums
that go to the system as they fill. `to_run` reads it up to the last whole chunk (`stream.decoded`). It is the
same for every door: `fly`, the studio and ROS.
"""

from __future__ import annotations

import shutil
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from skylimb.analysis.exchange.codec import message_of
from skylimb.analysis.exchange.from_run import START
from skylimb.analysis.exchange.lab_topics import RECORD, ROW, SOURCE, Topic
from skylimb.analysis.exchange.mcap_file import McapStream
from skylimb.analysis.exchange.message_types import message_types
from skylimb.analysis.exchange.stream import Message, Raw, encoder
from skylimb.base.errors import MissingExtraError, OutputError, first_line
from skylimb.base.files import interrupted_name, staging

CHUNK = 32_768
"""Bytes of a chunk: some tenth of a second of flight."""

ROOM, LEAST = 10**9, 10**8
"""Bytes that are free before the first flight, room for an hour; and later, or it is recorded no more."""

FULL = "flight no longer recorded: the disk has no room"

UNENDED = "the end of a flight's record could not be written"

Messages = Iterable[tuple[Topic, Any]]
"""Topic and fields of each."""


class FlightRecorder:
    """Takes what a flight publishes and keeps its record.

    Args:
        folder: for the files, `01-flight.mcap` and so on.

    Attributes:
        faults: how often each was met.

    Raises:
        OutputError: when the folder's disk has too little room.
    """

    def __init__(self, folder: Path) -> None:
        free = shutil.disk_usage(folder).free
        if free < ROOM:
            raise OutputError(
                f"'{folder}' has {1e-9 * free:.2f} GB of room; flights are recorded with {1e-9 * ROOM:g} GB "
                "or more"
            )
        self._folder, self._types, self._encode = folder, message_types(), encoder()
        self._stream: McapStream | None = None
        self._flights, self._rows = 0, 0
        self._beside: dict[str, FlightRecorder] = {}
        self._thread = ThreadPoolExecutor(1, "recorder")
        self._coming: Future[Messages] | None = None
        self.faults = Counter[str]()

    def beside(self, name: str) -> FlightRecorder:
        """The recorder of one of several flights at once, in a folder of its own."""
        if name not in self._beside:
            folder = self._folder / name
            folder.mkdir()
            self._beside[name] = FlightRecorder(folder)
            self._beside[name].faults = self.faults
        return self._beside[name]

    def take_later(self, make: Callable[[], Messages]) -> None:
        """Keep another record of the flight under way, which takes long to make: a thread does, meanwhile."""
        self._take_coming()
        self._coming = self._thread.submit(make)

    def _take_coming(self) -> None:
        """Keep the record that is being made, once it is there."""
        coming, self._coming = self._coming, None
        if coming is not None:
            self.take(coming.result(), anew=False)

    def take(self, messages: Messages, anew: bool = True) -> None:
        """Keep those of some messages, topic and fields, that are of the record.

        Args:
            messages: a record begins a flight.
            anew: whether it does, or is that of the flight under way as it is now.
        """
        if self._coming is not None and self._coming.done():
            self._take_coming()
        for topic, fields in messages:
            if topic not in (RECORD, SOURCE, ROW):
                continue
            try:
                if topic == RECORD and anew:
                    self._end()
                    self._flights, self._rows = self._flights + 1, 0
                    self._stream = McapStream(self._folder / f"{self._flights:02d}-flight.mcap", CHUNK)
                if self._stream is not None:
                    self._stream.add(self._message(topic, fields))
                    self._watch(topic)
            except OSError:
                self._give_up()

    def close(self) -> None:
        """End the files of all flights."""
        for recorder in (self, *self._beside.values()):
            recorder._end()

    def _end(self) -> None:
        """End the flight's file, with the record that is still being made."""
        try:
            self._take_coming()
        finally:
            self._end_file()

    def _end_file(self) -> None:
        """A flight is worth more than its record: a disk that fails is a fault."""
        stream, self._stream = self._stream, None
        try:
            if stream is not None:
                stream.close()
        except OSError:
            self.faults[UNENDED] += 1

    def _message(self, topic: Topic, fields: Any) -> Raw:
        time = START + (round(1e9 * float(fields["data"][0])) if topic == ROW else 0)
        value = message_of(self._types, topic.type, fields, self._rows)
        return self._encode(Message(topic.name, topic.type, time, value))

    def _watch(self, topic: Topic) -> None:
        self._rows += topic == ROW
        if self._rows % round(ROW.rate) == 0 and shutil.disk_usage(self._folder).free < LEAST:
            self._take_coming()
            self._give_up()

    def _give_up(self) -> None:
        """Record no more of this flight."""
        self.faults[FULL] += 1
        self._end_file()


@contextmanager
def recording(folder: Path) -> Iterator[FlightRecorder | None]:
    """Flights on the disk as they are flown, aside of a folder; who comes to the end has them whole.

    After an error they are kept in FOLDER-interrupted, and where the end of one could not be written; those
    of a killed process are found by `skylimb runs`. Without the extra `logs` nothing is recorded, and a
    warning says so.

    Raises:
        OutputError: when the disk has too little room.
    """
    left: list[Path] = []
    with staging(folder, left) as aside:
        inside = aside / folder.name
        inside.mkdir()
        try:
            recorder = FlightRecorder(inside)
        except MissingExtraError as error:
            warnings.warn(f"not on the disk before it ends: {error}", UserWarning, stacklevel=3)
            yield None
            return
        try:
            yield recorder
            recorder.close()
        except BaseException as error:
            try:
                recorder.close()
            except Exception as other:  # what ended the flight is what its user has to hear of
                error.add_note(f"{UNENDED}: {first_line(other)}")
            finally:
                if words := _kept(inside, folder, left, recorder):
                    error.add_note(words)
            raise
        if UNENDED in recorder.faults:
            warnings.warn(f"{UNENDED}: {_kept(inside, folder, left, recorder)}", UserWarning, stacklevel=3)


def _kept(inside: Path, folder: Path, left: list[Path], recorder: FlightRecorder) -> str:
    """Give flights a name that is seen, or leave them where they are; words that say where, or none."""
    place = inside
    try:
        if not any(inside.rglob("*.mcap")):
            return ""
        place = inside.rename(interrupted_name(folder))
    except OSError:  # a disk that fails takes no other name; what is on it has to stay
        left.append(inside)
    until = " before the disk had no room" if FULL in recorder.faults else ""
    return f"what was flown{until} is kept in '{place}'"
