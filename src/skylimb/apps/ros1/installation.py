"""Whether ROS 1 is installed, and what to install where it is not."""

from __future__ import annotations

import os
import socket
import sys
import time
from collections.abc import Collection
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
_LEAVING = 3.0
"""Seconds that a node of our name has to be gone."""
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


def node_name(profile: str) -> str:
    """What a node of this profile is called, below no namespace."""
    return f"skylimb_{profile}"


def require_master(profile: str) -> None:
    """Raise a `ConfigError` where no master answers, for whom rospy would wait for ever.

    So where a node of this profile runs: the master shuts down a node when another one takes its name, and
    that node may be flying.
    """
    import rosgraph

    uri = os.environ.get("ROS_MASTER_URI", "")
    if not rosgraph.is_master_online():
        raise ConfigError(f"no ROS master answers at '{uri}'; start roscore in another window")
    name, end = f"/{node_name(profile)}", time.monotonic() + _LEAVING
    while answers(name):  # a flight that was killed leaves a node that is on its way out
        if time.monotonic() > end:
            raise ConfigError(
                f"node '{name}' runs already below the master at '{uri}', and a second one of its name would "
                "end it, also in flight; end that one first, or use another master"
            )
        time.sleep(0.1)


def require_alone(profile: str, sensors: Collection[str], commands: Collection[str]) -> None:
    """Raise a `ConfigError` where another node is the robot that this one would be, or a robot of its own.

    Args:
        profile: one of `PROFILES`; a `controller` finds a robot and waits for who commands it, but one that
            does both is flown by itself.
        sensors: whole names of the topics on which a robot speaks.
        commands: of those on which it is commanded.
    """
    import rosgraph

    def publishers(names: Collection[str]) -> dict[str, str]:
        return {node: topic for topic, nodes in known if topic in names for node in nodes}

    controls, end = profile == "controller", time.monotonic() + _LEAVING
    while True:
        known = rosgraph.Master("/skylimb").getSystemState()[0]
        says, commanded = publishers(sensors), publishers(commands)
        others = says.keys() & commanded.keys() if controls else says.keys() | commanded.keys()
        name = next((other for other in sorted(others) if answers(other) is not False), "")
        if not name:
            return
        if time.monotonic() > end:
            why = "flies its robot itself" if controls else f"{profile} would publish it as well"
            raise ConfigError(
                f"node '{name}' publishes '{(says | commanded)[name]}', and {why}; end that one first, or "
                "take another --namespace"
            )
        time.sleep(0.1)


def answers(name: str) -> bool | None:
    """Whether somebody answers at the address of a node of this name; None where that cannot be known."""
    import rosgraph

    try:
        address = urlparse(rosgraph.Master("/skylimb").lookupNode(name))
        with socket.create_connection((address.hostname or "", address.port or 0), timeout=1.0):
            return True
    except (ConnectionRefusedError, rosgraph.MasterException):  # a registration that a kill left; or none
        return False
    except OSError:  # no way to its machine
        return None


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
