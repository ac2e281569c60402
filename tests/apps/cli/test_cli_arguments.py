"""From words to a verb's options: types, several values, what is left out."""

import dataclasses
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

import pytest

from skylimb.apps.cli.arguments import Appended, Positional, arg, flags, parse, verb_help
from skylimb.base.errors import ConfigError


@dataclass(frozen=True)
class Verb:
    """Do it.

    And more of it.
    """

    examples: ClassVar[str] = """
        skylimb do a
        skylimb do b
    """

    what: Annotated[Positional[str], arg(metavar="WHAT", help="Half of it, 50 %.")]
    place: Annotated[Positional[str], arg(metavar="PLACE", help="Where.")] = "here"
    speed: Annotated[float, arg(metavar="V", help="How fast.")] = 1.5
    kind: Annotated[Literal["big", "small"], arg(help="Which.")] = "big"
    names: Annotated[tuple[str, ...], arg(metavar="NAME ...", help="Who.")] = ("a", "b")
    set: Annotated[Appended[tuple[tuple[str, ...], ...]], arg(metavar="K=V ...", help="Change.")] = ()
    quick: Annotated[bool, arg(help="Whether.")] = False


def test_what_is_left_out_takes_the_default_of_the_class() -> None:
    assert parse("do", Verb, ["x"]) == Verb("x")


@pytest.mark.parametrize(
    ("words", "changes"),
    [
        (["x", "there"], {"place": "there"}),
        (["--speed", "-0.2", "x"], {"speed": -0.2}),
        (["x", "--speed=3"], {"speed": 3.0}),
        (["x", "--kind", "small"], {"kind": "small"}),
        (["x", "--names"], {"names": ()}),
        (["x", "--names", "c", "d", "e"], {"names": ("c", "d", "e")}),
        (["x", "--set", "a=1", "b=-2", "--set", "c=3"], {"set": (("a=1", "b=-2"), ("c=3",))}),
        (["x", "--quick"], {"quick": True}),
        (["--no-quick", "x"], {}),
    ],
)
def test_words_become_values(words: list[str], changes: dict) -> None:
    assert parse("do", Verb, words) == dataclasses.replace(Verb("x"), **changes)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([], "WHAT is missing; see skylimb do --help"),
        (["x", "--speed", "high"], "--speed = 'high' is not a number"),
        (["x", "--kind", "smal"], "--kind = 'smal' is not one of big, small; did you mean 'small'?"),
        (["x", "--speed"], "--speed needs a value"),
        (["x", "--sped", "1"], "unknown option of do '--sped'; did you mean '--speed'?"),
        (["x", "--spee", "1"], "unknown option of do '--spee'"),
        (["x", "y", "z"], "'z' is one argument too many; see skylimb do --help"),
        (["x", "--quick", "no"], "--quick takes no value ('no')"),
    ],
)
def test_a_mistake_is_said_in_a_line(words: list[str], message: str) -> None:
    with pytest.raises(ConfigError) as caught:
        parse("do", Verb, words)
    assert str(caught.value).startswith(message)
    assert "\n" not in str(caught.value)


def test_the_help_has_usage_meanings_defaults_and_examples() -> None:
    text = verb_help("do", Verb)
    assert text.startswith("usage: skylimb do")
    assert "And more of it." in text
    for words in ("Half of it, 50 %.", "(default: here)", "(default: 1.5)", "(default: a b)", "{big,small}"):
        assert words in text
    assert text.endswith("Examples\n  skylimb do a\n  skylimb do b")
    assert "--no-quick" in text
    assert flags(Verb) == ["--speed", "--kind", "--names", "--set", "--quick"]
