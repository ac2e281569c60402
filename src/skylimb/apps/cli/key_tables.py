"""The keys of an experiment, controller or robot, as a commented TOML file."""

from __future__ import annotations

import re
import sys
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from skylimb.base.keys import ANY_NAME, ANY_NUMBER, REQUIRED, KeyInfo, Table, rows_of

_WIDTH = 79
"""Columns of the comments in a TOML file."""


def for_a_person() -> bool:
    """Whether the output is a terminal, and not a file or another program."""
    return sys.stdout.isatty()


def show_keys(title: str, tables: Iterable[Table], hint: str) -> None:
    """Print every key with value, unit, range and meaning, as TOML that can be read back.

    Args:
        title: what it is that has these keys.
        tables: the keys.
        hint: how one of them is changed.
    """
    text = "\n".join(commented_toml(title, tables, hint))
    if not for_a_person():
        print(text)
        return
    from rich.console import Console
    from rich.syntax import Syntax

    Console().print(Syntax(text, "toml", theme="ansi_dark", background_color="default", word_wrap=True))


def example(tables: Iterable[Table]) -> str:
    """A key of the tables with its value, as `--set` takes it: the first one with a number."""
    rows = rows_of(table for table in tables if table.path)
    return next(
        (f"{name}={value:g}" for name, value, _ in rows if isinstance(value, float)), "TABLE.KEY=VALUE"
    )


def commented_toml(title: str, tables: Iterable[Table], hint: str) -> Iterator[str]:
    """The lines of a TOML file with every key, its meaning, range and unit above it.

    What has no value, or belongs to a table that is not there, is commented out.
    """
    import tomli_w

    yield from _comment(title)
    yield f"# {hint}"
    last: dict[str, Any] = {}
    explained: set[tuple[tuple[str, ...], str]] = set()
    for table in tables:
        off = "" if table.given else "# "
        kind = (table.path[:-1], table.meaning)
        again = bool(table.path) and table.path[-1].isdecimal() and kind in explained
        explained.add(kind)
        if table.path:
            yield ""
            yield from _comment("" if again else table.meaning)
            yield off + _header(table.path)
        for name, value, info in table.rows:
            if isinstance(value, dict):
                last |= {name: value} if value else {}
                continue
            if not again:
                yield ""
                yield from _comment(_explained(info))
            if value is None or value is REQUIRED:
                yield f"# {name} ="
            else:
                yield f"{off}{name} = {_toml(value)}"
    if last:
        yield from ("", tomli_w.dumps(last).rstrip())


def _comment(text: str) -> list[str]:
    return textwrap.wrap(text, _WIDTH, initial_indent="# ", subsequent_indent="# ")


def _header(path: Sequence[str]) -> str:
    """The header of a table; the place of an entry in a list becomes the double brackets of TOML."""
    if path[-1] == ANY_NUMBER or path[-1].isdecimal():
        return f"[[{'.'.join(path[:-1])}]]"
    names = ("NAME" if name == ANY_NAME else name for name in path)
    return f"[{'.'.join(name if re.fullmatch(r'[A-Za-z0-9_-]+', name) else repr(name) for name in names)}]"


def _explained(info: KeyInfo) -> str:
    allowed = "; ".join(filter(None, (info.unit, info.range)))
    return f"{info.meaning} ({allowed})" if info.meaning and allowed else info.meaning or allowed


def _toml(value: Any) -> str:
    """A value as TOML has it, on one line."""
    import tomli_w

    if isinstance(value, tuple | list):
        return f"[{', '.join(map(_toml, value))}]"
    return tomli_w.dumps({"value": value}).removeprefix("value = ").rstrip()
