"""DDS is known in the middleware alone; where it is absent, one line says what to install."""

from __future__ import annotations

import re
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import pytest
from packaging.requirements import Requirement

import skylimb
from skylimb.apps.ros2.middleware import ROS2
from skylimb.base.errors import LAST_PYTHON, ConfigError, missing_extra

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
    assert said.stderr == f"skylimb: error: {missing_extra('cyclonedds')}\n"


@pytest.mark.parametrize(
    ("python", "what"),
    [
        ((3, 13, 5), "pip install 'skylimb[ros2]'"),
        ((3, 14, 0), "it has wheels for Python 3.13 and older, and this is 3.14"),
    ],
)
def test_a_python_without_its_wheels_is_named(
    monkeypatch: pytest.MonkeyPatch, python: tuple[int, ...], what: str
) -> None:
    monkeypatch.setattr(sys, "version_info", python)
    assert str(missing_extra("cyclonedds")) == f"'cyclonedds' is not installed: {what}"


def test_pip_asks_for_it_where_it_has_wheels() -> None:
    (wanted,) = (Requirement(line) for line in metadata.requires("skylimb") or [] if "cyclonedds" in line)
    assert wanted.marker is not None
    major, minor = LAST_PYTHON["cyclonedds"]
    for number, asked in ((minor, True), (minor + 1, False)):
        assert wanted.marker.evaluate({"extra": "ros2", "python_version": f"{major}.{number}"}) is asked


@pytest.mark.parametrize("number", ["-1", "233", "one", "1.5"])
def test_a_domain_that_is_no_number_is_named(monkeypatch: pytest.MonkeyPatch, number: str) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", number)
    with pytest.raises(ConfigError, match=re.escape(f"ROS_DOMAIN_ID = '{number}' is not a number")):
        ROS2.require(False)
