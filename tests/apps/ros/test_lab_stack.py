"""The runner of the lab's own flight check: without the lab's stack one line, and nothing is flown."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

RUNNER = Path(__file__).parents[3] / "tools" / "lab_stack" / "flights.py"


def run(*words: str | Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, str(RUNNER), *map(str, words)],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
    )


@pytest.mark.parametrize(
    ("made", "words"),
    [((), "is no checkout of jsk_aerial_robot"), (("aerial_robot_base",), "no aerial_robot_base_node")],
)
def test_without_the_labs_stack_nothing_is_flown(tmp_path: Path, made: tuple[str, ...], words: str) -> None:
    for folder in made:
        (tmp_path / folder).mkdir()
    done = run(tmp_path, tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("skipped: ")
    assert words in done.stdout
    assert done.stdout.count("\n") == 1
