from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

SHORTEST = """
"approach.contact" = false
"phases.hover" = 0.1
"phases.tare" = 0.2
"phases.settle" = 0.0
"phases.hover_end" = 0.1
"trajectory.shape" = "hold"
"trajectory.duration" = 0.4
"""
"""A free flight of 0.8 s."""

SpecWriter = Callable[..., Path]


def _write(
    folder: Path,
    draws: int = 4,
    controllers: str = '["pid", "hybrid"]',
    vary: str = '"plant.thrust_scale" = { uniform = [0.9, 1.1] }',
    head: str = "",
    more: str = "",
    name: str = "spec.toml",
) -> Path:
    path = folder / name
    path.write_text(
        f'experiment = "paper"\ncontrollers = {controllers}\ndraws = {draws}\nseed = 7\n{head}\n'
        f"[set]\n{SHORTEST}\n[vary]\n{vary}\n{more}\n"
    )
    return path


@pytest.fixture(scope="session")
def write_spec_to() -> SpecWriter:
    """Writes a spec of tiny flights into a folder: its head, what varies, and more tables."""
    return _write


@pytest.fixture
def write_spec(tmp_path: Path) -> SpecWriter:
    """The same into this test's own folder."""
    return partial(_write, tmp_path)
