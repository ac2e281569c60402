import ctypes
import errno
import os
import subprocess
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import platformdirs
import pytest

from damages import DAMAGES
from skylimb.base.errors import CompileError
from skylimb.simulation import compiling

THREE = "int three(void) { return 3; }"
needs_compiler = pytest.mark.skipif(not compiling.compilers(), reason="no C compiler on this machine")


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A user's cache of this test alone, and no folders of this process yet."""
    monkeypatch.setattr(platformdirs, "user_cache_path", lambda name: tmp_path / name)
    compiling._process_folder.cache_clear()
    yield tmp_path / "skylimb"
    compiling._process_folder.cache_clear()


@pytest.fixture
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The only temporary folder."""
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    monkeypatch.setattr(compiling, "_temporary_folders", lambda: [tmp_path / "not there", folder])
    return folder


def fill_disk(monkeypatch: pytest.MonkeyPatch, folder: Path, function: str) -> None:
    """Let a function of `os` find no space below a folder."""
    real = getattr(os, function)

    def full(*arguments: object, **options: object) -> object:
        if any(str(argument).startswith(str(folder)) for argument in arguments):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(folder))
        return real(*arguments, **options)

    monkeypatch.setattr(os, function, full)


@needs_compiler
def test_a_source_is_built_once(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    library = compiling.built_library("tests", "three", THREE)
    assert ctypes.CDLL(str(library)).three() == 3
    assert {path.name for path in (cache / "tests").iterdir()} == {library.name, f"{library.name}.sha256"}
    monkeypatch.setattr(compiling, "compilers", list)
    assert compiling.built_library("tests", "three", THREE) == library
    with pytest.raises(CompileError, match=r"no C compiler found.*skylimb\[compiler\]"):
        compiling.built_library("tests", "three", "int three(void) { return 4; }")


@needs_compiler
@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES)
def test_a_damaged_library_is_built_anew_before_it_is_loaded(
    cache: Path, damage: Callable[[bytes], bytes]
) -> None:
    library = compiling.built_library("tests", "three", THREE)
    built = library.read_bytes()
    library.write_bytes(damage(built))
    with pytest.warns(UserWarning, match="damaged since it was kept, and is made anew"):
        assert compiling.built_library("tests", "three", THREE) == library
    assert library.read_bytes() == built


@needs_compiler
def test_what_the_compiler_says_is_told(
    cache: Path, elsewhere: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = compiling.compilers()[:1]
    monkeypatch.setattr(compiling, "compilers", lambda: first)
    with pytest.raises(CompileError, match=r"error|expected"):
        compiling.built_library("tests", "wrong", "this is no C")
    assert not any((cache / "tests").iterdir())


def test_a_compiler_that_is_not_there_is_named(
    cache: Path, elsewhere: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(compiling, "compilers", lambda: [["no-such-compiler"]])
    with pytest.raises(CompileError, match="no-such-compiler"):
        compiling.built_library("tests", "three", THREE)


def test_a_compiler_that_is_given_up_leaves_nothing_running(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pid, compiler = tmp_path / "pid", tmp_path / "cc"
    compiler.write_text(f"#!/bin/sh\nsleep 600 &\necho $! > {pid}\nwait\n")
    compiler.chmod(0o755)
    monkeypatch.setattr(compiling, "_PATIENCE", 0.5)
    monkeypatch.setattr(compiling, "compilers", lambda: [[str(compiler)]])
    with pytest.raises(CompileError, match="timed out"):
        compiling.compile_c([tmp_path / "a.c"], tmp_path / "a.so", compiling.FLAGS)
    status = Path(f"/proc/{pid.read_text().strip()}/status")
    begun = time.monotonic()
    while status.exists() and "zombie" not in status.read_text():
        assert time.monotonic() < begun + 10.0  # a busy computer takes its time to end what was killed
        time.sleep(0.02)


@needs_compiler
@pytest.mark.parametrize("obstacle", ["a file in its place", "full at mkdir", "full at rename"])
def test_a_cache_that_cannot_be_written_decides_nothing(
    cache: Path, elsewhere: Path, monkeypatch: pytest.MonkeyPatch, obstacle: str
) -> None:
    if obstacle == "a file in its place":
        cache.write_text("")
    else:
        fill_disk(monkeypatch, cache, "mkdir" if obstacle == "full at mkdir" else "replace")
    with pytest.warns(UserWarning, match=r"cannot be kept in .*skylimb' \(.*(No space|exists|directory)"):
        library = compiling.built_library("tests", "three", THREE)
    assert library.is_relative_to(elsewhere)
    assert ctypes.CDLL(str(library)).three() == 3
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert compiling.built_library("tests", "three", THREE) == library
        compiling.built_library("tests", "four", "int four(void) { return 4; }")
    assert not list(cache.rglob("*.so"))


@needs_compiler
@pytest.mark.skipif(os.name != "posix", reason="the compiler is a shell script")
def test_a_compiler_that_finds_the_disk_full_is_asked_elsewhere(
    cache: Path, elsewhere: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    script = tmp_path / "compiler"
    real = " ".join(compiling.compilers()[0])
    # It leaves half a library, as a linker does whose disk is full.
    script.write_text(
        f'#!/bin/sh\ncase "$TMPDIR" in {cache}*)\n'
        'while [ "$1" != -o ]; do shift; done; echo half > "$2"; echo "No space left" >&2; exit 1;; esac\n'
        f'exec {real} "$@"\n'
    )
    script.chmod(0o755)
    monkeypatch.setattr(compiling, "compilers", lambda: [[str(script)]])
    with pytest.warns(UserWarning, match="no compiler can write there"):
        library = compiling.built_library("tests", "three", THREE)
    assert library.is_relative_to(elsewhere)
    assert ctypes.CDLL(str(library)).three() == 3
    assert not any((cache / "tests").iterdir())


def test_where_nothing_can_be_written_every_place_is_named(
    cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cache.write_text("")
    monkeypatch.setattr(compiling, "_temporary_folders", lambda: [tmp_path / "not there"])
    with pytest.raises(CompileError, match=r"nowhere: .*skylimb.*not there"):
        compiling.built_library("tests", "three", THREE)


@needs_compiler
def test_without_a_home_nothing_is_left_in_the_working_directory(
    elsewhere: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(platformdirs, "user_cache_path", lambda name: Path(f"~/.cache/{name}"))
    monkeypatch.chdir(tmp_path)
    before = set(tmp_path.iterdir())
    compiling._process_folder.cache_clear()
    with pytest.warns(UserWarning, match="has no place"):
        library = compiling.built_library("tests", "three", THREE)
    assert library.is_relative_to(elsewhere)
    assert set(tmp_path.iterdir()) == before


@needs_compiler
@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are not forked here")
def test_a_temporary_library_lives_as_long_as_the_process_that_made_it(tmp_path: Path) -> None:
    (tmp_path / "cache").write_text("")
    code = f"""
import ctypes, os, sys, warnings
warnings.simplefilter("ignore")
from skylimb.simulation import compiling
made = compiling.built_library("tests", "three", {THREE!r})
child = os.fork()
if child == 0:
    own = compiling.built_library("tests", "three", {THREE!r})
    sys.exit(own == made)  # and what atexit does
assert os.waitpid(child, 0)[1] == 0
assert ctypes.CDLL(str(made)).three() == 3
print(made)
"""
    folders = {"XDG_CACHE_HOME": str(tmp_path / "cache"), "TMPDIR": str(tmp_path), "HOME": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, **folders},
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(str(tmp_path))
    assert [path.name for path in tmp_path.iterdir()] == ["cache"]


@pytest.mark.parametrize(
    ("does", "told"),
    [("print('one\\ntwo')", "one, "), ("print('one'); raise SystemExit(3)", "none"), ("pass", "none")],
)
def test_a_version_is_that_of_a_compiler_that_works(
    monkeypatch: pytest.MonkeyPatch, does: str, told: str
) -> None:
    monkeypatch.setattr(compiling, "compilers", lambda: [[sys.executable, "-c", does]])
    assert compiling.compiler_version.__wrapped__().startswith(told)
