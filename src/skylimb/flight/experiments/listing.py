"""What ships: experiments and controllers, each with its one line."""

from __future__ import annotations

import tomllib
from pathlib import Path

_PACKAGE = Path(__file__).parents[2]
_EXPERIMENTS = _PACKAGE / "experiments" / "library"
_PRESETS = _PACKAGE / "control" / "presets"


def _descriptions(files: dict[str, Path], key: str) -> dict[str, str]:
    return {name: str(tomllib.loads(file.read_text()).get(key, "")) for name, file in sorted(files.items())}


def list_experiments() -> dict[str, str]:
    """Experiments by name, with what they are."""
    return _descriptions({file.stem: file for file in _EXPERIMENTS.glob("*.toml")}, "description")


def list_controllers() -> dict[str, str]:
    """Controller presets by name, with what they are."""
    return _descriptions({file.stem: file for file in _PRESETS.glob("*.toml")}, "description")
