"""What is said to mistakes is what docs/reports/mistakes.md says: one line, exit code 2, nothing written."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest


def _load() -> ModuleType:
    place = Path(__file__).with_name("mistakes.py")
    spec = importlib.util.spec_from_file_location("mistakes", place)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


mistakes = _load()


@pytest.mark.parametrize("command", mistakes.COMMANDS)
def test_a_mistake_is_one_line_and_leaves_nothing(command: str) -> None:
    code, said, files = mistakes.answer(command)
    assert code == 2
    assert said.startswith("skylimb: error: ")
    assert said.count("\n") == 1
    assert len(said) < 700
    assert files == set(mistakes.FILES)


def test_the_page_says_what_is_said() -> None:
    assert mistakes.PAGE.read_text(encoding="utf-8") == mistakes.page(), "write it: python tests/mistakes.py"
