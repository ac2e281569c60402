"""What is kept is what was kept, or counts as absent."""

from collections.abc import Callable
from pathlib import Path

import pytest

from damages import DAMAGES
from skylimb.base.cache import keep, kept


def test_what_is_kept_is_read_again(tmp_path: Path) -> None:
    path = tmp_path / "new" / "entry"
    assert kept(path) is None
    for content in (b"\0one", b"", b"two"):
        keep(path, content)
        assert kept(path) == content
    assert sorted(file.name for file in path.parent.iterdir()) == ["entry", "entry.sha256"]


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES)
@pytest.mark.parametrize("ending", ["", ".sha256"])
def test_what_was_damaged_is_absent_and_said_in_one_line(
    tmp_path: Path, damage: Callable[[bytes], bytes], ending: str
) -> None:
    path = tmp_path / "entry"
    keep(path, b"something")
    file = tmp_path / f"entry{ending}"
    file.write_bytes(damage(file.read_bytes()))
    with pytest.warns(UserWarning, match="entry' was damaged since it was kept, and is made anew"):
        assert kept(path) is None
    keep(path, b"something")
    assert kept(path) == b"something"


def test_what_was_not_kept_to_the_end_is_absent(tmp_path: Path) -> None:
    for ending in ("", ".sha256"):
        keep(tmp_path / "entry", b"something")
        (tmp_path / f"entry{ending}").unlink()
        assert kept(tmp_path / "entry") is None


def test_a_relative_path_is_no_place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(FileNotFoundError, match="has no place"):
        keep(Path("~/entry"), b"")
    assert not list(tmp_path.iterdir())
