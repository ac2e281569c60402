"""The runner of the lab's own flight check: without the lab's stack one line, and nothing is flown."""

from __future__ import annotations

import contextlib
import importlib.util
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

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


@pytest.fixture(scope="module")
def stack() -> Any:
    spec = importlib.util.spec_from_file_location("lab_stack", RUNNER.parent / "stack.py")
    assert spec is not None
    assert spec.loader is not None
    sys.modules["lab_stack"] = module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(("states", "starts"), [((0,), 1), ((17, 17, 0), 3), ((17,) * 4, 4)])
def test_a_node_that_lands_before_it_flies_is_started_again(
    stack: Any, states: tuple[int, ...], starts: int
) -> None:
    lab = object.__new__(stack.LabStack)
    lab.nodes = dict.fromkeys(stack.NODES, "node")
    left, events = list(states), list[str]()
    lab.heard = lambda topic: None
    lab.do = lambda *words, timeout: f"{left.pop(0)}\n---\n"

    def begin(name: str, *words: str) -> contextlib.ExitStack:
        events.append("begun")
        own = contextlib.ExitStack()
        own.callback(events.append, "ended")
        return own

    dead = states[-1] != 0
    with pytest.raises(stack.MissingError, match="4 times") if dead else contextlib.nullcontext():
        lab.start_base(begin, "/hydrus")
    assert events == ["begun", "ended"] * (starts - 1 + dead) + ["begun"] * (not dead)
