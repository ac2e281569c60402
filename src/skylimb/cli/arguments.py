"""From words on the command line to a verb's record of options, by tyro; every mistake on one line."""

from __future__ import annotations

import contextlib
import dataclasses
import inspect
import io
import re
from typing import Any, get_type_hints

import tyro
from tyro.conf import Positional

from skylimb.errors import ConfigError, unknown_name


def parse(verb: str, kind: type, words: list[str]) -> Any:
    """An instance of the verb's class with its options filled in.

    Raises:
        ConfigError: for an unknown option, a missing value or one of the wrong type.
    """
    _refuse_values_of_flags(kind, words)
    complaint = io.StringIO()
    try:
        with contextlib.redirect_stderr(complaint):
            options, unknown = _tyro(verb, kind, words)
    except SystemExit:
        raise ConfigError(f"{_first_sentence(complaint.getvalue())}; see skylimb {verb} --help") from None
    if unknown:
        if unknown[0].startswith("-"):
            raise unknown_name(f"option of {verb}", unknown[0].partition("=")[0], [*flags(kind), "--help"])
        from skylimb.experiments.listing import list_controllers

        flag = next((one for one in flags(kind) if one.startswith("--controller")), "")
        hint = f"did you mean {flag} {unknown[0]}?" if flag and unknown[0] in list_controllers() else ""
        more = hint or f"see skylimb {verb} --help"
        raise ConfigError(f"'{unknown[0]}' is one argument too many; {more}")
    return options


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
    text = io.StringIO()
    with contextlib.redirect_stdout(text), contextlib.suppress(SystemExit):
        _tyro(verb, kind, ["--help"])
    usage, _, rest = text.getvalue().rstrip().partition("\n")
    for name in ("EXPERIMENT", "FILE.svg"):  # tyro shows them as if they were required
        usage = usage.replace(f" [OPTIONS] {name}", f" [OPTIONS] [{name}]")
    examples = inspect.cleandoc(kind.examples).replace("\n", "\n  ")  # type: ignore[attr-defined]
    return f"{usage}\n{rest}\n\nExamples\n  {examples}"


def _tyro(verb: str, kind: type, words: list[str]) -> tuple[Any, list[str]]:
    about = inspect.cleandoc(kind.__doc__ or "")
    return tyro.cli(kind, prog=f"skylimb {verb}", description=about, args=words, return_unknown_args=True)


def flags(kind: type) -> list[str]:
    """The options of a verb, as they are typed."""
    hints = get_type_hints(kind, include_extras=True)
    marks = {field.name: getattr(hints[field.name], "__metadata__", ()) for field in dataclasses.fields(kind)}
    return [f"--{name}" for name, found in marks.items() if Positional not in found]


def _first_sentence(text: str) -> str:
    """What tyro says of a mistake, without the box around it, the option's help and the colours.

    Its box is a title, the mistake, a rule, and advice; where the terminal cannot draw boxes there is another
    rule below the title.
    """
    plain = re.sub(r"\x1b\[[0-9;]*m", "", text)
    rows = [line.strip("│ ") for line in plain.splitlines() if line.strip() and line[0] not in "╭╰"]
    sections = "\n".join("" if not row.strip("─-") else row for row in rows).split("\n\n")
    section = sections[0] if "╭" in plain or len(sections) == 1 else sections[1]
    sentence = " ".join(section.split())
    missing = re.match(r"Missing from skylimb \S+: (\S+) ", sentence)
    return f"{missing[1]} is missing" if missing else sentence.rstrip(". ")
