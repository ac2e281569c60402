"""The pictures of the guides: what is too large replaces nothing."""

import runpy
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[1] / "docs"


def test_pictures_that_are_too_large_leave_those_that_are_there(tmp_path: Path) -> None:
    put = runpy.run_path(str(DOCS / "picture.py"))["put"]
    there = tmp_path / "light.webp"
    there.write_bytes(b"of today")
    with pytest.raises(SystemExit, match=r"light.webp, dark.webp: 0.0 MB, more than .* nothing was written"):
        put({there: b"larger", tmp_path / "dark.webp": b"larger"}, most=11)
    assert there.read_bytes() == b"of today"
    assert [path.name for path in tmp_path.iterdir()] == ["light.webp"]
    assert put({there: b"larger", tmp_path / "new" / "dark.webp": b"larger"}, most=12) == 12
    assert there.read_bytes() == (tmp_path / "new" / "dark.webp").read_bytes() == b"larger"


def test_without_a_browser_no_picture_is_made(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(SystemExit, match=r"none of chromium, .* is installed"):
        runpy.run_path(str(DOCS / "picture.py"))["browser"]()
