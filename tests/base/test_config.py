import copy
import math
import tomllib
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skylimb.base import config
from skylimb.base.errors import ConfigError, UnknownNameError
from skylimb.base.keys import Key, configuration


@configuration
class Wall:
    friction: Annotated[float, Key("", "of the wall", low=0.0, high=10.0)] = 0.4
    slope: Annotated[float, Key("rad", "of the wall", low=-1.5, high=1.5)] = 0.35


@dataclass(frozen=True)
class Path2:
    radius: float = 0.3
    shape: Literal["circle", "line"] = "circle"
    points: tuple[tuple[float, float], ...] = ()
    start: tuple[float, float, float] = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Whole:
    seed: int = 0
    name: str = "whole"
    quick: bool = False
    rate: float | None = None
    wall: Wall = field(default_factory=Wall)
    path: Path2 = field(default_factory=Path2)
    extra: Wall | None = None
    walls: dict[str, Wall] = field(default_factory=dict)
    list_of_walls: tuple[Wall, ...] = ()


@dataclass(frozen=True)
class Demanding:
    mass: float


numbers = st.floats(-1e6, 1e6, allow_nan=False)
walls = st.builds(Wall, friction=st.floats(0, 10), slope=st.floats(-1.5, 1.5))
points = st.lists(st.tuples(numbers, numbers), max_size=4).map(tuple)
paths = st.builds(Path2, radius=numbers, points=points, start=st.tuples(numbers, numbers, numbers))
names = st.text("abcdefgh_", min_size=1, max_size=6)
wholes = st.builds(
    Whole,
    seed=st.integers(-(2**53), 2**53),
    name=st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\r"), max_size=20),
    quick=st.booleans(),
    rate=st.none() | numbers,
    wall=walls,
    path=paths,
    extra=st.none() | walls,
    walls=st.dictionaries(names, walls, max_size=3),
    list_of_walls=st.lists(walls, max_size=3).map(tuple),
)


@given(wholes)
def test_a_configuration_survives_toml(whole):
    assert config.from_mapping(Whole, tomllib.loads(config.write_toml(whole)), "text") == whole


@given(wholes)
def test_flat_keys_rebuild_the_configuration(whole):
    flat = config.flatten(whole)
    assert all(not isinstance(value, dict) for value in flat.values())
    empties = Whole(walls=whole.walls, list_of_walls=whole.list_of_walls, extra=whole.extra)
    assert config.with_overrides(empties, flat) == whole


def test_defaults_and_integers_for_floats():
    whole = config.from_mapping(Whole, {"wall": {"friction": 1}, "rate": 40}, "text")
    assert whole.wall == Wall(friction=1.0)
    assert isinstance(whole.wall.friction, float)
    assert whole.rate == 40.0


def test_numpy_values_are_taken_and_given_back_as_python():
    whole = config.from_mapping(
        Whole,
        {"seed": np.int64(3), "path": {"start": np.arange(3.0), "points": [(1, np.float64(2))]}},
        "text",
    )
    assert whole.path == Path2(start=(0.0, 1.0, 2.0), points=((1.0, 2.0),))
    assert type(config.to_mapping({"a": np.float64(1)})["a"]) is float


@pytest.mark.parametrize(
    ("tables", "kind", "words"),
    [
        ({"wal": {}}, UnknownNameError, ["unknown key 'wal'", "did you mean 'wall'?"]),
        ({"wall": {"fricton": 1}}, UnknownNameError, ["'wall.fricton'", "did you mean 'wall.friction'?"]),
        ({"radius": 1}, UnknownNameError, ["unknown key 'radius'", "did you mean 'path.radius'?"]),
        ({"extra": {"slop": 1}}, UnknownNameError, ["'extra.slop'", "did you mean 'extra.slope'?"]),
        ({"walls": {"left": {"slop": 1}}}, UnknownNameError, ["'walls.left.slop'", "'walls.left.slope'"]),
        ({"list_of_walls": [{}, {"slop": 1}]}, UnknownNameError, ["'list_of_walls.1.slop'"]),
        (
            {"wall": {"friction": "wet"}},
            ConfigError,
            ["wall.friction = 'wet'", "expected a number, got text"],
        ),
        (
            {"wall": {"friction": True}},
            ConfigError,
            ["wall.friction = True", "expected a number, got true or false"],
        ),
        ({"seed": 1.5}, ConfigError, ["seed = 1.5", "expected a whole number, got a number"]),
        ({"wall": 3}, ConfigError, ["wall = 3", "table"]),
        ({"path": {"start": [1, 2]}}, ConfigError, ["path.start = [1, 2]", "has 2 entries, it needs 3"]),
        ({"walls": [{"slope": 1}]}, ConfigError, ["walls = [", "expected a table, got a list"]),
        (
            {"path": {"points": [[1, 2], [3, "x"]]}},
            ConfigError,
            ["path.points", "expected a number, got text"],
        ),
        (
            {"path": {"shape": "cirle"}},
            ConfigError,
            ["path.shape = 'cirle'", "'circle'", "did you mean 'circle'?"],
        ),
        ({"wall": {"slope": 20}}, ConfigError, ["wall.slope = 20 rad", "degrees", "20 deg = 0.3491 rad"]),
        ({"wall": {"friction": -1}}, ConfigError, ["wall.friction = -1 is outside of 0 .. 10"]),
        ({"wall": {"friction": math.nan}}, ConfigError, ["wall.friction = nan"]),
    ],
)
def test_a_wrong_value_is_named_on_one_line(tables, kind, words):
    with pytest.raises(kind) as caught:
        config.from_mapping(Whole, tables, "some.toml")
    message = str(caught.value)
    assert message.startswith("some.toml: ")
    assert "\n" not in message
    for word in words:
        assert word in message


def test_a_part_of_a_table_is_named_in_full():
    with pytest.raises(UnknownNameError, match=r"unknown key 'surface\.slop'; did you mean 'surface\.slope'"):
        config.from_mapping(Wall, {"slop": 1}, "text", at="surface")


def test_a_missing_key_is_named():
    with pytest.raises(ConfigError, match="the key 'mass' is missing"):
        config.from_mapping(Demanding, {}, "text")


def test_overrides_merge_and_keep_the_rest():
    whole = Whole(wall=Wall(0.1, 0.2), extra=Wall())
    changed = config.with_overrides(whole, {"wall": {"slope": -0.1}, "path.radius": 0.2, "extra": None})
    assert changed == Whole(wall=Wall(0.1, -0.1), path=Path2(radius=0.2))
    assert whole.wall.slope == 0.2
    assert config.with_overrides(whole, {"walls.left.friction": 0.7}).walls == {"left": Wall(0.7)}


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("wall.frction", "did you mean 'wall.friction'"),
        ("friction", "did you mean '"),
        ("seed.x", "'seed' is a single"),
    ],
)
def test_an_unknown_override_is_named(key, words):
    with pytest.raises(ConfigError, match=words):
        config.with_overrides(Whole(), {key: 1.0})


LISTED = {"events": [{"kind": "push", "force": [1.0, 0.0]}, {"kind": "gain"}], "none": [], "one": 3}


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("events.0.force", [1.0, 0.0]),
        ("events.0.force.1", 0.0),
        ("events.1", {"kind": "gain"}),
        ("events.2", None),
        ("events.-1", None),
        ("events.kind", None),
        ("none.0", None),
        ("one.0", None),
        ("events.0.kind.0", None),
    ],
)
def test_a_number_in_a_key_is_the_place_of_a_lists_entry(key, value):
    assert config.value_of(LISTED, key) == value


def test_a_value_is_put_into_an_entry_of_a_list():
    tables = copy.deepcopy(LISTED)
    config.put(tables, "events.0.force", [0.0, 2.0])
    config.put(tables, "events.0.force.1", 5.0)
    config.put(tables, "events.0.more.deep", 1)
    config.put(tables, "events.1", {"kind": "surface"})
    config.put(tables, "none", [1])
    assert tables == {
        "events": [{"kind": "push", "force": [0.0, 5.0], "more": {"deep": 1}}, {"kind": "surface"}],
        "none": [1],
        "one": 3,
    }


@pytest.mark.parametrize(
    ("key", "words"),
    [
        (
            "events.2.force",
            r"key 'events\.2\.force': 'events' is a list without an entry '2' \(entries: 0 \.\. 1\)",
        ),
        ("events.2", r"'events' is a list without an entry '2'"),
        ("events.-1.force", r"without an entry '-1'"),
        ("events.force", r"'events' is a list without an entry 'force' \(entries: 0 \.\. 1\)"),
        ("events.0.force.2", r"'events\.0\.force' is a list without an entry '2'"),
        (
            "none.0",
            r"'none' is a list without an entry '0' \(entries: none, it is empty: set the whole list",
        ),
        ("none.0.force", r"'none' is a list without an entry '0'"),
        ("one.0", r"'one' is a single value, it has no key '0'"),
        ("events.0.kind.0", r"'events\.0\.kind' is a single value, it has no key '0'"),
    ],
)
def test_an_entry_that_a_list_does_not_have_is_named(key, words):
    tables = copy.deepcopy(LISTED)
    with pytest.raises(ConfigError, match=words):
        config.put(tables, key, 1.0)
    assert tables == LISTED


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a.b=0.3", ("a.b", 0.3)),
        (" a = -1 ", ("a", -1)),
        ("a=-2.", ("a", -2.0)),
        ("a=.5", ("a", 0.5)),
        ("a=circle", ("a", "circle")),
        ("a=./my file.toml", ("a", "./my file.toml")),
        ("a='x=y'", ("a", "x=y")),
        ("a=true", ("a", True)),
        ("a=[1, 2.5]", ("a", [1, 2.5])),
        ("a=20deg", ("a", "20deg")),
        ("a={b = 1}", ("a", {"b": 1})),
    ],
)
def test_assignments(text, expected):
    assert config.parse_assignment(text) == expected


_SCALARS = st.one_of(
    st.integers(-(2**62), 2**62),
    st.floats(allow_nan=False),
    st.booleans(),
    st.text(st.characters(categories=("L", "N", "P", "S", "Zs"))),
)
_KEYS = st.text(st.sampled_from("ab. ü-'\""), min_size=1)


@given(st.recursive(_SCALARS, lambda inner: st.lists(inner) | st.dictionaries(_KEYS, inner), max_leaves=8))
def test_any_value_survives_an_assignment(value):
    assert config.parse_assignment(f"a={config.toml_value(value)}") == ("a", value)


@pytest.mark.parametrize("text", ["", "a", "a=", "=3", "a..b=1", "a=[1,", "a='x", "a=1\nb=2", "a={b"])
def test_broken_assignments_are_refused(text):
    with pytest.raises(ConfigError, match="cannot read"):
        config.parse_assignment(text)


def test_unreadable_files_are_named(tmp_path):
    (tmp_path / "paper.toml").write_text("a = 1\na = 2\n")
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(ConfigError, match=r"no such file: .*did you mean '.*paper\.toml'"):
        config.read_toml(tmp_path / "papr.toml")
    with pytest.raises(ConfigError, match="not valid TOML"):
        config.read_toml(tmp_path / "paper.toml")
    with pytest.raises(ConfigError, match="not UTF-8"):
        config.read_toml(tmp_path / "bytes.toml")
    with pytest.raises(ConfigError, match="cannot read"):
        config.read_toml(tmp_path)
    with pytest.raises(ConfigError, match="no such file"):
        config.read_toml(Path("nowhere") / "at" / "all.toml")


DEEP = {
    "brackets": "a = " + "[" * 100_000 + "]" * 100_000,
    "tables": "a = " + "{b=" * 50_000 + "1" + "}" * 50_000,
    "lists in reach of the parser": "a = " + "[" * 40 + "]" * 40,
    "dots": "a" + ".a" * 100_000 + " = 1",
    "dots of a header": "[" + "a . " * 50_000 + "a]",
    "dots between quotes": '"a"' + ".'a'" * 50_000 + " = 1",
    "digits": "a = " + "9" * 100_000,
}


@pytest.mark.parametrize("text", DEEP.values(), ids=DEEP)
def test_what_is_nested_without_end_is_refused_at_once(tmp_path, text):
    (tmp_path / "deep.toml").write_text(text)
    with pytest.raises(ConfigError, match=r"not valid TOML: (more than 32 tables|Exceeds the limit)"):
        config.read_toml(tmp_path / "deep.toml")


def test_a_setting_is_as_shallow_as_a_file():
    for text in ("a=" + "[" * 100_000, ".".join("a" * 50_000) + "=1"):
        with pytest.raises(ConfigError, match=r"cannot read the value|has 50000 parts, more than 32"):
            config.parse_assignment(text)


def test_half_a_character_is_no_text():
    for table in ({"fluid": "\udcff"}, {"\udcff": 1.0}):
        with pytest.raises(ConfigError):
            config.from_mapping(Wall, table, "here")


def test_the_examples_here_cover_every_field():
    assert {item.name for item in fields(Whole)} == set(config.to_mapping(Whole(rate=1.0, extra=Wall())))
