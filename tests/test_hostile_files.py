"""Files that ask for more than a machine has: each is read, or refused in a line, and soon.

They are made here (`tests/helpers/hostile_files.py`, which as a program prints a table of what each takes).
"""

import os
from pathlib import Path

import pytest

from hostile_files import FILES, made, said
from skylimb.control.planning import svg_lines

SECONDS, LETTERS = 8.0, 600
"""Longest that one file may take of a core: four times what it takes on one that does nothing else."""

READ = {"many_keys.toml", "long_list.toml", "triangles.stl"}
"""Large, but no more than files of their kind may be."""


@pytest.mark.parametrize("name", FILES)
def test_a_hostile_file_is_refused_in_a_line_and_soon(
    tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(svg_lines, "SECONDS", 0.2)  # each takes far more, in a process of its own
    path = made(tmp_path, name)
    began = sum(os.times()[:4])  # with what is read in a process of its own
    words = said(path)
    assert sum(os.times()[:4]) - began < SECONDS
    assert (words == "read") == (name in READ)
    assert "\n" not in words
    assert len(words) < LETTERS
