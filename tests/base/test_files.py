"""What a killed process had written aside is known for it; what is still written is not."""

import os
import platform
import subprocess
import sys
from pathlib import Path

import pytest

from skylimb.base.errors import OutputError
from skylimb.base.files import first_free, new_file, orphans, replacing, staging

KILLED = """
import os, sys
from skylimb.base.files import new_folder, replacing
with new_folder("{0}/run") as aside, replacing("{0}/old.txt") as file:
    (aside / "log.nc").write_text("half")
    file.write_text("half")
    os._exit(9)
"""


@pytest.fixture
def killed(tmp_path: Path) -> Path:
    """A folder in which a process was killed that wrote a folder and a file."""
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep/old.txt").write_text("whole")
    code = KILLED.format(tmp_path / "deep")
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 9
    return tmp_path


def test_what_a_killed_process_wrote_aside_is_found(killed: Path) -> None:
    assert (killed / "deep/old.txt").read_text() == "whole"
    found = orphans(killed)
    assert sorted(name for _, name in found) == ["old.txt", "run"]
    folder = next(path for path, name in found if name == "run")
    assert (folder / "run" / "log.nc").read_text() == "half"
    assert all(path.parent == killed / "deep" for path, _ in found)


def test_what_is_still_written_or_anothers_is_no_orphan(tmp_path: Path) -> None:
    with new_file(tmp_path / "a") as file, replacing(tmp_path / "b") as aside:
        file.write_text("x")
        aside.write_text("x")
        assert len(list(tmp_path.iterdir())) == 2
        assert orphans(tmp_path) == []
    machine = platform.node().replace(".", "_")
    gone = subprocess.Popen([sys.executable, "-c", ""])
    gone.wait()
    for name in (
        f".a.elsewhere-{gone.pid}-00000000.partial",
        f".a.{machine}-{os.getpid()}-00000000.partial",
        f".a.{machine}-{gone.pid}-0.partial",
        f"a.{machine}-{gone.pid}-00000000.partial",
    ):
        (tmp_path / name).write_text("x")
    assert orphans(tmp_path) == []


def test_the_first_free_name_has_the_least_number(tmp_path: Path) -> None:
    assert first_free(tmp_path, "run-{}").name == "run-1"
    (tmp_path / "run-1").mkdir()
    (tmp_path / "run-3").mkdir()
    assert first_free(tmp_path, "run-{}").name == "run-2"


def test_a_place_where_nothing_can_be_made_is_refused_in_a_line(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    for place, why in (
        (tmp_path / "file" / "live", "is a file, not a folder"),
        (Path("/proc/x/live"), "'/proc'"),
    ):
        with pytest.raises(OutputError, match=why), staging(place):
            pass
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
