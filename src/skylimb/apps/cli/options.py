"""Options that several verbs share, and what becomes of their words."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

from skylimb.apps.cli.arguments import arg
from skylimb.base.errors import ConfigError, OutputError


def assignments_of(option: str, example: str) -> Callable[[tuple[str, ...]], dict[str, Any]]:
    """What reads the words of an option into the dotted keys and values of every KEY=VALUE given.

    It raises a ConfigError where one is no assignment, or a key is given twice.

    Args:
        option: that is read, for messages.
        example: of an assignment, for messages.
    """

    def read(assignments: tuple[str, ...]) -> dict[str, Any]:
        from skylimb.base.config import parse_assignment

        settings: dict[str, Any] = {}
        for text in assignments:
            key, value = parse_assignment(text, example)
            if key in settings:
                raise ConfigError(f"{option} gives '{key}' twice")
            settings[key] = value
        return settings

    return read


settings_of = assignments_of("--set", "trajectory.radius=0.25")


Experiment = Annotated[str, arg("An experiment's name or TOML file.", "EXPERIMENT")]
Settings = Annotated[
    dict[str, Any] | None,
    arg("Change the experiment; `skylimb show EXPERIMENT` lists the keys.", "KEY=VALUE ...", settings_of),
]
Controller = Annotated[
    str | None,
    arg(
        "A controller's name, its TOML file, or a Python file; by default the one in the experiment's file, "
        "else hybrid.",
        "NAME",
    ),
]
Seed = Annotated[int | None, arg("Seed of the sensors' noise; by default the experiment's own.", "N")]
Use = Annotated[tuple[str, ...], arg("Python files with metrics and figures of your own.", "FILE ...")]
Calibration = Annotated[
    str | None,
    arg(
        "A calibration.toml, which `skylimb calibrate` writes: what the controller knows of its robot.",
        "FILE",
    ),
]
Fence = Annotated[
    tuple[float, ...] | None, arg("Where the robot may fly, m: least and greatest x, y and z.", "M ...")
]
Out = Annotated[str, arg("New folder for the results; by default a fresh one below out/.", "DIR")]
Video = Annotated[
    bool, arg("Whether to draw the video too, which takes longer than all the rest; the report moves.")
]
Folder = Annotated[str, arg("A folder that run or compare left.", "DIR")]
Log = Annotated[str, arg("A run's folder, or a .nc, .bag or .mcap file.", "LOG")]


def within(option: str, value: float, low: float, high: float, unit: str = "") -> None:
    """Refuse a value of an option outside of its range.

    Raises:
        ConfigError: names the option, its value and the range.
    """
    if not low <= value <= high:
        unit = f" {unit}" if unit else ""
        raise ConfigError(f"{option} = {value:g}{unit} is outside of {low:g} .. {high:g}{unit}")


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
