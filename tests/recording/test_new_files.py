"""Nothing is overwritten, and nothing half-written is left behind."""

import pytest

from skylimb.errors import OutputError
from skylimb.recording import new_file, new_folder, require_new


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
