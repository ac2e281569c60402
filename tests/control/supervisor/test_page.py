"""Pages about the supervisor: their drawing is that of the table, the tests that they name are there."""

from __future__ import annotations

import ast
import re
import runpy
from pathlib import Path

from skylimb.control.supervisor.table import TABLE

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs" / "supervisor.md").read_text(encoding="utf-8")
SEEN = (ROOT / "docs" / "reports" / "supervisor.md").read_text(encoding="utf-8")


def test_the_drawing_is_that_of_the_table() -> None:
    made = runpy.run_path(str(ROOT / "docs" / "supervisor.py"))
    assert made["FILE"].read_text(encoding="utf-8") == made["drawing"](), "python docs/supervisor.py"


def test_the_page_has_every_mode_and_counts_the_entries() -> None:
    for name in TABLE.modes:
        assert f"\n| {name} |" in PAGE
    entries = len(TABLE.modes) << len(TABLE.bits)
    assert f"{len(TABLE.modes)} modes and {len(TABLE.bits)} bits: {entries:,} entries" in SEEN


def test_every_test_that_the_pages_name_is_there() -> None:
    named = re.findall(r"`(tests/[\w/]+\.py)(?:::(\w+))?`", PAGE + SEEN)
    assert len(named) > 40
    for file, test in named:
        tree = ast.parse((ROOT / file).read_text(encoding="utf-8"))
        functions = {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}
        assert not test or test in functions, f"{file}::{test}"
