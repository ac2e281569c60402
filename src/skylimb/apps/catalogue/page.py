"""The page of the docs with every key, written from the same declarations that check them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from skylimb.apps.catalogue.entries import Entry, entries, tables_of_entry
from skylimb.base.keys import Table, brief, tables_of
from skylimb.flight.experiments.experiment import Settings
from skylimb.simulation.surfaces.surface_keys import SurfaceKeys

_HEAD = """\
# Keys

Everything that a configuration can say, written by `skylimb keys --page docs/keys.md` from the declarations
that check it. `skylimb keys WORD` searches it, `skylimb show NAME` shows one thing with its values. A key of
an experiment is changed by `--set KEY=VALUE`, a key of a controller by `--set controller.KEY=VALUE`.

In an editor: `skylimb keys --schema DIR` writes JSON schemas. With the extension Even Better TOML, VS Code
completes and checks a file whose first line names one, as in `#:schema DIR/experiment.schema.json`.
"""

_EVENTS = "What happens in flight: tables `[[events]]` of an experiment. `kind` names one."
_LAWS = "A controller has six slots; `controller.SLOT.law` names the law of each."


def keys_page() -> str:
    """The page as Markdown."""
    return "\n".join(_lines()) + "\n"


def _lines() -> Iterator[str]:
    known = entries()
    yield _HEAD
    yield "## Experiment\n"
    for table in tables_of(Settings):
        yield from _section(table)
    yield "## Surfaces\n"
    yield "`surface.kind` names one. All of them have these keys.\n"
    shared = list(tables_of(SurfaceKeys, ("surface",)))
    for table in shared:
        yield from _section(table)
    for entry in _of(known, "surface"):
        yield f"### {entry.short}\n"
        yield f"{entry.meaning}\n"
        yield from _rows([_less(table, shared) for table in tables_of_entry(entry)])
    yield from _entries(known, "event", "Events", _EVENTS)
    yield "## Paths\n"
    yield "`trajectory.shape` names one.\n"
    for entry in _of(known, "path"):
        yield f"- `{entry.short}`" + f": {entry.meaning}" * bool(entry.meaning)
    yield ""
    yield from _entries(known, "law", "Controllers", _LAWS)
    for entry in _of(known, "file"):
        yield f"## {'Campaign' if entry.name == 'campaign' else 'Robot: flight.toml'}\n"
        for table in tables_of_entry(entry):
            yield from _section(table)
    yield "## Metrics\n"
    yield from ("| Metric | What it is |", "|---|---|")
    for entry in _of(known, "metric"):
        yield f"| `{entry.short}` | {_cell(entry.meaning)} |"


def _entries(known: Iterable[Entry], kind: str, title: str, introduction: str) -> Iterator[str]:
    """A section with every entry of a kind and its keys."""
    yield f"## {title}\n"
    yield f"{introduction}\n"
    for entry in _of(known, kind):
        yield f"### {entry.name}\n"
        yield f"{entry.meaning}\n"
        yield from _rows(tables_of_entry(entry))


def _of(known: Iterable[Entry], kind: str) -> list[Entry]:
    return [entry for entry in known if entry.kind == kind]


def _less(table: Table, shared: Iterable[Table]) -> Table:
    """The rows of a table that are not those of all surfaces."""
    common = {(each.path, name): info for each in shared for name, _, info in each.rows}
    rows = tuple(
        row
        for row in table.rows
        if row[0] != "kind"
        and ((table.path, row[0]) not in common or common[table.path, row[0]].default != row[2].default)
    )
    return Table(table.path, table.meaning, rows, table.given)


def _section(table: Table) -> Iterator[str]:
    if table.path and table.rows:
        yield f"### [{'.'.join(table.path)}]\n"
        yield f"{table.meaning}\n"
    yield from _rows([table])


def _rows(tables: Iterable[Table]) -> Iterator[str]:
    rows = [(".".join((*table.path, name)), info) for table in tables for name, _, info in table.rows]
    if not rows:
        return
    yield from ("| Key | Default | Unit | Range | Meaning |", "|---|---|---|---|---|")
    for key, info in rows:
        cells = (f"`{key}`", _code(brief(info.default)), info.unit, info.range, info.meaning)
        yield f"| {' | '.join(map(_cell, cells))} |"
    yield ""


def _code(text: str) -> str:
    return "" if text in ("-", '""', "[]", "{}") else f"`{text}`"


def _cell(text: str) -> str:
    return text.replace("|", "\\|")
