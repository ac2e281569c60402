"""Puts the examples into the wheel, where `skylimb examples` finds them; all else is in pyproject.toml."""

import shutil
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

HERE = Path(__file__).parent


class WithExamples(build_py):
    """The package's files and, beside them, the examples."""

    def run(self) -> None:
        """Copy both."""
        super().run()
        if not self.editable_mode:
            target = Path(self.build_lib) / "skylimb" / "examples"
            ignored = shutil.ignore_patterns("__pycache__")
            shutil.copytree(HERE / "examples", target, ignore=ignored, dirs_exist_ok=True)


setup(cmdclass={"build_py": WithExamples})
