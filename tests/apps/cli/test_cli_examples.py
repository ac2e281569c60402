"""The examples come with the package, and can be copied out of it."""

import subprocess
import sys
from pathlib import Path

import pytest

from skylimb.apps.cli.main import main

ROOT = Path(__file__).parents[3]
NAMES = {
    path.relative_to(ROOT / "examples").as_posix()
    for path in (ROOT / "examples").rglob("*")
    if path.is_file() and "__pycache__" not in path.parts
}


def names_in(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


def test_they_are_copied_into_a_new_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["examples", str(tmp_path / "mine")]) == 0
    out = capsys.readouterr().out
    assert names_in(tmp_path / "mine") == NAMES
    assert len(out.splitlines()) == len(NAMES)
    assert main(["examples", str(tmp_path / "mine")]) == 2
    assert "exists already" in capsys.readouterr().err


def test_a_built_package_has_them(tmp_path: Path) -> None:
    pytest.importorskip("setuptools", minversion="77")
    words = ["egg_info", "--egg-base", str(tmp_path), "build_py", "--build-lib", str(tmp_path / "lib")]
    subprocess.run([sys.executable, "setup.py", "-q", *words], cwd=ROOT, check=True, capture_output=True)
    assert names_in(tmp_path / "lib" / "skylimb" / "examples") == NAMES
    assert (tmp_path / "lib" / "skylimb" / "apps" / "cli" / "examples.py").is_file()
