"""A copy of the robot's files that a test may spoil."""

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from skylimb.robots import read_description

SHIPPED = read_description("hydrus_xi_quad").folder


@pytest.fixture
def spoil(tmp_path: Path) -> Callable[..., Path]:
    """Copy the two files with one replacement in each, given as (old, new); returns the flight TOML."""

    def build(urdf: tuple[str, str] | None = None, toml: tuple[str, str] | None = None) -> Path:
        for name, change in (("hydrus_xi_quad.urdf", urdf), ("flight.toml", toml)):
            text = (SHIPPED / name).read_text(encoding="utf-8")
            if change is not None:
                assert change[0] in text, f"the test replaces what is not there: {change[0]}"
                text = text.replace(*change)
            (tmp_path / name).write_text(text, encoding="utf-8")
        return tmp_path / "flight.toml"

    return build


@pytest.fixture
def shipped_folder(tmp_path: Path) -> Path:
    """A plain copy of the robot's folder."""
    return Path(shutil.copytree(SHIPPED, tmp_path / "robot"))
