"""Robots, control, missions and the loop fly with NumPy, CasADi and a configuration reader alone."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

PROGRAM = Path(__file__).parent / "helpers" / "core_alone.py"


def test_the_core_flies_a_controller_with_numpy_and_casadi_alone(tmp_path: Path) -> None:
    ended = subprocess.run(
        [sys.executable, str(PROGRAM), "--blocked"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        timeout=300,
        check=False,
    )
    assert ended.returncode == 0, ended.stderr[-3000:]
    assert ended.stdout.startswith("flown")
