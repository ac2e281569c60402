"""Whether ROS 1 is installed, and what to install where it is not."""

from __future__ import annotations

import os
import sys
from importlib import import_module
from pathlib import Path
from typing import Any
from urllib.parse import urlparse

from skylimb.base.errors import ConfigError, MissingExtraError
from skylimb.base.xml_text import read_xml

DEBIAN = Path("/usr/lib/python3/dist-packages")
PACKAGES = "python3-rospy python3-rosmaster python3-roslaunch"
"""Debian's packages, by which ROS 1 is installed without a workspace."""

_NEEDED = ("rospy", "rosgraph")
_LOOPBACK = ("localhost", "127.0.0.1", "::1", "[::1]")


def require_ros() -> None:
    """Make rospy importable, from this environment, else from where Debian's packages are.

    Debian's folder goes to the end of the path, so that nothing of this environment is replaced.

    Raises:
        MissingExtraError: where it is in neither.
    """
    missing = _missing()
    if missing and DEBIAN.is_dir() and str(DEBIAN) not in sys.path:
        sys.path.append(str(DEBIAN))
        missing = _missing()
    if missing:
        raise MissingExtraError(f"ROS 1 is not installed ({missing}): apt-get install {PACKAGES}")


def _missing() -> str:
    """Why ROS cannot be imported; empty where it can."""
    try:
        for name in _NEEDED:
            import_module(name)
    except ImportError as error:
        return str(error)
    return ""


def require_loopback(anywhere: bool) -> None:
    """Keep a node on this machine: its own addresses, and its master's.

    Raises:
        ConfigError: when the master is another machine's and `anywhere` was not given.
    """
    if anywhere:
        return
    uri = os.environ.setdefault("ROS_MASTER_URI", "http://127.0.0.1:11311")
    host = urlparse(uri).hostname or ""
    if host not in _LOOPBACK:
        raise ConfigError(
            f"ROS_MASTER_URI = '{uri}' is not this machine, and whoever is there commands the robot; "
            "--anywhere allows it"
        )
    os.environ["ROS_IP"] = "127.0.0.1"
    os.environ.pop("ROS_HOSTNAME", None)


def require_master() -> None:
    """Raise a `ConfigError` where no master answers; rospy would wait for one for ever."""
    import rosgraph

    if not rosgraph.is_master_online():
        uri = os.environ.get("ROS_MASTER_URI", "")
        raise ConfigError(f"no ROS master answers at '{uri}'; start roscore in another window")


def described_mass(namespace: str) -> float | None:
    """Mass of the robot that ROS's parameters describe, kg; None where they describe none."""
    try:
        text = _parameter(f"/{namespace.strip('/')}/robot_description")
        masses = [float(one.get("value", "nan")) for one in read_xml(str(text).encode()).iter("mass")]
    except Exception:  # there is none, or it is no description
        return None
    return sum(masses) if masses else None


def by_clock() -> bool:
    """Whether nodes live by `/clock`: the parameter `/use_sim_time`."""
    return _parameter("/use_sim_time") is True


def _parameter(name: str) -> Any:
    """A parameter of the master; None where it has none of that name."""
    import rosgraph

    try:
        return rosgraph.Master("/skylimb").getParam(name)
    except Exception:  # rosgraph has several of its own
        return None
