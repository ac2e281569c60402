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

_WIDTH = 79
"""Columns of the comments in a TOML file."""

_WIDEST_VALUE = 20
"""Columns of a value in a table; a longer one is cut."""


def for_a_person() -> bool:
    """Whether the output is a terminal, and not a file or another program."""
    return sys.stdout.isatty()


def show_keys(title: str, tables: Iterable[Table], hint: str) -> None:
    """Print every key with value, unit, range and meaning; into a pipe, as TOML that can be read back.

    Args:
        title: what it is that has these keys.
        tables: the keys.
        hint: how one of them is changed.
    """
    if not for_a_person():
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
    """Every key on a line, its meaning below, a heading for each table; `show_keys` has the arguments."""
    from rich.text import Text

    console.print(Text(title, "bold"))
    for table in tables:
        if not table.rows:
            continue
        heading = Text.assemble((_header(table.path), "bold"), " ", table.meaning) if table.path else Text()
        if not table.given:
            heading.append("  (not set)", "dim")
        console.print(Text())
        console.print(heading)
        for name, value, info in table.rows:
            print_key(console, name, _short(value), info.unit, info.range, info.meaning)
    console.print(Text())
    console.print(Text(hint))


def print_key(console: Console, name: str, value: str, unit: str, *details: str) -> None:
    """One key in a terminal: name, value and unit, and below them the details that there are."""
    from rich.padding import Padding
    from rich.text import Text

    console.print(Text.assemble((name, "cyan"), f" = {value} {unit}".rstrip()))
    told = "; ".join(filter(None, details))
    if told:
        console.print(Padding(Text(told, "dim"), (0, 0, 0, 4)))


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
