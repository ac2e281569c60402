"""Files that end too soon, with zeros behind or without: they are read up to the last whole chunk."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator
from pathlib import Path

import pytest
import rosbags.rosbag1
from mcap.reader import make_reader

from skylimb.analysis.exchange.containers import container_of
from skylimb.analysis.exchange.convert import read_log, salvage
from skylimb.analysis.exchange.mcap_file import McapStream
from skylimb.analysis.exchange.stream import Raw
from skylimb.base.errors import ConfigError, OutputError

CHUNK, COUNT, TAIL = 700, 40, 3000

TEXT = "string data\n"


def messages() -> Iterator[Raw]:
    for k in range(COUNT):
        content = bytes([100, 0, 0, 0, *((7 * k + j) % 251 for j in range(100))])
        yield Raw(f"/lab/topic{k % 3}", "std_msgs/msg/String", TEXT, 10**9 + k * 5_000_000, content)


class SmallChunks(rosbags.rosbag1.Writer):
    """A bag with many chunks, though it is small."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self.chunk_threshold = CHUNK


@pytest.fixture(params=[".mcap", ".bag"])
def path(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A file of many small chunks."""
    path = tmp_path / f"a{request.param}"
    if request.param == ".bag":
        monkeypatch.setattr(rosbags.rosbag1, "Writer", SmallChunks)
        container_of(path).write(path, messages())
    else:
        stream = McapStream(path, CHUNK)
        for message in messages():
            stream.add(message)
        stream.close()
    return path


def read(path: Path, salvaged: bool = False) -> list[Raw]:
    """What is read of a file, whose warning is another test's."""
    with warnings.catch_warnings(), container_of(path).read(path, salvaged) as found:
        warnings.simplefilter("ignore", UserWarning)
        return list(found)


def offsets(size: int) -> list[int]:
    """Where a file is cut: at every byte of its end, and at some before."""
    return sorted({*range(20, size, 37), *range(max(20, size - TAIL), size)})


def test_a_cut_at_any_byte_leaves_what_is_before_with_zeros_behind_or_without(path: Path) -> None:
    content, every = path.read_bytes(), read(path)
    assert len(every) == COUNT
    counts = []
    # From its end on, in place: a disk waits for each file that is written anew.
    for offset in reversed(offsets(len(content))):
        os.truncate(path, offset)
        found = read(path)
        assert found == every[: len(found)], offset
        # Some of the zeros may be the very bytes that were cut off.
        os.truncate(path, offset + 200)
        with_zeros = read(path)
        assert with_zeros == every[: len(with_zeros)], offset
        assert len(found) <= len(with_zeros), offset
        counts.append(len(found))
    assert counts == sorted(counts, reverse=True)
    assert counts[0] == COUNT
    assert len(set(counts)) > 5


def test_a_cut_mcap_file_is_read_up_to_its_last_whole_chunk(path: Path) -> None:
    if path.suffix != ".mcap":
        pytest.skip("its index says where chunks end")
    content = path.read_bytes()
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    ends = [one.chunk_start_offset + one.chunk_length for one in summary.chunk_indexes]
    times = [0, *(one.message_end_time for one in summary.chunk_indexes)]
    assert len(times) > 6
    for end, before, time in zip(ends, times, times[1:], strict=False):
        for offset, until in ((end - 1, before), (end, time)):
            path.write_bytes(content[:offset])
            assert read(path) == [message for message in messages() if message.time <= until]


def test_what_ends_with_zeros_is_salvaged_and_until_when_is_said(path: Path, tmp_path: Path) -> None:
    content, anew = path.read_bytes(), tmp_path / f"anew{path.suffix}"
    path.write_bytes(content[: len(content) // 2] + bytes(70_000))
    left = read(path)
    with pytest.warns(UserWarning, match=r"was cut off: what was recorded up to 1\.\d+ s is read"):
        assert salvage(path, anew) == len(left) > 0
    assert read(anew) == left


def test_of_a_damaged_file_salvage_keeps_what_lies_before(path: Path, tmp_path: Path) -> None:
    content, every, anew = path.read_bytes(), read(path), tmp_path / f"anew{path.suffix}"
    counts = set[int]()
    for offset in range(len(content) // 2, 2 * len(content) // 3, 29):
        damaged = bytearray(content)
        damaged[offset] ^= 16
        path.write_bytes(damaged)
        left = read(path, salvaged=True)
        assert left == every[: len(left)]
        counts.add(len(left))
    assert min(counts) < COUNT
    path.write_bytes(content[: len(content) // 2] + bytes(range(1, 200)) + content[len(content) // 2 + 199 :])
    with pytest.raises(OutputError, match="is not a readable"):
        read(path)
    with pytest.warns(UserWarning, match=r"is damaged \(.+\): what was recorded up to 1\.\d+ s is read"):
        assert salvage(path, anew) > 0
    path.write_bytes(b"words" * 100)
    with pytest.raises(OutputError, match="is not a readable"):
        salvage(path, tmp_path / f"none{path.suffix}")


def test_a_bags_chunk_without_a_checksum_is_kept_only_where_no_zeros_follow(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Plain(SmallChunks):
        def open(self) -> None:
            self.compression_format, self.compressor = "none", bytes
            super().open()

    monkeypatch.setattr(rosbags.rosbag1, "Writer", Plain)
    path = tmp_path / "a.bag"
    container_of(path).write(path, messages())
    content, every = path.read_bytes(), read(path)
    assert len(every) == COUNT
    for offset in reversed(range(len(content) // 2, len(content) // 2 + 1200)):  # more than a chunk
        os.truncate(path, offset)
        os.truncate(path, offset + 2000)
        found = read(path)
        assert found == every[: len(found)], offset


def test_where_nothing_can_be_read_nothing_is_written(path: Path, tmp_path: Path) -> None:
    path.write_bytes(path.read_bytes()[:40])
    target = tmp_path / "none.mcap"
    with (
        pytest.warns(UserWarning, match="no message is read"),
        pytest.raises(OutputError, match="no message of"),
    ):
        salvage(path, target)
    assert not target.exists()
    with (
        pytest.warns(UserWarning, match="no message is read"),
        pytest.raises(OutputError, match=rf"no message of '{path}' can be read; it is empty, or cut off"),
    ):
        read_log(path)  # not: a log without a flight


def test_salvage_names_the_endings_that_it_takes(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"'\.nc' is not one of \.bag, \.mcap;"):
        salvage(tmp_path / "log.nc", tmp_path / "log.mcap")
