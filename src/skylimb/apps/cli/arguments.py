"""From words on the command line to the arguments of a verb; every mistake on one line.

A verb is a function that does its work and returns the exit code, None for 0. Its parameters before the `*`
are arguments, those after it options; type, default and `arg` say the rest. A dataclass among them holds
options that verbs share. Its docstring is its help.
argparse splits the words, and what they mean is checked here. cyclopts and tyro would do the same; they make
`skylimb --help` slower (docs/reports/decisions.md has the times).
"""

from __future__ import annotations

import argparse
import functools
import inspect
import itertools
import typing
from collections.abc import Callable
from dataclasses import dataclass, is_dataclass
from typing import Any, NoReturn

from skylimb.base.errors import ConfigError, choice_error, unknown_name

Verb = Callable[..., int | None]

_NUMBERS = {int: "a whole number", float: "a number"}
_YES_OR_NO = {"yes", "no", "true", "false", "on", "off", "0", "1"}


@dataclass(frozen=True)
class arg:  # noqa: N801  # reads as a word in the annotations
    """What the help says of a parameter, and what its words become.

    Attributes:
        help: one or two sentences.
        metavar: what stands for its value; " ..." at its end says that there may be several.
        read: makes the value from the words of a tuple; by default it stays a tuple.
    """

    help: str
    metavar: str = ""
    read: Callable[[tuple[str, ...]], Any] = tuple


class _Parser(argparse.ArgumentParser):
    """Raises in place of printing and leaving, and takes every number for a value."""

    def _parse_optional(self, arg_string: str) -> Any:
        """What option a word is; none where it is a number. argparse takes -2. and -1e0 for options."""
        return None if _is_numeric(arg_string) else super()._parse_optional(arg_string)

    def error(self, message: str) -> NoReturn:
        missing = message.partition("the following arguments are required: ")[2]
        if missing:
            *others, last = missing.split(", ")
            what = f"{', '.join(others)} and {last} are" if others else f"{last} is"
            raise ConfigError(f"{what} missing; see {self.prog} --help")
        option = message.partition("argument ")[2].partition(":")[0].partition("/")[0]
        if "expected one argument" in message:
            raise ConfigError(f"{option} needs a value; see {self.prog} --help")
        raise ConfigError(f"{message}; see {self.prog} --help")


def parse(name: str, verb: Verb, words: list[str]) -> Callable[[], int | None]:
    """The verb with its arguments filled in, to be called.

    Raises:
        ConfigError: for an unknown option, a missing value or one of the wrong type.
    """
    _refuse_values_of_switches(verb, words)
    found, unknown = _parser(name, verb).parse_known_args(words)
    if unknown:
        if unknown[0].startswith("-"):
            raise unknown_name(f"option of {name}", unknown[0].partition("=")[0], [*flags(verb), "--help"])
        from skylimb.flight.experiments.listing import list_controllers

        flag = next((one for one in flags(verb) if one.startswith("--controller")), "")
        hint = f"did you mean {flag} {unknown[0]}?" if flag and unknown[0] in list_controllers() else ""
        raise ConfigError(f"'{unknown[0]}' is one argument too many; {hint or f'see skylimb {name} --help'}")
    given = vars(found)
    for parameter in _parameters(verb):
        if isinstance(given.get(parameter.name), list):
            given[parameter.name] = _note(parameter).read(tuple(given[parameter.name]))
    for shared in _signature(verb):
        if kind := _shared(shared):
            names = [one.name for one in _signature(kind) if one.name in given]
            given[shared.name] = kind(**{name: given.pop(name) for name in names})
    return functools.partial(verb, **given)


def verb_help(name: str, verb: Verb) -> str:
    """What `skylimb VERB --help` prints."""
    return _parser(name, verb).format_help().rstrip()


def flags(verb: Verb) -> list[str]:
    """The options of a verb, as they are typed."""
    return [f"--{one.name}" for one in _parameters(verb) if one.kind is one.KEYWORD_ONLY]


def _parameters(verb: Verb) -> list[inspect.Parameter]:
    """Of a verb, those within its dataclasses among them."""
    own = (_signature(kind) if (kind := _shared(one)) else [one] for one in _signature(verb))
    return [*itertools.chain.from_iterable(own)]


def _signature(made: Callable[..., Any]) -> list[inspect.Parameter]:
    return list(inspect.signature(made, eval_str=True).parameters.values())


def _shared(parameter: inspect.Parameter) -> type | None:
    """The dataclass that a parameter is of; None for any other parameter."""
    kind = parameter.annotation
    return kind if isinstance(kind, type) and is_dataclass(kind) else None


def _note(parameter: inspect.Parameter) -> arg:
    return next(note for note in parameter.annotation.__metadata__ if isinstance(note, arg))


def _types(parameter: inspect.Parameter) -> tuple[Any, ...]:
    """The types that a parameter may have, without None."""
    kind = typing.get_args(parameter.annotation)[0]
    members = (kind,) if typing.get_origin(kind) in (tuple, typing.Literal) else typing.get_args(kind)
    return tuple(member for member in members or (kind,) if member is not type(None))


def _refuse_values_of_switches(verb: Verb, words: list[str]) -> None:
    """Refuse `--video no` and `--video=no`, in which "no" would be taken for the next argument."""
    switches = {
        f"--{no}{one.name}" for one in _parameters(verb) if _types(one) == (bool,) for no in ("", "no-")
    }
    for word, following in zip(words, [*words[1:], ""], strict=False):
        option, equals, value = word.partition("=")
        value = value if equals else following
        if option in switches and (equals or value.lower() in _YES_OR_NO):
            name = option.removeprefix("--").removeprefix("no-")
            raise ConfigError(
                f"--{name} takes no value ('{value}'): write --{name}, or --no-{name} for the opposite"
            )


def _parser(name: str, verb: Verb) -> _Parser:
    text, _, examples = inspect.cleandoc(verb.__doc__ or "").partition("\n\nExamples:\n")
    parser = _Parser(
        prog=f"skylimb {name}",
        description=text,
        epilog="Examples\n" + "\n".join(f"  {line.strip()}" for line in examples.strip().splitlines()),
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
        argument_default=argparse.SUPPRESS,  # what is not given keeps the function's own default
    )
    for parameter in _parameters(verb):
        _add(parser, parameter)
    return parser


def _add(parser: _Parser, parameter: inspect.Parameter) -> None:
    """Tell argparse of one parameter."""
    name, default, note, types = parameter.name, parameter.default, _note(parameter), _types(parameter)
    choices = typing.get_args(types[0]) if typing.get_origin(types[0]) is typing.Literal else ()
    several = typing.get_origin(types[0]) in (tuple, dict)
    positional = parameter.kind is not parameter.KEYWORD_ONLY
    shown = " ".join(default) if isinstance(default, tuple) else default
    told = (
        f" (default: {shown})" if shown and isinstance(shown, str | int | float) and types != (bool,) else ""
    )
    metavar = note.metavar.removesuffix(" ...") or f"{{{','.join(choices)}}}" * bool(choices) or name.upper()
    options: dict[str, Any] = {"help": note.help.replace("%", "%%") + told}
    if types == (bool,):
        options["action"] = argparse.BooleanOptionalAction
    else:
        label = name.upper() if positional else f"--{name}"
        each = typing.get_args(types[0]) if typing.get_origin(types[0]) is tuple else types
        options |= {"metavar": metavar, "type": functools.partial(_value, label, each, choices)}
    if several:
        options |= {"action": "extend", "nargs": "*"}
    elif positional and default is not parameter.empty:
        options["nargs"] = "?"
    parser.add_argument(name if positional else f"--{name}", **options)


def _is_numeric(word: str) -> bool:
    """Whether it is what `float` takes, or several of these with commas between them."""
    try:
        return bool([float(part) for part in word.split(",")])
    except ValueError:
        return False


def _value(label: str, types: tuple[Any, ...], choices: tuple[str, ...], word: str) -> Any:
    """A word as a parameter's type; `label` is what messages call it."""
    if choices and word not in choices:
        raise choice_error(label, word, choices)
    for kind, called in _NUMBERS.items():
        if kind in types:
            try:
                return kind(word)
            except ValueError:
                raise ConfigError(f"{label} = '{word}' is not {called}") from None
    return word
