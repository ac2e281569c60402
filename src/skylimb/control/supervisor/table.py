"""The supervisor's table: read once, checked, and decided by, in numbers and in symbols alike."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from skylimb.base.config import read_toml
from skylimb.base.errors import ConfigError, unknown_name
from skylimb.symbolic import where

FILE = Path(__file__).parent / "table.toml"
MOST_ROWS, MOST_BITS = 40, 20


@dataclass(frozen=True)
class Row:
    """One row: from these modes, with all of these bits and none of those, to that mode."""

    source: tuple[str, ...]
    when: tuple[str, ...]
    unless: tuple[str, ...]
    to: str


@dataclass(frozen=True)
class Table:
    """Modes and bits with their meanings, in their order, and the rows."""

    modes: Mapping[str, str]
    bits: Mapping[str, str]
    rows: tuple[Row, ...]

    def mode(self, name: str) -> float:
        """The number of a mode."""
        return float(list(self.modes).index(name))

    def decided(self, mode: Any, bits: Mapping[str, Any]) -> Any:
        """The mode that follows.

        Args:
            mode: number of the present one: a float, an array or a symbol.
            bits: 0 or 1 by name, of the same kind.
        """
        # A number that is no mode comes from memory that something else wrote into.
        known: Any = sum(((mode == self.mode(name)) * 1.0 for name in self.modes), start=0.0)
        new = where(known > 0.5, mode, self.mode("DESCEND"))
        for row in reversed(self.rows):
            matches: Any = sum(((mode == self.mode(name)) * 1.0 for name in row.source), start=0.0)
            for name in row.when:
                matches = matches * bits[name]
            for name in row.unless:
                matches = matches * (1.0 - bits[name])
            new = where(matches > 0.5, self.mode(row.to), new)
        return new


def table_from(tables: Mapping[str, Any]) -> Table:
    """A table from its file's content.

    Raises:
        ConfigError: for a name that is unknown, a row without a condition, or too many of something.
    """
    modes, bits = tables["modes"], tables["bits"]
    rows = tuple(
        Row(_known("mode", row["from"], modes), _known("bit", row.get("when", ()), bits),
            _known("bit", row.get("unless", ()), bits), *_known("mode", [row["to"]], modes))
        for row in tables["rows"]
    )  # fmt: skip
    if len(rows) > MOST_ROWS or len(bits) > MOST_BITS:
        raise ConfigError(
            f"the supervisor's table has {len(rows)} rows and {len(bits)} bits; at most {MOST_ROWS} and "
            f"{MOST_BITS} can be read in one sitting"
        )
    for number, row in enumerate(rows, 1):
        if not row.source or not (row.when or row.unless):
            raise ConfigError(f"row {number} of the supervisor's table names no mode or no bit")
    return Table(modes, bits, rows)


def _known(what: str, names: Sequence[str], known: Mapping[str, Any]) -> tuple[str, ...]:
    for name in names:
        if name not in known:
            raise unknown_name(f"{what} of the supervisor's table", name, known)
    return tuple(names)


TABLE = table_from(read_toml(FILE))
"""The table that flies."""

RETREAT, DESCEND, CUT = map(TABLE.mode, ("RETREAT", "DESCEND", "CUT"))
"""Numbers of the modes of a flight that is broken off, which are the last ones."""
