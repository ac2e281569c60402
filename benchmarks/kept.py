"""Numbers that a benchmark keeps beside its page, and the tables that it writes into it."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any


def keep(file: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """One line a flight, four digits a number."""
    short = [{k: float(f"{v:.4g}") if isinstance(v, float) else v for k, v in row.items()} for row in rows]
    text = ",\n".join(json.dumps(row) for row in short)
    file.write_text(f"[\n{text}\n]\n", encoding="utf-8")


def fill(page: Path, name: str, table: str) -> None:
    """Put a table between the page's markers of that name."""
    begin, end = f"<!-- begin: {name} -->", f"<!-- end: {name} -->"
    pattern, new = f"{re.escape(begin)}.*?{re.escape(end)}", f"{begin}\n\n{table}\n\n{end}"
    text = page.read_text(encoding="utf-8")
    page.write_text(re.sub(pattern, lambda _: new, text, flags=re.DOTALL), encoding="utf-8")


def filled(page: Path, name: str) -> list[str]:
    """The lines that stand between the page's markers of that name."""
    found = re.search(f"<!-- begin: {re.escape(name)} -->(.*?)<!-- end:", page.read_text("utf-8"), re.DOTALL)
    return found[1].strip().splitlines() if found else []
