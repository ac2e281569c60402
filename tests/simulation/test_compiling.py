import ctypes
from pathlib import Path

import platformdirs
import pytest

from skylimb.errors import CompileError
from skylimb.simulation import compiling


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(platformdirs, "user_cache_dir", lambda name: str(tmp_path / name))
    return tmp_path / "skylimb"


def test_a_source_is_built_once(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if not compiling.compilers():
        pytest.skip("no C compiler on this machine")
    library = compiling.built_library("tests", "three", "int three(void) { return 3; }")
    assert ctypes.CDLL(str(library)).three() == 3
    assert [path.name for path in (cache / "tests").iterdir()] == [library.name]
    monkeypatch.setattr(compiling, "compilers", list)
    assert compiling.built_library("tests", "three", "int three(void) { return 3; }") == library
    with pytest.raises(CompileError, match="no C compiler found"):
        compiling.built_library("tests", "three", "int three(void) { return 4; }")


def test_what_the_compiler_says_is_told(cache: Path) -> None:
    if not compiling.compilers():
        pytest.skip("no C compiler on this machine")
    with pytest.raises(CompileError, match=r"error|expected"):
        compiling.built_library("tests", "wrong", "this is no C")
    assert not any((cache / "tests").iterdir())


def test_a_compiler_that_is_not_there_is_named(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiling, "compilers", lambda: [["no-such-compiler"]])
    with pytest.raises(CompileError, match="no-such-compiler"):
        compiling.built_library("tests", "three", "int three(void) { return 3; }")


def test_a_cache_that_cannot_be_written_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setattr(platformdirs, "user_cache_dir", lambda name: str(tmp_path / "file"))
    with pytest.raises(CompileError, match="file"):
        compiling.built_library("tests", "three", "int three(void) { return 3; }")
