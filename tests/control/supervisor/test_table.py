"""The supervisor's table: every entry, and what is proven of it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import casadi as ca
import numpy as np
import pytest

from skylimb.base.c_code import c_source
from skylimb.base.config import read_toml
from skylimb.base.errors import ConfigError, UnknownNameError
from skylimb.control.supervisor.table import FILE, MOST_ROWS, TABLE, table_from
from skylimb.simulation.compiling import built_library

T = TABLE
MODES, BITS = list(T.modes), list(T.bits)
PART = 1 << 14
"""Entries that C is asked of at once; a larger map takes long to build."""
BROKEN_OFF = ("RETREAT", "DESCEND", "CUT")


def every_entry() -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Every mode with every combination of bits."""
    words = np.arange(len(MODES) << len(BITS))
    bits = {name: ((words >> place) & 1).astype(float) for place, name in enumerate(BITS)}
    return (words >> len(BITS)).astype(float), bits


def word_of(names: Iterable[str]) -> int:
    """Bits as one whole number."""
    return sum(1 << BITS.index(name) for name in names)


def first_match(modes: Any, words: Any) -> np.ndarray:
    """The table as a person reads it: from the top, the first row that matches a mode and its bits."""
    modes, words = np.broadcast_arrays(np.asarray(modes, dtype=int), words)
    new, open_ = modes.copy(), np.ones(words.shape, dtype=bool)
    for row in T.rows:
        when, unless = word_of(row.when), word_of(row.unless)
        here = open_ & np.isin(modes, [MODES.index(name) for name in row.source])
        here &= (words & when == when) & (words & unless == 0)
        new[here], open_ = MODES.index(row.to), open_ & ~here
    return new


@pytest.fixture(scope="module")
def decided() -> np.ndarray:
    modes, bits = every_entry()
    return T.decided(modes, bits)


def test_the_first_row_that_matches_decides_in_every_entry(decided: np.ndarray) -> None:
    words = np.arange(len(decided))
    read = first_match(words >> len(BITS), words & (1 << len(BITS)) - 1)
    odd = np.flatnonzero(decided != read)
    assert [(MODES[word >> len(BITS)], f"{word & (1 << len(BITS)) - 1:b}") for word in odd[:5]] == []


def test_c_decides_as_python_in_every_entry(decided: np.ndarray) -> None:
    mode, bits = ca.SX.sym("mode"), ca.SX.sym("bits", len(BITS))
    new = T.decided(mode, dict(zip(BITS, ca.vertsplit(bits), strict=True)))
    function = ca.Function("decide", [mode, bits], [new])
    compiled = ca.external("decide", str(built_library("native", "decide", c_source(function))))
    modes, seen = every_entry()
    many, bits = compiled.map(PART), np.array(list(seen.values()))
    parts = [slice(first, first + PART) for first in range(0, len(modes), PART)]
    found = [many(modes[None, part], bits[:, part]).full().ravel() for part in parts]
    np.testing.assert_array_equal(np.concatenate(found), decided)


@pytest.mark.parametrize("spoilt", [-1.0, 0.5, 5.0, 1e9, np.nan])
def test_a_number_that_is_no_mode_descends(spoilt: float) -> None:
    assert T.decided(spoilt, dict.fromkeys(BITS, 0.0)) == T.mode("DESCEND")


def test_it_latches_but_for_a_coast(decided: np.ndarray) -> None:
    modes, _ = every_entry()
    backwards = decided < modes
    assert (modes[backwards] == T.mode("COAST")).all()
    assert (decided[backwards] == T.mode("NORMAL")).all()
    assert backwards.any()
    assert (decided[modes == T.mode("CUT")] == T.mode("CUT")).all()


def test_nothing_bad_is_flown_through(decided: np.ndarray) -> None:
    """A flight goes on with its mission only where nothing is wrong, or it is pushed."""
    _, bits = every_entry()
    normal = decided == T.mode("NORMAL")
    for name in set(BITS) - {"spent", "pushed"}:
        assert not bits[name][normal].any(), name


# A fault that lasts: the bits that it sets by and by, in the order in which time sets them.
LASTING: dict[str, tuple[tuple[str, ...], ...]] = {
    "no pose": (("stale",), ("stale", "blind"), ("stale", "blind", "lost")),
    "no command": (("late",), ("late", "silent")),
    "no joint angles": (("numb",),),
    "nothing new of an IMU": (("deaf",),),
    "a landing was ordered": (("land",),),
    "a stop was ordered": (("stop",),),
    "it has tipped over": (("upset",),),
}


@pytest.mark.parametrize("fault", LASTING)
def test_a_lasting_fault_ends_broken_off_from_wherever_it_finds_the_flight(fault: str) -> None:
    own = word_of({bit for step in LASTING[fault] for bit in step})
    beside = np.flatnonzero(np.arange(1 << len(BITS)) & own == 0)  # whatever else is seen
    now = np.repeat(np.arange(len(MODES))[:, None], len(beside), axis=1)
    for step in LASTING[fault]:
        now = first_match(now, beside | word_of(step))
    assert np.isin(now, [MODES.index(name) for name in BROKEN_OFF]).all()
    if fault in ("no pose", "a stop was ordered", "it has tipped over"):
        assert (now == MODES.index("CUT")).all()


def test_a_descent_ends() -> None:
    words = np.arange(1 << len(BITS))
    spent = words[words & word_of(["spent"]) > 0]
    assert (first_match(MODES.index("DESCEND"), spent) == MODES.index("CUT")).all()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"from": ["NORMAL"], "when": ["stael"], "to": "COAST"}, "stale"),
        ({"from": ["NROMAL"], "when": ["stale"], "to": "COAST"}, "NORMAL"),
        ({"from": ["NORMAL"], "when": ["stale"], "to": "COST"}, "COAST"),
        ({"from": ["NORMAL"], "to": "COAST"}, "row 1 of the supervisor's table names no mode or no bit"),
    ],
)
def test_a_row_that_makes_no_sense_is_refused(change: dict[str, Any], message: str) -> None:
    with pytest.raises((ConfigError, UnknownNameError), match=message):
        table_from({**read_toml(FILE), "rows": [change]})


def test_a_table_that_nobody_reads_in_one_sitting_is_refused() -> None:
    tables = read_toml(FILE)
    with pytest.raises(ConfigError, match="at most 40"):
        table_from({**tables, "rows": tables["rows"][:1] * (MOST_ROWS + 1)})
