"""The keys of an experiment, controller or robot: a table for a terminal, a commented TOML file elsewhere."""

from __future__ import annotations

import re
import sys
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from skylimb.base.keys import ANY_NAME, ANY_NUMBER, REQUIRED, KeyInfo, Table, brief, rows_of

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table as Grid

_WIDTH = 79
"""Columns of the comments in a TOML file."""

_WIDEST_VALUE, _WIDEST_RANGE = 20, 24
"""Columns of a value and of a range in a table; a longer value is cut, a longer range takes more lines."""

_COLUMNS = ("Key", "Value", "Unit", "Range", "Meaning")

_NARROW = 110
"""Columns of a terminal below which the meaning of a key goes under the key."""


def show(title: str, tables: Iterable[Table], hint: str) -> None:
    """Print every key with value, unit, range and meaning; into a pipe, as TOML that can be read back.

    Args:
        title: what it is that has these keys.
        tables: the keys.
        hint: how one of them is changed.
    """
    if not sys.stdout.isatty():
        print("\n".join(commented_toml(title, tables, hint)))
        return
    from rich.console import Console

    print_tables(Console(highlight=False), title, tables, hint)


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


def print_tables(console: Console, title: str, tables: Iterable[Table], hint: str) -> None:
    """Every key in columns, a heading for each table; `show` says what the arguments are."""
    from rich.text import Text

    tables = [table for table in tables if table.rows]
    cells = [_COLUMNS, *(_cells(row) for table in tables for row in table.rows)]
    widths = [min(_WIDEST_RANGE, max(len(row[column]) for row in cells)) for column in range(4)]
    narrow = console.width < _NARROW
    console.print(Text(title, "bold"))
    console.print()
    if not narrow:
        console.print(_grid([_COLUMNS], widths, "bold"))
    for table in tables:
        heading = Text.assemble((_header(table.path), "bold"), " ", table.meaning) if table.path else Text()
        if not table.given:
            heading.append("  (not set)", "dim")
        console.print(heading)
        if narrow:
            _print_stacked(console, table, widths)
        else:
            console.print(_grid(map(_cells, table.rows), widths, "" if table.given else "dim"))
        console.print()
    console.print(Text(hint))


def _grid(rows: Iterable[Sequence[str]], widths: Sequence[int], style: str) -> Grid:
    from rich.table import Table as Grid
    from rich.text import Text

    grid = Grid(box=None, show_header=False, pad_edge=False, padding=(0, 2, 0, 0))
    for width, colour in zip(widths, ("cyan", "", "", ""), strict=True):
        grid.add_column(min_width=width, max_width=width, style=colour)
    grid.add_column(style="dim")
    for row in rows:
        grid.add_row(*map(Text, row), style=style)
    return grid


def _print_stacked(console: Console, table: Table, widths: Sequence[int]) -> None:
    """The meaning of each key on lines of its own, for a terminal with few columns."""
    from rich.padding import Padding
    from rich.text import Text

    for row in table.rows:
        name, value, unit, allowed, meaning = _cells(row)
        style = "" if table.given else "dim"
        line = Text.assemble(
            (name.ljust(widths[0]), "cyan"),
            "  ",
            (f"{value} {unit}".ljust(widths[1] + 1 + widths[2]), style),
        )
        beside = len(line) + 2 + len(allowed) <= console.width
        console.print(line.append(f"  {allowed}") if beside else line)
        for text in ("" if beside else allowed, meaning):
            if text:
                console.print(Padding(Text(text, "dim"), (0, 0, 0, 4)))


def _cells(row: tuple[str, Any, KeyInfo]) -> tuple[str, ...]:
    """Entries of the five columns."""
    name, value, info = row
    return name, _short(value), info.unit, info.range, info.meaning


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


def _short(value: Any) -> str:
    """A value as TOML has it, numbers with few digits, and cut where it is long."""
    text = brief(value)
    return text if len(text) <= _WIDEST_VALUE else f"{text[: _WIDEST_VALUE - 3]}..."
