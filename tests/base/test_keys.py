import dataclasses
import math
import pickle
import tomllib
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skylimb.base.config import from_mapping, to_mapping, with_overrides, write_toml
from skylimb.base.errors import ConfigError
from skylimb.base.keys import (
    REQUIRED,
    Key,
    RefusedError,
    configuration,
    described,
    is_configuration,
    keys_of,
    refused,
    tables_of,
    units_of,
)

DEPTH = Key("m", "how far", low=0.0, high=0.6)
SPEED = Key("m/s", "how fast", above=0.0, below=5.0)


@configuration
class Joint:
    """A part of a part."""

    angle: Annotated[float, Key("rad", "how it stands", low=-1.5, high=1.5)] = 0.0


@configuration
class Arm:
    """Values of every kind."""

    depth: Annotated[float, DEPTH] = 0.18
    speed: Annotated[float, SPEED] = 0.1
    count: Annotated[int, Key("", "how many", low=1, high=10)] = 2
    damping: Annotated[float | None, Key("N s/m", "how stiff", low=0.0, high=1e4)] = None
    limit: Annotated[float, Key("", "inf for none", low=0.0, high=math.inf, finite=False)] = math.inf
    offset: Annotated[tuple[float, float, float], Key("m", "where", low=-0.2, high=0.2)] = (0.0, 0.0, 0.0)
    scales: Annotated[tuple[float, ...], Key("", "each", low=0.0, high=1.5)] = ()
    points: Annotated[tuple[tuple[float, float], ...], Key("m", "corners", low=-10, high=10)] = ()
    ranges: Annotated[dict[str, float], Key("s", "by name", low=0.0, high=9.0)] = field(default_factory=dict)
    value: Annotated[float | tuple[float, ...], Key("", "any", low=-math.inf, high=math.inf)] = 0.0
    shape: Annotated[Literal["circle", "line"], Key("", "which path")] = "circle"
    turn: Annotated[Literal[1, -1], Key("", "which way")] = 1
    quick: Annotated[bool, Key("", "whether in haste")] = False
    file: Annotated[str, Key("", "where it stands")] = ""
    joint: Joint = field(default_factory=Joint)
    spare: Joint | None = None
    named: dict[str, Joint] = field(default_factory=dict)
    row: tuple[Joint, ...] = ()

    def check(self) -> None:
        if self.speed > 10.0 * self.depth + 4.0:
            raise refused(self, "speed", "is too fast for so small a depth")


@configuration
class Whole:
    """A table with tables."""

    seed: Annotated[int, Key("", "of the noise", low=0, high=2**63 - 1)] = 0
    arm: Arm = field(default_factory=Arm)


@configuration
class LongArm(Arm):
    """An heir, with one key more and a check of its own."""

    length: Annotated[float, Key("m", "of the whole", low=0.1, high=9.0)] = 1.0
    depth: float = 0.5

    def check(self) -> None:
        super().check()
        if self.length < self.depth:
            raise refused(self, "length", "is less than the depth")


GOOD = {
    "depth": st.floats(0.0, 0.6),
    "count": st.integers(1, 10),
    "damping": st.none() | st.floats(0.0, 1e4),
    "offset": st.tuples(*[st.floats(-0.2, 0.2)] * 3),
    "scales": st.lists(st.floats(0.0, 1.5), max_size=4).map(tuple),
    "points": st.lists(st.tuples(*[st.floats(-10, 10)] * 2), max_size=3).map(tuple),
    "ranges": st.dictionaries(st.text("abc", min_size=1), st.floats(0.0, 9.0), max_size=2),
    "shape": st.sampled_from(["circle", "line"]),
    "turn": st.sampled_from([1, -1]),
    "quick": st.booleans(),
    "joint": st.builds(Joint, angle=st.floats(-1.5, 1.5)),
    "named": st.dictionaries(
        st.text("abc", min_size=1), st.builds(Joint, angle=st.floats(-1.5, 1.5)), max_size=2
    ),
    "row": st.lists(st.builds(Joint, angle=st.floats(-1.5, 1.5)), max_size=2).map(tuple),
}
arms = st.builds(Arm, **GOOD)


@given(st.builds(Whole, seed=st.integers(0, 2**62), arm=arms))
def test_what_the_keys_allow_is_accepted_and_survives_a_file(whole):
    assert from_mapping(Whole, to_mapping(whole), "text") == whole
    assert from_mapping(Whole, tomllib.loads(write_toml(whole)), "text") == whole


def _outside(low: float, high: float) -> st.SearchStrategy[float]:
    numbers = st.floats(allow_nan=True, allow_infinity=True)
    return numbers.filter(lambda x: not low <= x <= high)


@given(
    st.one_of(
        st.tuples(st.just("depth"), _outside(0.0, 0.6)),
        st.tuples(st.just("speed"), _outside(5e-324, math.nextafter(5.0, 0.0))),
        st.tuples(st.just("count"), st.integers().filter(lambda n: not 1 <= n <= 10)),
        st.tuples(st.just("damping"), _outside(0.0, 1e4)),
        st.tuples(st.just("limit"), _outside(0.0, math.inf)),
        st.tuples(st.just("offset"), _outside(-0.2, 0.2).map(lambda x: (0.0, x, 0.0))),
        st.tuples(st.just("scales"), _outside(0.0, 1.5).map(lambda x: (x,))),
        st.tuples(st.just("points"), _outside(-10, 10).map(lambda x: ((0.0, 0.0), (x, 0.0)))),
        st.tuples(st.just("ranges"), _outside(0.0, 9.0).map(lambda x: {"a": x})),
        st.tuples(st.just("value"), _outside(-1.8e308, 1.8e308)),
        st.tuples(st.just("joint.angle"), _outside(-1.5, 1.5)),
        st.tuples(st.just("spare.angle"), _outside(-1.5, 1.5)),
        st.tuples(st.just("named.left.angle"), _outside(-1.5, 1.5)),
    )
)
def test_what_is_outside_is_refused_by_its_full_key(pair):
    key, value = pair
    with pytest.raises(ConfigError) as caught:
        with_overrides(Whole(), {f"arm.{key}": value}, "some.toml")
    message = str(caught.value)
    assert message.startswith(f"some.toml: arm.{key} = ")
    assert "\n" not in message


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("depth", -1.0, "Arm.depth = -1 m is outside of 0 .. 0.6 m"),
        ("depth", 300, "Arm.depth = 300 m is outside of 0 .. 0.6 m; is it in millimetres? 300 mm = 0.3 m"),
        ("depth", 0.60000001, "Arm.depth = 0.60000001 m is outside of 0 .. 0.6 m"),
        ("depth", 10**400, "Arm.depth = 1"),
        ("depth", True, "Arm.depth = True has the wrong type: expected a number, got true or false"),
        ("depth", "deep", "Arm.depth = 'deep' has the wrong type: expected a number, got text"),
        ("depth", None, "Arm.depth = None has the wrong type: expected a number, got nothing"),
        ("speed", 0.0, "Arm.speed = 0 m/s must be above 0 and below 5 m/s"),
        ("speed", 5.0, "Arm.speed = 5 m/s must be above 0 and below 5 m/s"),
        ("count", 1.0, "Arm.count = 1 has the wrong type: expected a whole number, got a number"),
        ("count", 123456789, "Arm.count = 123456789 is outside of 1 .. 10"),
        ("limit", -1.0, "Arm.limit = -1 must be at least 0"),
        ("limit", math.nan, "Arm.limit = nan must be at least 0"),
        ("offset", (0, 0.5, 0), "Arm.offset = 0.5 m (entry 2 of 3) is outside of -0.2 .. 0.2 m"),
        ("offset", (0, 0.1), "Arm.offset = [0, 0.1] has 2 entries, it needs 3"),
        ("points", ((0, 0), (0, 11)), "Arm.points = 11 m (entry 2 of 2, 2 of 2) is outside of -10 .. 10 m"),
        (
            "points",
            ((0, 0), 3),
            "Arm.points = 3 (entry 2 of 2) has the wrong type: expected a list, got a whole number",
        ),
        ("ranges", {"a": -1}, "Arm.ranges = -1 s (entry 'a') is outside of 0 .. 9 s"),
        ("value", math.inf, "Arm.value = inf must be finite"),
        ("value", (1.0, math.inf), "Arm.value = inf (entry 2 of 2) must be finite"),
        ("shape", "cirle", "Arm.shape = 'cirle' is not one of 'circle', 'line'; did you mean 'circle'?"),
        ("turn", 0, "Arm.turn = 0 is not one of 1, -1"),
        ("turn", True, "Arm.turn = True is not one of 1, -1"),
        ("quick", 1, "Arm.quick = 1 has the wrong type: expected true or false, got a whole number"),
        ("file", 3, "Arm.file = 3 has the wrong type: expected text, got a whole number"),
        ("joint", 3, "Arm.joint = 3 has the wrong type: expected Joint, got a whole number"),
        (
            "row",
            (Joint(), 3),
            "Arm.row = 3 (entry 2 of 2) has the wrong type: expected Joint, got a whole number",
        ),
    ],
)
def test_the_message_names_key_value_and_range(key, value, message):
    with pytest.raises(RefusedError) as caught:
        Arm(**{key: value})
    assert str(caught.value).startswith(message)
    assert len(str(caught.value)) < 140


@pytest.mark.parametrize(
    ("unit", "high", "value", "guess"),
    [
        ("m", 5.0, 300, "300 mm = 0.3 m"),
        ("kg", 1.0, 30, "30 g = 0.03 kg"),
        ("s", 0.2, 10, "10 ms = 0.01 s"),
        ("rad", 2.0, 90, "90 deg = 1.571 rad"),
    ],
)
def test_another_unit_is_guessed(unit, high, value, guess):
    assert Key(unit, "a size", low=0.0, high=high).problem(value).endswith(guess)


def test_an_open_end_may_leave_out_infinity_alone():
    key = Key("", "a number or -inf", low=-math.inf, below=math.inf, finite=False)
    assert key.allows(-math.inf)
    assert not key.allows(math.inf)
    assert key.problem(math.inf) == "must be below inf"


@pytest.mark.parametrize("value", [-3.0, 1e9, 0.5])
def test_no_other_unit_is_guessed_where_it_explains_nothing(value):
    assert Key("m", "a size", low=0.0, high=0.1).problem(value) == "is outside of 0 .. 0.1 m"


def test_numpy_numbers_are_numbers():
    assert Arm(depth=np.float64(0.3), count=np.int64(3)).count == 3  # type: ignore[arg-type]
    with pytest.raises(RefusedError, match=r"Arm\.depth = 3 m"):
        Arm(depth=np.float64(3.0))


def test_keys_are_checked_before_what_joins_them():
    with pytest.raises(RefusedError, match=r"Arm\.depth = nan"):
        Arm(depth=math.nan, speed=4.9)
    with pytest.raises(RefusedError, match=r"^Arm\.speed = 4\.9 m/s is too fast for so small a depth$"):
        Arm(depth=0.0, speed=4.9)
    with pytest.raises(ConfigError, match=r"^x: arm\.speed = 4\.9 m/s is too fast"):
        from_mapping(Whole, {"arm": {"depth": 0.0, "speed": 4.9}}, "x")


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"depth": 2.0}, r"LongArm\.depth"),
        ({"length": 99.0}, r"LongArm\.length"),
        ({"speed": 4.9, "depth": 0.0}, r"LongArm\.speed"),
        ({"length": 0.1}, "is less than the depth"),
    ],
)
def test_an_heir_checks_its_own_keys_and_its_ancestors(values: dict[str, Any], words):
    with pytest.raises(RefusedError, match=words):
        LongArm(**values)
    assert "length" in keys_of(LongArm)


def test_an_heir_may_change_a_default_and_keeps_the_key():
    assert keys_of(LongArm)["depth"].default == LongArm().depth == 0.5
    assert keys_of(LongArm)["depth"].key is DEPTH


def test_the_top_of_a_table_has_no_owner():
    with pytest.raises(ConfigError, match=r"^x: seed = -1 is outside"):
        from_mapping(Whole, {"seed": -1}, "x")


def test_a_part_is_refused_under_the_key_where_it_stands():
    with pytest.raises(ConfigError, match=r"^x: flight\.arm\.row\.1\.angle = 2 rad"):
        from_mapping(Whole, {"arm": {"row": [{}, {"angle": 2}]}}, "x", at="flight")
    with pytest.raises(ConfigError, match=r"^y: flight\.arm\.depth = 2 m"):
        with_overrides(Whole(), {"arm.depth": 2}, "y", at="flight")


def test_a_refusal_crosses_processes():
    error = RefusedError("Arm", "depth", "= 2 m is too much")
    again = pickle.loads(pickle.dumps(error))
    assert str(again) == str(error)
    assert again.key == "depth"


def test_every_key_is_listed_with_what_it_is():
    found = keys_of(Whole)
    assert list(found)[:3] == ["seed", "arm.depth", "arm.speed"]
    depth = found["arm.depth"]
    assert (depth.default, depth.unit, depth.meaning, depth.range, depth.type) == (
        0.18, "m", "how far", "0 .. 0.6", float,
    )  # fmt: skip
    assert found["arm.speed"].range == "> 0, < 5"
    assert found["arm.limit"].range == ">= 0"
    assert found["arm.value"].range == "any number"
    assert found["arm.shape"].range == "circle, line"
    assert found["arm.shape"].choices == ("circle", "line")
    assert found["arm.quick"].range == found["arm.file"].range == ""
    assert {"arm.joint.angle", "arm.spare.angle", "arm.named.<name>.angle", "arm.row.<n>.angle"} < set(found)


def test_a_configuration_is_described_with_its_values():
    whole = Whole(arm=Arm(depth=0.3, named={"left": Joint(0.5)}, row=(Joint(), Joint(1.0))))
    rows = {name: (value, info.unit) for name, value, info in described(whole)}
    assert rows["arm.depth"] == (0.3, "m")
    assert rows["arm.named.left.angle"] == (0.5, "rad")
    assert rows["arm.row.1.angle"] == (1.0, "rad")
    assert not any(name.startswith("arm.spare") for name in rows)
    units = units_of(tables_of(whole))
    assert units["arm.offset"] == "m"
    assert "arm.count" not in units


def test_tables_come_outer_first_and_say_what_is_not_there():
    tables = {".".join(table.path): table for table in tables_of(Whole(arm=Arm(row=(Joint(1.0),))))}
    assert list(tables) == [
        "", "arm", "arm.joint", "arm.spare", "arm.named.<name>", "arm.row.0",
    ]  # fmt: skip
    assert [name for name, table in tables.items() if not table.given] == ["arm.spare", "arm.named.<name>"]
    assert tables["arm"].meaning == "Values of every kind."
    assert tables["arm.row.0"].rows[0][:2] == ("angle", 1.0)
    assert tables["arm.spare"].rows[0][:2] == ("angle", 0.0)


def test_a_key_without_default_says_so():
    @configuration
    class Needs:
        """A key that has to be given."""

        mass: Annotated[float, Key("kg", "of the body", above=0.0, high=1e3)]

    assert keys_of(Needs)["mass"].default is REQUIRED
    with pytest.raises(ConfigError, match="the key 'mass' is missing"):
        from_mapping(Needs, {}, "text")


def test_a_plain_dataclass_is_described_too():
    @dataclass(frozen=True)
    class Plain:
        gain: float = 2.0

    assert [(name, value) for name, value, _ in described(Plain())] == [("gain", 2.0)]
    assert not is_configuration(Plain)
    assert is_configuration(Arm)
    assert is_configuration(LongArm)


def _made(kind: Any, default: Any) -> type:
    return configuration(type("Odd", (), {"__annotations__": {"value": kind}, "value": default}))


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        (float, "Odd.value has no Key"),
        (Annotated[float, "m"], "Odd.value has no Key"),
        (Annotated[float, Key("m", low=0.0, high=1.0)], "has no meaning"),
        (Annotated[float, Key("m", "size")], "needs a range"),
        (Annotated[float, Key("m", "size", low=0.0)], "needs a range"),
        (Annotated[tuple[float, ...] | None, Key("m", "sizes", high=0.0)], "needs a range"),
        (Annotated[dict[str, int], Key("m", "sizes")], "needs a range"),
    ],
)
def test_a_key_that_is_not_fully_written_is_a_mistake_of_the_class(kind, words):
    with pytest.raises(TypeError, match=words):
        _made(kind, None)


def test_a_post_init_of_its_own_is_a_mistake_of_the_class():
    with pytest.raises(TypeError, match="write `check`"):
        configuration(type("Odd", (), {"__post_init__": lambda self: None}))


def test_configurations_are_frozen_and_compare_by_value():
    assert Arm() == Arm()
    assert dataclasses.replace(Arm(), depth=0.2) != Arm()
    with pytest.raises(dataclasses.FrozenInstanceError):
        Arm().depth = 0.3  # type: ignore[misc]


@pytest.mark.parametrize(
    ("unit", "text", "reading"),
    [
        ("rad", "20deg", "20 deg = 0.349066 rad"),
        ("rad", "-90 °", "-90 ° = -1.5708 rad"),
        ("rad/s", "10 rpm", "10 rpm = 1.0472 rad/s"),
        ("m", "3e2 mm", "3e2 mm = 0.3 m"),
        ("m", "0.3m", "0.3 m = 0.3 m"),
        ("s", "200ms", "200 ms = 0.2 s"),
        ("", "20%", "20 % = 0.2"),
        ("m", "20deg", ""),
        ("rad", "20", ""),
        ("rad", "deg", ""),
        ("", "wet", ""),
        ("J", "3 kJ", ""),
    ],
)
def test_a_number_with_a_unit_is_read(unit, text, reading):
    assert Key(unit, "what").reading_of(text) == reading
