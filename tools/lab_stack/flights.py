"""The lab's own flight_check.py, flown by the lab's own stack on `skylimb ros simulator`.

    python tools/lab_stack/flights.py SOURCES WORKSPACE [--robot hydrus|hydrus_xi] [--runs 10]
        [--seed 0] [--python DIR ...] [--set KEY=VALUE ...] [--out DIR]

SOURCES is a checkout of jsk_aerial_robot, WORKSPACE a folder below which its nodes are, built. With --python
come packages that are not in the environment: `ros_numpy`, `smach`, and the lab's messages. The robot is
imported from the lab's xacro, so that both sides have the same one.

hydrus goes through the postures of the lab's own test, with its thresholds, and what fails is flown once
more, as that test asks (`retry`); hydrus_xi, for which the lab has no such test, through ten postures of its
family, and has to keep 3 degrees of yaw and 90 mm an axis. Without the lab's stack one line says so, and
nothing is flown. Exit code 1 for a run that fails to its last try.
"""

from __future__ import annotations

import argparse
import json
import signal
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from stack import ROBOTS, LabStack, MissingError, process

import skylimb
from skylimb.robots.loader import load_robot

TEST = "robots/hydrus/test"
FAR, TURN = 0.09, float(np.deg2rad(3.0))
"""Off the place, m an axis, and off the yaw, rad: what hydrus_xi has to keep."""

SHAPES = 0.70, 0.25, 10
"""First and last shape angle, rad, and how many: at pi/4 and .2 the lab's planner finds no first solution."""

REACHED = 0.08
"""Of a joint's angle, rad: servos hang by up to 0.06 under the rotors."""

CALIBRATED = {"sensors.imu.accelerometer_bias_drawn": "0", "sensors.imu.gyro_bias_drawn": "0"}
"""The lab's own simulation gives its board the true attitude; here an IMU without biases makes it."""

_JOINTS = ["joint1", "joint2", "joint3"]
_LONGEST = 900.0
"""Seconds of a run on a busy computer."""

_PYTHON = "/usr/bin/python3"
"""Debian's ROS is for Debian's own Python."""


_AGAIN = 1000
"""From a run's seed to that of its next try."""


def _test(sources: Path) -> ET.Element:
    return ET.parse(sources / TEST / "tilted_hydrus_control.test").getroot()


def tries(robot: str, sources: Path) -> int:
    """How often a run may be flown: the lab's own test is repeated when it fails."""
    if robot != "hydrus":
        return 1
    return 1 + sum(int(one.get("retry", "0")) for one in _test(sources).iter("test"))


def asked(robot: str, sources: Path) -> dict[str, Any]:
    """Parameters of a flight check: the lab's own for hydrus."""
    tree = _test(sources)
    text = next(one.text for one in tree.iter("rosparam") if "stable_check" in (one.text or ""))
    found = yaml.safe_load(text or "")
    if robot == "hydrus":
        return found
    family = load_robot("hydrus_xi_quad").description.posture
    shapes = np.outer(np.linspace(*SHAPES), family.slope) + family.offset
    found["init_form"] |= {"joint_angles": shapes[0].tolist(), "angle_thresh": REACHED}
    found["transform"] |= {"joint_trajectory": shapes.tolist(), "angle_thresh": REACHED}
    found["stable_check"]["pose_thresh"] = [float(np.hypot(FAR, FAR)), FAR, TURN]
    return found


def fly(lab: LabStack, name: str, folder: Path, out: Path, settings: list[str]) -> dict[str, Any]:
    """One run: what the check says, and what its flight was like."""
    robot, check = ROBOTS[name], asked(name, lab.sources)
    start = dict(zip(_JOINTS, check["init_form"]["joint_angles"], strict=True))
    with lab.flying(robot, folder, start, out, settings):
        lab.load(check, f"/{robot.namespace}/flight_test")
        seen = out / "seen.json"
        watch = [_PYTHON, str(Path(__file__).parent / "watch.py"), f"/{robot.namespace}", str(seen)]
        begun = time.monotonic()
        with process(watch, lab.environment, out / "watch.txt") as watching:
            judge = str(lab.sources / TEST / "flight_check.py")
            words = [_PYTHON, judge, f"--gtest_output=xml:{out}/result.xml"]
            environment = {**lab.environment, "ROS_NAMESPACE": f"/{robot.namespace}"}
            with (out / "check.txt").open("wb") as log:
                check_run = subprocess.Popen(words, env=environment, stdout=log, stderr=subprocess.STDOUT)
                try:
                    lab.heard(f"/{robot.namespace}/flight_state")
                    time.sleep(5.0)
                    while check_run.poll() is None and time.monotonic() - begun < _LONGEST:
                        # It listens for its start once it is connected; a second one does nothing.
                        lab.do("rostopic", "pub", "-1", "/task_start", "std_msgs/Empty", timeout=30.0)
                        time.sleep(5.0)
                finally:
                    check_run.kill()
                    check_run.wait()
            watching.send_signal(signal.SIGINT)
            watching.wait(20.0)
    said = (out / "check.txt").read_text(encoding="utf-8", errors="replace")
    flown = json.loads(seen.read_text(encoding="utf-8"))
    worst = np.max([one["worst"] for one in flown["postures"]] or [[np.nan] * 4], axis=0)
    return {
        "success": "RESULT: SUCCESS" in said,
        "worst": dict(zip(("x", "y", "z", "yaw"), worst.tolist(), strict=True)),
        **flown,
    }


def _line(run: dict[str, Any]) -> str:
    x, y, z, yaw = run["worst"].values()
    verdict = "SUCCESS" if run["success"] else "FAIL"
    off = f"{x:.3f} {y:.3f} {z:.3f} m and {yaw:.3f} rad"
    return f"seed {run['seed']}: {verdict}, off by {off} at most in hover"


def main() -> int:
    """All runs; see the top of the file."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("sources", type=Path)
    parser.add_argument("workspace", type=Path)
    parser.add_argument("--robot", choices=ROBOTS, default="hydrus")
    parser.add_argument("--runs", type=int, default=10)
    parser.add_argument("--python", type=Path, nargs="*", default=[])
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--set", nargs="*", default=[], metavar="KEY=VALUE")
    parser.add_argument("--out", type=Path, default=Path("out/lab_stack"))
    given = parser.parse_args()
    try:
        lab = LabStack(given.sources.resolve(), given.workspace.resolve(), given.python)
    except MissingError as error:
        print(f"skipped: {error}")
        return 0
    out, runs = given.out.resolve() / given.robot, list[dict[str, Any]]()
    most = tries(given.robot, lab.sources)
    with tempfile.TemporaryDirectory() as folder:
        imported = Path(folder) / given.robot
        skylimb.import_robot(lab.sources / ROBOTS[given.robot].xacro, imported, lab.sources)
        for k in range(given.seed, given.seed + given.runs):
            for seed in range(k, k + most * _AGAIN, _AGAIN):
                keys = {"seed": str(seed), **CALIBRATED, **dict(word.split("=", 1) for word in given.set)}
                settings = [f"{key}={value}" for key, value in keys.items()]
                flown = fly(lab, given.robot, imported, out / f"run{seed}", settings)
                runs.append({"seed": seed, **flown})
                print(_line(runs[-1]), flush=True)
                (out / "runs.json").write_text(json.dumps(runs, indent=1), encoding="utf-8")
                if flown["success"]:
                    break
    passed = [run["seed"] for run in runs if run["success"]]
    first = sum(seed < given.seed + given.runs for seed in passed)
    again = f", {first} of them at the first try" if most > 1 else ""
    print(f"{given.robot}: {len(passed)} of {given.runs} runs with SUCCESS{again}")
    return int(len(passed) < given.runs)


if __name__ == "__main__":
    sys.exit(main())
