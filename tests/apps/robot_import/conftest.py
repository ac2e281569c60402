"""Descriptions as users have them."""

from collections.abc import Callable
from pathlib import Path

import pytest

from lab_style import lab_urdf


@pytest.fixture
def lab_file(tmp_path) -> Callable[..., Path]:
    """Writes `lab_urdf` into a file, some of its text replaced."""

    def write(*changes: tuple[str, str], **options: object) -> Path:
        text = lab_urdf(**options)  # type: ignore[arg-type]
        for old, new in changes:
            assert old in text, f"the test replaces what is not there: {old}"
            text = text.replace(old, new)
        path = tmp_path / "quad.urdf"
        path.write_text(text)
        return path

    return write
