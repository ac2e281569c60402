"""The verb that copies the examples out of the package."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar

from skylimb.apps.cli.arguments import Positional, arg
from skylimb.base.errors import OutputError

_PACKAGE = Path(__file__).parents[2]


@dataclass(frozen=True)
class Examples:
    """Copy the examples into a new folder: scripts, presets, laws, a drawing, campaigns."""

    examples: ClassVar[str] = """
        skylimb examples
        skylimb examples my_examples
    """

    folder: Annotated[Positional[str], arg(metavar="DIR", help="New folder for the copies.")] = "examples"

    def __call__(self) -> int:
        """Copy, and name the copies."""
        from skylimb.base.files import new_folder

        source, ignored = examples_folder(), shutil.ignore_patterns("__pycache__")
        with new_folder(self.folder) as aside:
            shutil.copytree(source, aside, ignore=ignored, dirs_exist_ok=True)
        for path in sorted(Path(self.folder).rglob("*")):
            if path.is_file():
                print(f"  {path}")
        return 0


def examples_folder() -> Path:
    """Where the examples lie: inside of an installed package, or in the repository that is worked in.

    Raises:
        OutputError: when they are in neither place.
    """
    for folder in (_PACKAGE / "examples", _PACKAGE.parents[1] / "examples"):
        if (folder / "own_controller.py").is_file():
            return folder
    raise OutputError("the examples did not come with this installation; they are in the repository")


VERBS: dict[str, Any] = {"examples": Examples}
