"""Options that several verbs share, and what becomes of their words."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from skylimb.apps.cli.arguments import Appended, Positional, arg
from skylimb.base.errors import ConfigError, OutputError

Experiment = Annotated[Positional[str], arg(metavar="EXPERIMENT", help="An experiment's name or TOML file.")]
Assignments = Annotated[
    Appended[tuple[tuple[str, ...], ...]],
    arg(
        metavar="KEY=VALUE ...",
        help="Change the experiment; `skylimb show EXPERIMENT` lists the keys.",
    ),
]
Seed = Annotated[
    str,
    arg(
        metavar="N",
        help="Seed of the sensors' noise; by default the experiment's own.",
    ),
]
Use = Annotated[
    tuple[str, ...],
    arg(
        metavar="FILE ...",
        help="Python files with metrics and figures of your own.",
    ),
]
Calibration = Annotated[
    str,
    arg(
        metavar="FILE",
        help="A calibration.toml, which `skylimb calibrate` writes: what the controller knows of its robot.",
    ),
]
Out = Annotated[
    str,
    arg(
        metavar="DIR",
        help="New folder for the results; by default a fresh one below out/.",
    ),
]
Video = Annotated[
    bool, arg(help="Whether to draw the video too, which takes longer than all the rest; the report moves.")
]
Folder = Annotated[Positional[str], arg(metavar="DIR", help="A folder that run or compare left.")]


def settings_of(assignments: tuple[tuple[str, ...], ...]) -> dict[str, Any]:
    """The dotted keys and values of every KEY=VALUE given.

    Raises:
        ConfigError: where one is no assignment, or a key is given twice.
    """
    from skylimb.base.config import parse_assignment

    settings: dict[str, Any] = {}
    for text in (text for group in assignments for text in group):
        key, value = parse_assignment(text)
        if key in settings:
            raise ConfigError(f"--set gives '{key}' twice")
        settings[key] = value
    return settings


def whole_number(option: str, text: str) -> int | None:
    """The number that an option gives; None where it was not given.

    Raises:
        ConfigError: where it is no whole number.
    """
    if not text:
        return None
    try:
        return int(text)
    except ValueError:
        raise ConfigError(f"{option} = '{text}' is not a whole number") from None


def stem(name: str) -> str:
    """What an experiment or controller is called: its name, or its file's without folder and ending."""
    return Path(name).stem if name.endswith((".toml", ".py")) else name


def new_folder(given: str, usual: str) -> Path:
    """The folder that was named, which must not exist; else the first free of its usual names below out/."""
    from skylimb.base.files import require_new

    if given:
        return require_new(given)
    for count in range(1, 10_000):
        folder = Path("out") / (usual if count == 1 else f"{usual}-{count}")
        if not folder.exists():
            return require_new(folder)
    raise OutputError(f"out/ holds thousands of folders called '{usual}'; name one with --out")
