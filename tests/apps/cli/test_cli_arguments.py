"""From words to a verb's options: types, several values, what is left out."""

import functools
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import pytest

from skylimb.apps.cli.arguments import arg, flags, parse, verb_help
from skylimb.apps.cli.options import assignments_of, settings_of
from skylimb.base.errors import ConfigError

NEGATIVE = ("-2", "-2.", "-.5", "-1e0", "-1E-3", "-1_0", "-inf", "-Infinity")
"""Numbers that begin as an option does."""


def verb(
    what: Annotated[str, arg("Half of it, 50 %.", "WHAT")],
    place: Annotated[str, arg("Where.", "PLACE")] = "here",
    *,
    speed: Annotated[float, arg("How fast.", "V")] = 1.5,
    count: Annotated[int | None, arg("How many.", "N")] = None,
    kind: Annotated[Literal["big", "small"], arg("Which.")] = "big",
    names: Annotated[tuple[str, ...], arg("Who.", "NAME ...")] = ("a", "b"),
    box: Annotated[tuple[float, ...] | None, arg("From where to where.", "M ...")] = None,
    set: Annotated[dict[str, Any] | None, arg("Change.", "K=V ...", settings_of)] = None,
    quick: Annotated[bool, arg("Whether.")] = False,
) -> None:
    """Do it.

    And more of it.

    Examples:
        skylimb do a
        skylimb do b
    """


@dataclass(frozen=True, kw_only=True)
class Shared:
    force: Annotated[float, arg("How hard.", "N")] = 2.0
    names: Annotated[tuple[str, ...], arg("Who.", "NAME ...")] = ()


def sharing(*, shared: Shared = Shared(), speed: Annotated[float, arg("How fast.", "V")] = 1.5) -> None:
    """Do it with options that another verb has, too."""


def given(words: list[str]) -> dict[str, Any]:
    call = parse("do", verb, words)
    assert isinstance(call, functools.partial)
    return call.keywords


def test_what_is_left_out_takes_the_default_of_the_function() -> None:
    assert given(["x"]) == {"what": "x"}


@pytest.mark.parametrize(
    ("words", "changes"),
    [
        (["x", "there"], {"place": "there"}),
        (["--speed", "-0.2", "x"], {"speed": -0.2}),
        (["x", "--speed=3"], {"speed": 3.0}),
        (["x", "--kind", "small"], {"kind": "small"}),
        (["x", "--names"], {"names": ()}),
        (["x", "--names", "c", "d", "e"], {"names": ("c", "d", "e")}),
        (["x", "--set", "a=1", "b=-2", "--set", "c=3"], {"set": {"a": 1, "b": -2, "c": 3}}),
        (["x", "--count", "-3"], {"count": -3}),
        (["x", "--box", "-1", "2.5"], {"box": (-1.0, 2.5)}),
        *((["x", "--speed", word], {"speed": float(word)}) for word in NEGATIVE),
        (["x", "--box", *NEGATIVE], {"box": tuple(map(float, NEGATIVE))}),
        (["x", "--names", "-1e0,.5,-2.", "--quick"], {"names": ("-1e0,.5,-2.",), "quick": True}),
        *((["x", "--set", f"a={word}"], {"set": {"a": float(word)}}) for word in (*NEGATIVE, "2.", ".5")),
        (["x", "--box"], {"box": ()}),
        (["x", "--quick"], {"quick": True}),
        (["--no-quick", "x"], {"quick": False}),
    ],
)
def test_words_become_values(words: list[str], changes: dict) -> None:
    assert given(words) == {"what": "x"} | changes


def test_options_that_verbs_share_come_as_one_value() -> None:
    assert flags(sharing) == ["--force", "--names", "--speed"]
    call = parse("do", sharing, ["--names", "a", "--speed", "3", "--names", "b"])
    assert isinstance(call, functools.partial)
    assert call.keywords == {"shared": Shared(names=("a", "b")), "speed": 3.0}
    with pytest.raises(ConfigError, match="--force = 'x' is not a number"):
        parse("do", sharing, ["--force", "x"])
    assert "(default: 2.0)" in verb_help("do", sharing)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([], "WHAT is missing; see skylimb do --help"),
        (["x", "--speed", "high"], "--speed = 'high' is not a number"),
        (["x", "--count", "1.5"], "--count = '1.5' is not a whole number"),
        (["x", "--box", "1", "far"], "--box = 'far' is not a number"),
        (["x", "--set", "a=1", "a=2"], "--set gives 'a' twice"),
        (["x", "--kind", "smal"], "--kind = 'smal' is not one of big, small; did you mean 'small'?"),
        (["x", "--speed"], "--speed needs a value"),
        (["x", "--speed", "-2.m"], "--speed needs a value"),
        (["x", "--sped", "1"], "unknown option of do '--sped'; did you mean '--speed'?"),
        (["x", "--spee", "1"], "unknown option of do '--spee'"),
        (["x", "y", "z"], "'z' is one argument too many; see skylimb do --help"),
        (["x", "--quick", "no"], "--quick takes no value ('no')"),
    ],
)
def test_a_mistake_is_said_in_a_line(words: list[str], message: str) -> None:
    with pytest.raises(ConfigError) as caught:
        parse("do", verb, words)
    assert str(caught.value).startswith(message)
    assert "\n" not in str(caught.value)


def test_the_help_has_usage_meanings_defaults_and_examples() -> None:
    text = verb_help("do", verb)
    assert text.startswith("usage: skylimb do")
    assert "And more of it." in text
    for words in ("Half of it, 50 %.", "(default: here)", "(default: 1.5)", "(default: a b)", "{big,small}"):
        assert words in text
    assert text.endswith("Examples\n  skylimb do a\n  skylimb do b")
    assert "--no-quick" in text
    assert flags(verb) == ["--speed", "--count", "--kind", "--names", "--box", "--set", "--quick"]


def test_an_assignment_is_refused_in_words_of_its_option() -> None:
    read = assignments_of("--start", "joint1=0.5")
    with pytest.raises(ConfigError, match=r"for example joint1=0\.5"):
        read(("joint1",))
    with pytest.raises(ConfigError, match="--start gives 'joint1' twice"):
        read(("joint1=0.1", "joint1=0.2"))
