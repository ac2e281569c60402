"""DDS is known in the rim alone; where it is absent, one line says what to install."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

import skylimb
from skylimb.apps.ros2.rim import ROS2
from skylimb.base.errors import ConfigError

SOURCE = Path(skylimb.__file__).parent
DDS = re.compile(r"^\s*(?:import|from) (cyclonedds|rclpy)\b", re.MULTILINE)


def test_nothing_else_imports_dds() -> None:
    inside = [path for path in SOURCE.rglob("*.py") if DDS.search(path.read_text(encoding="utf-8"))]
    assert {path.parent for path in inside} == {SOURCE / "apps" / "ros2"}


def test_without_dds_one_line_says_what_to_install() -> None:
    code = "import sys; sys.modules['cyclonedds'] = None; from skylimb.apps.cli import main; sys.exit(main())"
    words = [sys.executable, "-c", code, "ros2", "both"]
    said = subprocess.run(words, capture_output=True, text=True, timeout=120, check=False)
    assert said.returncode == 2
    assert said.stderr == "skylimb: error: 'cyclonedds' is not installed: pip install 'skylimb[ros2]'\n"


@pytest.mark.parametrize("number", ["-1", "233", "one", "1.5"])
def test_a_domain_that_is_no_number_is_named(monkeypatch: pytest.MonkeyPatch, number: str) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", number)
    with pytest.raises(ConfigError, match=re.escape(f"ROS_DOMAIN_ID = '{number}' is not a number")):
        ROS2.require(False)
