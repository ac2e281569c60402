"""The verb that copies the examples out of the package."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Annotated

from skylimb.apps.cli.arguments import arg
from skylimb.base.errors import OutputError

_PACKAGE = Path(__file__).parents[2]


def examples(folder: Annotated[str, arg("New folder for the copies.", "DIR")] = "examples") -> None:
    """Copy the examples into a new folder: scripts, presets, laws, a drawing, campaigns.

    Examples:
        skylimb examples
        skylimb examples my_examples
    """
    from skylimb.base.files import new_folder

    source, ignored = examples_folder(), shutil.ignore_patterns("__pycache__")
    with new_folder(folder) as aside:
        shutil.copytree(source, aside, ignore=ignored, dirs_exist_ok=True)
    for path in sorted(Path(folder).rglob("*")):
        if path.is_file():
            print(f"  {path}")


def examples_folder() -> Path:
    """Where the examples lie: inside of an installed package, or in the repository that is worked in.

    Raises:
        OutputError: when they are in neither place.
    """
    for folder in (_PACKAGE / "examples", _PACKAGE.parents[1] / "examples"):
        if (folder / "user_controller.py").is_file():
            return folder
    raise OutputError("the examples did not come with this installation; they are in the repository")
