"""Every key of every kind of file, given what no flight can use: a one-line error or a success, and soon.

Each key meets the ends of its own range and some of the hostile values in turn, as many as it takes for all
of them to meet a key of each kind. Nothing flies; everything that is made before take-off is made.
"""

import copy
import itertools
import math
import re
import resource
import time
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from skylimb.base.config import from_mapping, put, write_toml
from skylimb.base.errors import SkylimbError
from skylimb.base.keys import keys_of, tables_of
from skylimb.base.keys.listing import KeyInfo, rows_of
from skylimb.control.controller import is_configurable, load_controller
from skylimb.flight.experiments.experiment import load_experiment
from skylimb.flight.takeoff import take_off
from skylimb.robots.loader import SHIPPED, load_flight_file, load_robot
from skylimb.studies.campaign.frozen import freeze
from skylimb.studies.campaign.spec import CampaignSpec

SECONDS, MEGABYTES, LETTERS = 8.0, 500.0, 1300
"""Longest that one value may take of a core, most memory that all of a kind may add, longest message."""

HOSTILE = (
    math.nan, math.inf, -math.inf, 1e308, -1e308, 2**70, 10**400, -1, 0, 1e-320, "", "x" * 500, "../../etc",
    "a\0b", "\udcff", [], [[]], {}, True, [1e308] * 4, list(range(20_000)), "20deg",
)  # fmt: skip

EXAMPLES = Path(__file__).parents[1] / "examples"

Try = Callable[[Any], object]


def ends(value: Any, info: KeyInfo) -> Iterator[Any]:
    """The ends of a key's range, in as many entries as its value has, and a little inside of an open one."""
    key = info.key
    bounds = [bound for bound in (key.low, key.high, key.above) if bound is not None and math.isfinite(bound)]
    if key.above == 0.0:
        bounds.append(1e-300)
    for bound in bounds:
        if isinstance(value, tuple) and value and isinstance(value[0], int | float):
            yield [bound] * len(value)
        else:
            yield int(bound) if isinstance(value, int) and not isinstance(value, bool) else bound


def trouble(tries: Iterator[tuple[str, Any, Try]]) -> list[str]:
    """What ended otherwise than in a one-line error of skylimb's or in success, or took too long."""
    found = []
    for key, value, attempt in tries:
        began, outcome = time.process_time(), ""
        try:
            attempt(value)
        except SkylimbError as error:
            if "\n" in str(error) or len(str(error)) > LETTERS:
                outcome = f"{len(str(error))} letters: {str(error)[:60]!r}"
            elif not re.search(rf"{key.rpartition('.')[2]}|\w\.[a-z_]+ |'[\w./-]+'", str(error)):
                outcome = f"not named: {str(error)[:150]}"
        except Exception as error:
            outcome = f"{type(error).__name__}: {str(error)[:60]}"
        taken = time.process_time() - began
        if outcome or taken > SECONDS:
            found.append(f"{key} = {str(value)[:40]!r}: {outcome or f'{taken:.1f} s'}")
    return found


def met(
    rows: Iterator[tuple[str, Any, KeyInfo]], attempt: Callable[[str], Try]
) -> Iterator[tuple[str, Any, Try]]:
    """Every key with its values."""
    hostile, known = itertools.cycle(HOSTILE), list(rows)
    share = math.ceil(len(HOSTILE) / len(known))
    for key, value, info in known:
        for given in (*ends(value, info), *itertools.islice(hostile, share)):
            yield key, given, attempt(key)


def memory() -> float:
    """Most memory that this process has had so far, MB."""
    return 1e-3 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


@pytest.mark.parametrize(
    "experiment",
    ["paper", *(pytest.param(name, marks=pytest.mark.slow) for name in ("heightmap", "sine_steep"))],
)
def test_an_experiment(experiment: str) -> None:
    rows = rows_of(tables_of(load_experiment(experiment)))
    if experiment != "paper":  # the others differ in their surface
        rows = (row for row in rows if row[0].startswith("surface."))
    take_off(experiment, ["hybrid"])
    before = memory()
    assert (
        trouble(met(rows, lambda key: lambda value: take_off(experiment, ["hybrid"], set={key: value}))) == []
    )
    assert memory() - before < MEGABYTES


@pytest.mark.parametrize("preset", ["hybrid", pytest.param("following", marks=pytest.mark.slow)])
def test_a_preset(preset: str) -> None:
    controller = load_controller(preset, load_robot("hydrus_xi_quad"))
    assert is_configurable(controller)
    rows = rows_of(controller.key_tables())
    before = memory()
    tries = met(
        iter(rows), lambda key: lambda value: take_off("paper", [preset], set={f"controller.{key}": value})
    )
    assert trouble(tries) == []
    assert memory() - before < MEGABYTES


def test_a_flight_file(tmp_path: Path) -> None:
    folder = SHIPPED / "hydrus_xi_quad"
    for file in folder.iterdir():
        if file.is_file():
            (tmp_path / file.name).write_bytes(file.read_bytes())
    raw = tomllib.loads((folder / "flight.toml").read_text())

    def attempt(key: str) -> Try:
        def load(value: Any) -> None:
            tables = copy.deepcopy(raw)
            put(tables, key, value)
            text = write_toml(tables)
            (tmp_path / "flight.toml").write_bytes(text.encode(errors="surrogateescape"))
            load_robot(tmp_path)

        return load

    before = memory()
    rows = rows_of(tables_of(load_flight_file("hydrus_xi_quad")))
    # The keys of the other rotors are those of the first.
    one = (row for row in rows if not re.match(r"rotors\.[1-9]", row[0]))
    assert trouble(met(one, attempt)) == []
    assert memory() - before < MEGABYTES


def test_a_campaign() -> None:
    raw = tomllib.loads((EXAMPLES / "campaign.toml").read_text())
    raw |= {
        "tune": tomllib.loads((EXAMPLES / "tune.toml").read_text())["tune"],
        "stop": {"until": "success", "width": 0.1},
        "controllers": ["hybrid"],
    }
    names = {"vary": "surface.friction", "success": "contact_fraction"}

    def attempt(key: str) -> Try:
        def begin(value: Any) -> None:
            tables = copy.deepcopy(raw)
            *above, last = (
                names[key.split(".", maxsplit=1)[0]] if part.startswith("<") else part
                for part in key.split(".")
            )
            node = tables
            for part in above:
                node = node.setdefault(part, {})
            node[last] = value
            freeze(from_mapping(CampaignSpec, tables, "mine.toml")).draw(0)

        return begin

    before = memory()
    # A campaign of a million draws is allowed, and takes its time to be checked.
    rows = ((key, info.default, info) for key, info in keys_of(CampaignSpec).items() if key != "draws")
    assert trouble(met(rows, attempt)) == []
    varied = ({"uniform": [0, 1e308]}, {"grid": list(range(100_000))}, {"normal": [0.0, 1e308]}, {"a": 1})
    assert trouble(("vary.<key>", value, attempt("vary.<key>")) for value in varied) == []
    assert memory() - before < MEGABYTES
