"""Flights on the disk as they are flown: whatever ends the process, what was flown can be read.

A flight is an MCAP file: its record without rows first, then a row a tick, in small chunks with checksums
that go to the system as they fill. `to_run` reads it up to the last whole chunk (`stream.decoded`).
"""

from __future__ import annotations

import shutil
from collections import Counter
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any

from skylimb.analysis.exchange.codec import message_of
from skylimb.analysis.exchange.from_run import START
from skylimb.analysis.exchange.lab_topics import RECORD, ROW, SOURCE, Topic
from skylimb.analysis.exchange.mcap_file import McapStream
from skylimb.analysis.exchange.message_types import message_types
from skylimb.analysis.exchange.stream import Message
from skylimb.base.errors import OutputError

CHUNK = 32_768
"""Bytes of a chunk: some tenth of a second of flight."""

ROOM, LEAST = 10**9, 10**8
"""Bytes that are free before the first flight, room for an hour; and later, or it is recorded no more."""

FULL = "flight no longer recorded: the disk has no room"


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
        self._folder, self._types = folder, message_types()
        self._stream: McapStream | None = None
        self._flights, self._rows = 0, 0
        self.faults = Counter[str]()

    def take(self, messages: Iterable[tuple[Topic, Any]]) -> None:
        """Keep those of some messages, topic and fields, that are of the record."""
        for topic, fields in messages:
            if topic not in (RECORD, SOURCE, ROW):
                continue
            try:
                if topic == RECORD:
                    self.close()
                    self._flights, self._rows = self._flights + 1, 0
                    self._stream = McapStream(self._folder / f"{self._flights:02d}-flight.mcap", CHUNK)
                if self._stream is not None:
                    self._stream.add(self._message(topic, fields))
                    self._watch(topic)
            except OSError:
                self._give_up()

    def close(self) -> None:
        """End the flight's file."""
        stream, self._stream = self._stream, None
        if stream is not None:
            stream.close()

    def _message(self, topic: Topic, fields: Any) -> Message:
        time = START + (round(1e9 * float(fields["data"][0])) if topic == ROW else 0)
        return Message(topic.name, topic.type, time, message_of(self._types, topic.type, fields, self._rows))

    def _watch(self, topic: Topic) -> None:
        self._rows += topic == ROW
        if self._rows % round(ROW.rate) == 0 and shutil.disk_usage(self._folder).free < LEAST:
            self._give_up()

    def _give_up(self) -> None:
        """A flight is worth more than its record."""
        self.faults[FULL] += 1
        with suppress(OSError):
            self.close()
        self._stream = None
