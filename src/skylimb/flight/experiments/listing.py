"""What ships: experiments and controllers, each with its one line. Read without the rest of the package."""

from __future__ import annotations

import tomllib
from pathlib import Path

_EXPERIMENTS = Path(__file__).parent / "library"
_PRESETS = Path(__file__).parents[2] / "control" / "presets"


def list_experiments() -> dict[str, str]:
    """Experiments by name, with what they are."""
    return _descriptions(_EXPERIMENTS)


def list_controllers() -> dict[str, str]:
    """Controller presets by name, with what they are."""
    return _descriptions(_PRESETS)


def _descriptions(folder: Path) -> dict[str, str]:
    files = sorted(folder.glob("*.toml"))
    return {file.stem: str(tomllib.loads(file.read_text("utf-8")).get("description", "")) for file in files}
