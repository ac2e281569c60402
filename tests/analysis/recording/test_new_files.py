"""Nothing is overwritten, and nothing half-written is left behind."""

import errno
import os

import pytest

from skylimb.base.errors import OutputError
from skylimb.base.files import new_file, new_folder, replace_text, replacing, require_new


def test_a_new_folder_appears_whole_and_only_at_the_end(tmp_path):
    target = tmp_path / "a" / "b" / "out"
    with new_folder(target) as aside:
        (aside / "x.txt").write_text("x")
        assert not target.exists()
    assert (target / "x.txt").read_text() == "x"
    assert [path.name for path in target.parent.iterdir()] == ["out"]


def test_an_error_leaves_no_trace_not_even_the_parents(tmp_path):
    def write():
        with new_folder(tmp_path / "a" / "b" / "out") as aside:
            (aside / "x.txt").write_text("x")
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        write()
    assert list(tmp_path.iterdir()) == []


def test_a_new_file_appears_at_the_end(tmp_path):
    with new_file(tmp_path / "x.txt") as aside:
        aside.write_text("x")
        assert not (tmp_path / "x.txt").exists()
    assert [path.name for path in tmp_path.iterdir()] == ["x.txt"]


@pytest.mark.parametrize("make", ["file", "folder", "dangling link"])
def test_what_exists_is_refused_before_anything_is_made(tmp_path, make):
    target = tmp_path / "out"
    if make == "file":
        target.write_text("mine")
    elif make == "folder":
        target.mkdir()
    else:
        target.symlink_to(tmp_path / "nowhere")
    before = sorted(tmp_path.iterdir())
    with pytest.raises(OutputError, match=r"out' exists already"):
        require_new(target)
    with pytest.raises(OutputError, match="exists already"), new_folder(target):
        pytest.fail("the block must not run")
    assert sorted(tmp_path.iterdir()) == before


def test_what_appears_meanwhile_is_not_overwritten(tmp_path):
    target = tmp_path / "out"

    def write():
        with new_folder(target) as aside:
            (aside / "x.txt").write_text("ours")
            target.mkdir()

    with pytest.raises(OutputError, match="exists already"):
        write()
    assert list(target.iterdir()) == []


def test_a_file_cannot_be_a_parent(tmp_path):
    (tmp_path / "file").write_text("x")
    with pytest.raises(OutputError, match=r"file' is a file, not a folder"):
        require_new(tmp_path / "file" / "out")


def test_require_new_makes_nothing(tmp_path):
    assert require_new(tmp_path / "a" / "out") == tmp_path / "a" / "out"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("make", [new_file, new_folder])
def test_a_full_disk_is_one_line_and_leaves_nothing(tmp_path, make):
    def write():
        with make(tmp_path / "deep" / "out"):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with pytest.raises(OutputError, match=r"^cannot write '.*out': No space left on device$"):
        write()
    assert list(tmp_path.iterdir()) == []


def test_a_file_is_replaced_in_one_step(tmp_path):
    target = tmp_path / "x.txt"
    target.write_text("old")
    with replacing(target) as aside:
        aside.write_text("new")
        assert target.read_text() == "old"
        assert aside.parent == tmp_path
    assert target.read_text() == "new"
    replace_text(target, "°")
    assert target.read_bytes() == "°".encode()
    assert [path.name for path in tmp_path.iterdir()] == ["x.txt"]


def test_what_was_not_finished_leaves_the_old_file(tmp_path):
    target = tmp_path / "x.txt"
    target.write_text("old")

    def write():
        with replacing(target) as aside:
            aside.write_text("half")
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        write()
    assert target.read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["x.txt"]


def test_two_at_once_do_not_meet(tmp_path):
    target = tmp_path / "x.txt"
    with replacing(target) as first, replacing(target) as second:
        first.write_text("1")
        second.write_text("2")
    assert target.read_text() == "1"


def test_a_replaced_file_has_the_permissions_of_a_plain_one(tmp_path):
    plain = tmp_path / "plain"
    plain.write_text("x")
    replace_text(tmp_path / "other", "x")
    assert (tmp_path / "other").stat().st_mode == plain.stat().st_mode
