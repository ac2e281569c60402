"""The lab's own nodes around `skylimb ros simulator`: parameters, processes, and their end.

The lab's stack has to be built already, in a workspace of ROS 1; nothing of it is built or changed here.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from skylimb.apps.robot_import.urdf_text import read_urdf_text

PORT = 11978
NODES = ("aerial_robot_base_node", "servo_bridge_node")
_READY, _END = 240.0, 10.0
"""Seconds until something is there, and until it is gone."""

_STARTS, _ARM_OFF = 4, 0
"""How often the lab's node is started, and the flight state in which it waits.

A node that hears the first pose before the first `/clock` takes it for one of the year 1970, calls its sensor
dead, and lands by force before it flies. It has to be started again.
"""

_MOCAP = "aerial_robot_base/config/sensors/mocap.yaml"


@dataclass(frozen=True)
class LabRobot:
    """A robot of the lab, as its bringup.launch brings it up.

    Attributes:
        namespace: of its topics.
        xacro: its description.
        servos: its servos' file.
        parameters: further files that are loaded into the namespace.
        extra: parameters in no file.
    """

    namespace: str
    xacro: str
    servos: str
    parameters: tuple[str, ...]
    extra: Mapping[str, Any]


def _robot(name: str, xacro: str, quad: str, files: Sequence[str], extra: Mapping[str, Any]) -> LabRobot:
    top = f"robots/{name}"
    return LabRobot(
        name,
        f"{top}/robots/quad/{xacro}",
        f"{top}/config/{quad}/Servo.yaml",
        (*(f"{top}/config/{file}" for file in files), _MOCAP),
        extra,
    )


_TILTED, _EYES = "quad/tilt_20deg_201907", "quad/egomotion_estimation/upboard202007.yaml"
ROBOTS = {
    "hydrus": _robot(
        "hydrus",
        "tilt_20deg_201907/robot.urdf.xacro",
        _TILTED,
        (
            *(f"{_TILTED}/{name}.yaml" for name in ("RobotModel", "MotorInfo", "Battery", "StateEstimation")),
            *(f"{_TILTED}/FlightControl.yaml", "quad/NavigationConfig.yaml", "sensors/imu/spinal.yaml"),
        ),
        {"uav_model": 16},
    ),
    "hydrus_xi": _robot(
        "hydrus_xi",
        "upboard202007.urdf.xacro",
        "quad",
        (
            *(f"quad/{name}.yaml" for name in ("RobotModel", "Battery", "FlightControl", "NavigationConfig")),
            *("motor_info/MN4010KV475_tmotor40A_15inch.yaml", _EYES, "sensors/imu/spinal.yaml"),
        ),
        {},
    ),
}


class MissingError(Exception):
    """What has to be there, and is not."""


class LabStack:
    """Where the lab's stack stands, and how its programs are started.

    Args:
        sources: a checkout of jsk_aerial_robot.
        workspace: a folder that has its two nodes somewhere below it.
        python: folders of Python packages besides those of the environment.

    Raises:
        MissingError: when one of them is not there.
    """

    def __init__(self, sources: Path, workspace: Path, python: Sequence[Path] = ()) -> None:
        self.sources = sources
        if not (sources / "aerial_robot_base").is_dir():
            raise MissingError(f"'{sources}' is no checkout of jsk_aerial_robot")
        found = {name: next(workspace.rglob(name), None) for name in NODES}
        missing = [name for name, path in found.items() if path is None]
        missing += [name for name in ("rosmaster", "rosparam", "rostopic") if shutil.which(name) is None]
        if missing:
            raise MissingError(f"no {', '.join(missing)} below '{workspace}', nor on the path")
        self.nodes = {name: str(path) for name, path in found.items()}
        base = sources / "aerial_robot_base" / "src"
        own = [str(path) for path in (base, *python)]
        self.environment = {
            **os.environ,
            "ROS_MASTER_URI": f"http://127.0.0.1:{PORT}",
            "ROS_IP": "127.0.0.1",
            "PYTHONPATH": os.pathsep.join([*own, *filter(None, [os.environ.get("PYTHONPATH")])]),
        }

    def do(self, *words: str, timeout: float = _READY) -> str:
        """What a program of ROS says."""
        done = subprocess.run(
            words, env=self.environment, capture_output=True, text=True, timeout=timeout, check=True
        )
        return done.stdout

    def load(self, values: Mapping[str, Any], below: str) -> None:
        """Set parameters."""
        with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
            yaml.safe_dump(dict(values), file)
            file.flush()
            self.do("rosparam", "load", file.name, below)

    @contextlib.contextmanager
    def flying(
        self,
        robot: LabRobot,
        folder: Path,
        start: Mapping[str, float],
        out: Path,
        settings: Sequence[str] = (),
    ) -> Iterator[None]:
        """Master, simulator and the lab's nodes, which end with the block; what they say is kept in `out`.

        Args:
            robot: of the lab.
            folder: the same robot, imported.
            start: joint angles with which it stands, rad.
            out: folder of what they say.
            settings: of the simulator, KEY=VALUE.
        """
        out.mkdir(parents=True, exist_ok=True)
        with contextlib.ExitStack() as running:

            def begin(name: str, *words: str) -> contextlib.ExitStack:
                own = running.enter_context(contextlib.ExitStack())
                own.enter_context(process(words, self.environment, out / f"{name}.txt"))
                return own

            begin("master", "rosmaster", "--core", "-p", str(PORT))
            _until(lambda: self.do("rosparam", "list") is not None, "the ROS master")
            # All live by the simulator's clock, so that a busy computer is slow and loses nothing.
            self.load({"use_sim_time": True}, "/")
            below = f"/{robot.namespace}"
            for file in (*robot.parameters, robot.servos):
                self.do("rosparam", "load", str(self.sources / file), below)
            urdf = read_urdf_text(self.sources / robot.xacro, self.sources).content.decode("utf-8")
            base = {"tf_prefix": robot.namespace, "param_verbose": False, "main_rate": 40}
            more = {
                **{"robot_description": urdf, "estimation": {"mode": 1}, **robot.extra},
                # Gazebo's controllers are not there: the bridge is to speak with the servos.
                **{"servo_bridge": {"use_mujoco": True}, NODES[0]: base},
            }
            self.load(more, below)
            begin(
                "simulator",
                *(sys.executable, "-m", "skylimb", "ros", "simulator", "--robot", str(folder)),
                *("--link", "fc", "--namespace", robot.namespace, "--messages", str(self.sources)),
                *("--config", str(self.sources / robot.servos)),
                *(("--set", *settings) if settings else ()),
                *("--start", *(f"{name}={angle!r}" for name, angle in start.items())),
            )
            self.heard(f"{below}/mocap/pose")
            begin("servo_bridge", self.nodes[NODES[1]], f"__ns:={below}", "__name:=servo_bridge")
            self.start_base(begin, below)
            yield

    def start_base(self, begin: Callable[..., contextlib.ExitStack], below: str) -> None:
        """Start the lab's node until it waits for its first order; `begin(name, *words)` starts a program."""
        for k in range(_STARTS):
            node = begin(f"{NODES[0]}_{k}", self.nodes[NODES[0]], f"__ns:={below}", f"__name:={NODES[0]}")
            self.heard(f"{below}/uav/baselink/odom")
            said = self.do("rostopic", "echo", "-n1", f"{below}/flight_state/data", timeout=20.0)
            if int(said.split()[0]) == _ARM_OFF:
                return
            node.close()
        raise MissingError(f"{NODES[0]} lands by force before it flies, {_STARTS} times")

    def heard(self, topic: str) -> None:
        """Wait until somebody says something on a topic."""
        _until(lambda: self.do("rostopic", "echo", "-n1", topic, timeout=20.0) != "", topic)


@contextlib.contextmanager
def process(words: Sequence[str], environment: Mapping[str, str], log: Path) -> Iterator[Any]:
    """A program that ends with the block."""
    with log.open("wb") as file:
        one = subprocess.Popen(words, env=environment, stdout=file, stderr=subprocess.STDOUT)
        try:
            yield one
        finally:
            one.terminate()
            try:
                one.wait(_END)
            except subprocess.TimeoutExpired:
                one.kill()
                one.wait()


def _until(holds: Any, what: str) -> None:
    """Wait until something holds; a program that fails or hangs is tried again."""
    end = time.monotonic() + _READY
    while time.monotonic() < end:
        with contextlib.suppress(subprocess.SubprocessError):
            if holds():
                return
        time.sleep(0.3)
    raise MissingError(f"{what} did not come within {_READY:g} s")
