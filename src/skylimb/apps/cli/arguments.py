"""From words on the command line to a verb's record of options; every mistake on one line.

A verb is a frozen dataclass. Each field is an option, or an argument where its type is `Positional`; its type
and `arg` say the rest. argparse splits the words, and what they mean is checked here.
"""

from __future__ import annotations

import argparse
import dataclasses
import inspect
import typing
from dataclasses import dataclass
from typing import Annotated, Any, NoReturn, TypeVar, get_type_hints

from skylimb.base.errors import ConfigError, choice_error, unknown_name

T = TypeVar("T")

_POSITIONAL, _APPENDED = "positional", "appended"

Positional = Annotated[T, _POSITIONAL]
"""The type of an argument without a name."""

Appended = Annotated[T, _APPENDED]
"""The type of an option that may be given several times, each with several words: a tuple of tuples."""


@dataclass(frozen=True)
class arg:  # noqa: N801  # reads as a word in the annotations
    """What the help says of an option.

    Attributes:
        help: one or two sentences.
        metavar: what stands for its value; " ..." at its end says that there may be several.
    """

    help: str
    metavar: str = ""


class _Parser(argparse.ArgumentParser):
    """Raises in place of printing and leaving."""

    def error(self, message: str) -> NoReturn:
        missing = message.partition("the following arguments are required: ")[2]
        if missing:
            raise ConfigError(f"{missing} is missing; see {self.prog} --help")
        option = message.partition("argument ")[2].partition(":")[0].partition("/")[0]
        if "expected one argument" in message:
            raise ConfigError(f"{option} needs a value; see {self.prog} --help")
        raise ConfigError(f"{message}; see {self.prog} --help")


def parse(verb: str, kind: type, words: list[str]) -> Any:
    """An instance of the verb's class with its options filled in.

    Raises:
        ConfigError: for an unknown option, a missing value or one of the wrong type.
    """
    _refuse_values_of_flags(kind, words)
    found, unknown = _parser(verb, kind).parse_known_args(words)
    if unknown:
        if unknown[0].startswith("-"):
            raise unknown_name(f"option of {verb}", unknown[0].partition("=")[0], [*flags(kind), "--help"])
        from skylimb.flight.experiments.listing import list_controllers

        flag = next((one for one in flags(kind) if one.startswith("--controller")), "")
        hint = f"did you mean {flag} {unknown[0]}?" if flag and unknown[0] in list_controllers() else ""
        more = hint or f"see skylimb {verb} --help"
        raise ConfigError(f"'{unknown[0]}' is one argument too many; {more}")
    given = {name: value for name, value in vars(found).items() if value is not None}
    hints = get_type_hints(kind)
    labels = {flag.removeprefix("--"): flag for flag in flags(kind)}
    return kind(
        **{
            name: _converted(labels.get(name, name.upper()), hints[name], value)
            for name, value in given.items()
        }
    )


def _converted(label: str, kind: Any, value: Any) -> Any:
    """A word, or a list of words, as the field's type; `label` is what messages call it."""
    if isinstance(value, list):
        return tuple(tuple(entry) if isinstance(entry, list) else entry for entry in value)
    choices = typing.get_args(kind) if typing.get_origin(kind) is typing.Literal else ()
    if choices and value not in choices:
        raise choice_error(label, value, choices)
    if kind is not float:
        return value
    try:
        return float(value)
    except ValueError:
        raise ConfigError(f"{label} = '{value}' is not a number") from None


def _refuse_values_of_flags(kind: type, words: list[str]) -> None:
    """Refuse `--video no` and `--video=no`, in which "no" would be taken for the next argument."""
    hints = get_type_hints(kind)
    for word, following in zip(words, [*words[1:], ""], strict=False):
        option, equals, value = word.partition("=")
        name = option.removeprefix("--").removeprefix("no-").replace("-", "_")
        if option.startswith("--") and hints.get(name) is bool:
            value = value if equals else following
            if equals or value.lower() in _YES_OR_NO:
                raise ConfigError(
                    f"--{name} takes no value ('{value}'): write --{name}, or --no-{name} for the opposite"
                )


_YES_OR_NO = {"yes", "no", "true", "false", "on", "off", "0", "1"}


def verb_help(verb: str, kind: type) -> str:
    """What `skylimb VERB --help` prints."""
    text = _parser(verb, kind).format_help().rstrip()
    examples = inspect.cleandoc(kind.examples).replace("\n", "\n  ")  # type: ignore[attr-defined]
    return f"{text}\n\nExamples\n  {examples}"


def flags(kind: type) -> list[str]:
    """The options of a verb, as they are typed."""
    return [f"--{name}" for name, (_, marks) in _fields(kind).items() if _POSITIONAL not in marks]


def _fields(kind: type) -> dict[str, tuple[dataclasses.Field[Any], tuple[Any, ...]]]:
    """Each field of a verb, and what its annotation says besides the type."""
    hints = get_type_hints(kind, include_extras=True)
    return {
        field.name: (field, getattr(hints[field.name], "__metadata__", ()))
        for field in dataclasses.fields(kind)
    }


def _parser(verb: str, kind: type) -> _Parser:
    parser = _Parser(
        prog=f"skylimb {verb}",
        description=inspect.cleandoc(kind.__doc__ or ""),
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    types = get_type_hints(kind)
    for name, (field, marks) in _fields(kind).items():
        note = next((mark for mark in marks if isinstance(mark, arg)), arg(""))
        _add(parser, name, types[name], field.default, marks, note)
    return parser


def _add(parser: _Parser, name: str, kind: Any, default: Any, marks: tuple[Any, ...], note: arg) -> None:
    """Tell argparse of one field; defaults stay those of the class."""
    shown = default if isinstance(default, str | float | tuple) and default else None
    several = " ".join(shown) if isinstance(shown, tuple) else shown
    text = note.help.replace("%", "%%") + (f" (default: {several})" if shown is not None else "")
    choices = "{" + ",".join(typing.get_args(kind)) + "}" if typing.get_origin(kind) is typing.Literal else ""
    metavar = note.metavar.removesuffix(" ...") or choices or name.upper()
    if _POSITIONAL in marks:
        count = None if default is dataclasses.MISSING else "?"
        parser.add_argument(name, nargs=count, metavar=metavar, help=text)
    elif kind is bool:
        parser.add_argument(f"--{name}", action=argparse.BooleanOptionalAction, help=text)
    elif _APPENDED in marks:
        parser.add_argument(f"--{name}", action="append", nargs="*", metavar=metavar, help=text)
    elif typing.get_origin(kind) is tuple:
        parser.add_argument(f"--{name}", nargs="*", metavar=metavar, help=text)
    else:
        parser.add_argument(f"--{name}", metavar=metavar, help=text)
