"""A flight on the disk as it is flown: whole up to its last chunk, and worth less than the flight itself."""

import dataclasses
import io
import shutil
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

import skylimb
from skylimb.analysis.exchange import recorder as module
from skylimb.analysis.exchange.convert import read_log
from skylimb.analysis.exchange.lab_topics import ROW, STATE, Topic
from skylimb.analysis.exchange.recorder import FULL, LEAST, UNENDED, FlightRecorder, recording
from skylimb.analysis.exchange.run_topics import record_messages, row_table
from skylimb.base.errors import MissingExtraError, OutputError


def published(run: skylimb.Run, ticks: int | None = None) -> Iterator[list[tuple[Topic, Any]]]:
    """What a node publishes tick by tick, other topics among it."""
    begin = list(record_messages(run))
    for row in row_table(run.log)[:ticks]:
        yield [*begin, (STATE, 5), (ROW, {"data": row})]
        begin = []


def test_a_flight_that_is_killed_is_there_up_to_a_tenth_of_a_second(
    flown: skylimb.Run, tmp_path: Path
) -> None:
    recorder = FlightRecorder(tmp_path)
    for messages in published(flown, 300):
        recorder.take(messages)
    content = (tmp_path / "01-flight.mcap").read_bytes()  # nobody has closed it
    (tmp_path / "killed.mcap").write_bytes(content)
    with pytest.warns(UserWarning, match="was cut off: what was recorded up to"):
        read = read_log(tmp_path / "killed.mcap").run
    assert 250 < read.log.sizes["time"] < 300
    for name in ("thrusts_command", "root_position_measured"):
        np.testing.assert_array_equal(
            read.log[name].values, flown.log[name].values[: read.log.sizes["time"]], err_msg=name
        )
    recorder.close()
    assert read_log(tmp_path / "01-flight.mcap").run.log.sizes["time"] == 300
    assert not recorder.faults


def test_each_flight_has_a_file(flown: skylimb.Run, tmp_path: Path) -> None:
    recorder = FlightRecorder(tmp_path)
    recorder.take([(ROW, {"data": np.zeros(3)})])  # before any flight
    for ticks in (5, 7):
        for messages in published(flown, ticks):
            recorder.take(messages)
    recorder.close()
    sizes = {path.name: read_log(path).run.log.sizes["time"] for path in tmp_path.iterdir()}
    assert sizes == {"01-flight.mcap": 5, "02-flight.mcap": 7}


def test_no_row_waits_for_a_record_that_is_made_meanwhile(flown: skylimb.Run, tmp_path: Path) -> None:
    recorder, made = FlightRecorder(tmp_path), threading.Event()
    changed = dataclasses.replace(flown, log=flown.log.assign_attrs(config="changed"))

    def make() -> list[tuple[Topic, Any]]:
        assert made.wait(60.0)
        return list(record_messages(changed))

    for messages in published(flown, 5):
        recorder.take(messages)
    recorder.take_later(make)
    for messages in list(published(flown, 8))[5:]:
        recorder.take(messages)
    made.set()
    recorder.close()
    (path,) = tmp_path.iterdir()
    run = read_log(path).run
    assert (run.config, run.log.sizes["time"]) == ("changed", 8)


class Usage(NamedTuple):
    free: int


def test_a_disk_that_fills_ends_the_record_and_not_the_flight(
    flown: skylimb.Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    free = [10**10]
    monkeypatch.setattr(shutil, "disk_usage", lambda folder: Usage(free[0]))
    recorder = FlightRecorder(tmp_path)
    for k, messages in enumerate(published(flown, 500)):
        free[0] = LEAST - (k > 210)
        recorder.take(messages)
    assert recorder.faults == {FULL: 1}
    assert read_log(tmp_path / "01-flight.mcap").run.log.sizes["time"] == 400
    with pytest.raises(OutputError, match=r"has 0\.10 GB of room; flights are recorded with 1 GB or more"):
        FlightRecorder(tmp_path)


def test_of_a_flight_whose_disk_filled_only_the_part_before_is_called_kept(
    flown: skylimb.Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    free = [10**10]
    monkeypatch.setattr(shutil, "disk_usage", lambda folder: Usage(free[0]))

    def fly() -> None:
        with recording(tmp_path / "out") as recorder:
            assert recorder is not None
            for k, messages in enumerate(published(flown, 500)):
                free[0] = LEAST - (k > 210)
                recorder.take(messages)
            raise RuntimeError

    with pytest.raises(RuntimeError) as stopped:
        fly()
    place = tmp_path / "out-interrupted"
    assert stopped.value.__notes__ == [f"what was flown before the disk had no room is kept in '{place}'"]


def test_a_file_that_cannot_be_written_is_a_fault(
    flown: skylimb.Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Full(module.McapStream):
        def add(self, raw: Any) -> None:
            raise OSError(28, "No space left on device")

    monkeypatch.setattr(module, "McapStream", Full)
    recorder = FlightRecorder(tmp_path)
    for messages in published(flown, 3):
        recorder.take(messages)
    assert recorder.faults == {FULL: 1}


class Disk:
    """A file on a disk that takes no byte more from a time on; it can fail in the middle of a write."""

    def __init__(self, path: Path) -> None:
        self._file, self.room = io.FileIO(path, "x"), 10**9

    def write(self, data: bytes) -> int:
        taken = self._file.write(bytes(data[: self.room]))
        self.room -= taken
        if taken < len(data):
            raise OSError(5, "Input/output error")
        return taken

    def tell(self) -> int:
        return self._file.tell()

    def flush(self) -> None:
        pass

    def __enter__(self) -> None:
        pass

    def __exit__(self, *error: object) -> None:
        self._file.close()


@pytest.fixture
def disks(monkeypatch: pytest.MonkeyPatch) -> list[Disk]:
    """Those that flights are recorded on."""
    disks: list[Disk] = []

    def opened(path: Path, mode: str) -> Disk:
        disks.append(Disk(path))
        return disks[-1]

    class Failing(module.McapStream):
        def __init__(self, path: Path, chunk: int) -> None:
            with monkeypatch.context() as patched:
                patched.setattr(Path, "open", opened)
                super().__init__(path, chunk)

    monkeypatch.setattr(module, "McapStream", Failing)
    return disks


def test_a_disk_that_fails_in_flight_leaves_what_was_written(
    flown: skylimb.Run, tmp_path: Path, disks: list[Disk]
) -> None:
    recorder = FlightRecorder(tmp_path)
    for k, messages in enumerate(published(flown, 250)):
        recorder.take(messages)
        if k == 150:
            disks[0].room = 500
        if recorder.faults:
            disks[0].room = 10**9  # nothing may be written behind the gap
    recorder.close()
    assert recorder.faults == {FULL: 1}
    with pytest.warns(UserWarning, match="was cut off"):
        read = read_log(tmp_path / "01-flight.mcap").run
    ticks = read.log.sizes["time"]
    assert 100 < ticks <= 151
    np.testing.assert_array_equal(read.log.thrusts_command, flown.log.thrusts_command[:ticks])


@pytest.mark.parametrize("room", [0, 100, 5000])
def test_a_disk_that_fails_at_the_end_keeps_the_flight_and_what_ended_it(
    flown: skylimb.Run, tmp_path: Path, disks: list[Disk], room: int
) -> None:
    def fly(folder: Path, error: BaseException | None) -> None:
        with recording(folder) as recorder:
            assert recorder is not None
            for messages in published(flown, 150):
                recorder.take(messages)
            disks[-1].room = room
            if error:
                raise error

    with pytest.raises(KeyboardInterrupt) as stopped:
        fly(tmp_path / "a", KeyboardInterrupt())
    place = tmp_path / "a-interrupted"
    assert stopped.value.__notes__ == [f"what was flown is kept in '{place}'"]
    with pytest.warns(UserWarning, match=f"{UNENDED}: what was flown is kept in"):
        fly(tmp_path / "b", None)
    for name in ("a", "b"):
        path = tmp_path / f"{name}-interrupted" / "01-flight.mcap"
        with pytest.warns(UserWarning, match="was cut off"):
            assert 100 < read_log(path).run.log.sizes["time"] <= 150
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a-interrupted", "b-interrupted"]


def test_a_flight_that_cannot_get_its_name_is_left_where_it_is(
    flown: skylimb.Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def failing(self: Path, target: Path) -> Path:
        raise OSError(28, "No space left on device")

    def fly() -> None:
        with recording(tmp_path / "a") as recorder:
            assert recorder is not None
            for messages in published(flown, 9):
                recorder.take(messages)
            raise KeyboardInterrupt

    monkeypatch.setattr(Path, "rename", failing)
    with pytest.raises(KeyboardInterrupt) as stopped:
        fly()
    (path,) = tmp_path.rglob("*.mcap")
    assert stopped.value.__notes__ == [f"what was flown is kept in '{path.parent}'"]
    assert read_log(path).run.log.sizes["time"] == 9


def test_whoever_interrupts_twice_keeps_the_flight(
    flown: skylimb.Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fly() -> None:
        with recording(tmp_path / "a") as recorder:
            assert recorder is not None
            for messages in published(flown, 150):
                recorder.take(messages)
            raise KeyboardInterrupt

    def interrupted(self: FlightRecorder) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(FlightRecorder, "close", interrupted)
    with pytest.raises(KeyboardInterrupt):
        fly()
    with pytest.warns(UserWarning, match="was cut off"):
        assert read_log(tmp_path / "a-interrupted" / "01-flight.mcap").run.log.sizes["time"] > 100


def test_a_record_that_cannot_be_made_does_not_hide_what_ended_the_flight(
    flown: skylimb.Run, tmp_path: Path
) -> None:
    def make() -> list[tuple[Topic, Any]]:
        raise ValueError("no record")

    def fly() -> None:
        with recording(tmp_path / "a") as recorder:
            assert recorder is not None
            for messages in published(flown, 9):
                recorder.take(messages)
            recorder.take_later(make)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as stopped:
        fly()
    assert stopped.value.__notes__[0] == f"{UNENDED}: no record"
    assert read_log(tmp_path / "a-interrupted" / "01-flight.mcap").run.log.sizes["time"] == 9


def test_a_record_without_a_tick_is_no_flight(flown: skylimb.Run, tmp_path: Path) -> None:
    recorder = FlightRecorder(tmp_path)
    recorder.take(record_messages(flown))
    recorder.close()
    with pytest.raises(OutputError, match="holds the record of a flight, and no tick of it"):
        read_log(tmp_path / "01-flight.mcap")


def test_what_was_flown_anew_takes_the_place_of_what_was_before(flown: skylimb.Run, tmp_path: Path) -> None:
    recorder = FlightRecorder(tmp_path)
    rows = row_table(flown.log)
    recorder.take(record_messages(flown))
    for k in (*range(30), *range(12, 20)):
        recorder.take([(ROW, {"data": rows[k]})])
    recorder.take(record_messages(dataclasses.replace(flown, name="changed")), anew=False)
    recorder.close()
    read = read_log(tmp_path / "01-flight.mcap")
    assert (read.run.name, read.notes) == ("changed", ())
    np.testing.assert_array_equal(read.run.log.time, flown.log.time[:20])


def test_without_the_extra_nothing_is_recorded_and_a_line_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def missing() -> None:
        raise MissingExtraError("'rosbags' is not installed: pip install 'skylimb[logs]'")

    monkeypatch.setattr(module, "message_types", missing)
    said = pytest.warns(UserWarning, match=r"before it ends: 'rosbags' is not installed")
    with said, recording(tmp_path / "out") as recorder:
        assert recorder is None
    assert list(tmp_path.iterdir()) == []
