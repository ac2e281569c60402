"""A synthetic flight that follows the log's schema: every number in it is known beforehand."""

from __future__ import annotations

import json
import tomllib

import numpy as np
import pytest
import xarray as xr

from skylimb.analysis.notebook_run import Run
from skylimb.analysis.paper.configuration import CONTROLLERS, FILE
from skylimb.analysis.scores.metrics import metrics
from skylimb.base.config import write_toml

PHASES = "hover tare approach settle slide retreat hover_end"
AXES = ["x", "y", "z"]
SLOPE = np.radians(20.0)
CENTRE = np.array([1.2, 0.0, 1.2])
NORMAL = np.array([-np.cos(SLOPE), np.sin(SLOPE), 0.0])
LINKS = 4
SCENE = """
<mujoco model="synthetic">
  <option timestep="0.001"/>
  <worldbody>
    <geom name="board" type="box" pos="1.205 0 1.2" euler="0 0 -20" size="0.005 0.6 0.6" rgba=".9 .9 .88 1"/>
    <body name="link1" pos="0 0 1">
      <freejoint/>
      <geom type="capsule" fromto="0 0 0 .6 0 0" size=".02" rgba=".2 .25 .3 1"/>
      <body name="link2" pos=".6 0 0"><joint name="joint1" axis="0 0 1"/>
        <geom type="capsule" fromto="0 0 0 .6 0 0" size=".02" rgba=".2 .25 .3 1"/>
        <body name="link3" pos=".6 0 0"><joint name="joint2" axis="0 0 1"/>
          <geom type="capsule" fromto="0 0 0 .6 0 0" size=".02" rgba=".2 .25 .3 1"/>
          <body name="link4" pos=".6 0 0"><joint name="joint3" axis="0 0 1"/>
            <geom type="capsule" fromto="0 0 0 .65 0 0" size=".02" rgba=".8 .3 .1 1"/>
          </body></body></body>
    </body>
  </worldbody>
</mujoco>
"""


PAPER = tomllib.loads(FILE.read_text(encoding="utf-8"))


def papers_config(controller: str) -> str:
    """The paper's configuration as a run stores it; of another controller only the name is known."""
    gains = PAPER["controller"][controller] if controller in CONTROLLERS else {}
    tables = {"name": "paper", "seed": 3, **PAPER["experiment"]}
    return write_toml({**tables, "controller": {"name": controller, **gains}})


def timeline(dt: float, slide: float) -> tuple[np.ndarray, np.ndarray, float]:
    """Times, phase numbers and the time at which the lap starts."""
    durations = [1.0, 0.5, 1.0, 0.5, slide, 1.0, 0.5]
    ends = np.cumsum(durations)
    time = dt * np.arange(round(ends[-1] / dt))
    return time, np.searchsorted(ends, time + 1e-9, side="right").astype(np.int8), float(ends[3])


def synthetic_log(
    controller="hybrid", *, status="OK", cause="", dt=0.005, slide=6.0, error=(0.10, 0.05, -0.02), seed=3
):
    """A lap with a constant CoG error, a constant estimated force and a pulsed normal force."""
    time, phase, start = timeline(dt, slide)
    sliding = phase == PHASES.split().index("slide")
    touching = (phase >= PHASES.split().index("settle")) & (phase <= PHASES.split().index("slide"))
    angle = np.clip((time - start) / slide, 0.0, 1.0) * 2 * np.pi
    reference = np.stack([0 * time, 0.3 * np.sin(angle), 1.2 - 0.3 * np.cos(angle)], axis=1)
    cog = reference + touching[:, None] * np.asarray(error)
    theta = 0.5236 + (0.2 * np.sin(angle) * sliding if controller in {"admittance", "hybrid"} else 0 * time)
    joints = np.stack([np.pi / 2 - theta, 2 * theta, -theta], axis=1)
    heading = -np.pi / 2 + np.stack([0 * theta, *np.cumsum(joints, axis=1).T], axis=1)
    lengths = np.array([0.6, 0.6, 0.6, 0.65])
    steps = np.stack([np.cos(heading), np.sin(heading), 0 * heading], axis=2) * lengths[:, None]
    chain = np.concatenate([np.zeros((len(time), 1, 3)), np.cumsum(steps, axis=1)], axis=1)
    across = CENTRE[0] + np.tan(SLOPE) * cog[:, 1]
    tip = np.stack([across, cog[:, 1], cog[:, 2]], axis=1)
    skeleton = chain - chain[:, -1:, :] + tip[:, None, :]
    force = touching[:, None] * np.array([-1.0, 0.2, 0.1]) * np.ones_like(cog)
    normal = np.where(touching, 1.0, 0.0)
    root_quaternion = np.stack(
        [np.cos(heading[:, 0] / 2), 0 * time, 0 * time, np.sin(heading[:, 0] / 2)], axis=1
    )
    configuration = np.concatenate([skeleton[:, 0], root_quaternion, joints], axis=1)
    reach_reference = np.full_like(time, 1.09)
    reach = reach_reference - 0.25 * (theta - 0.5236)

    def vector(values, units, frame, name, kind):
        return ("time", "axis"), values, {"units": units, "frame": frame, "long_name": name, "kind": kind}

    def scalar(values, units, name, kind):
        return ("time",), values, {"units": units, "frame": "", "long_name": name, "kind": kind}

    return xr.Dataset(
        {
            "cog_position": vector(cog, "m", "W", "position of the centre of gravity", "truth"),
            "cog_position_reference": vector(reference, "m", "W", "wanted position", "reference"),
            "external_force_estimate": vector(force, "N", "W", "estimated external force", "estimate"),
            "contact_force": vector(force, "N", "W", "contact force on the robot", "truth"),
            "contact_force_normal": scalar(normal, "N", "normal contact force", "truth"),
            "contact": scalar(touching.astype(np.int8), "1", "the tip touches", "truth"),
            "contact_duty": scalar(touching.astype(float), "1", "fraction of steps in touch", "truth"),
            "tip_position": vector(tip, "m", "W", "position of the tip", "truth"),
            "tilt": scalar(0.01 * np.ones_like(time), "rad", "tilt", "truth"),
            "reach": scalar(reach, "m", "reach", "truth"),
            "reach_command": scalar(reach, "m", "commanded reach", "command"),
            "reach_reference": scalar(reach_reference, "m", "wanted reach", "reference"),
            "shape_angle_command": scalar(theta, "rad", "commanded shape angle", "command"),
            "joint_angles": (
                ("time", "joint"),
                joints,
                {"units": "rad", "frame": "", "long_name": "q", "kind": "truth"},
            ),
            "phase": (
                ("time",),
                phase,
                {"units": "1", "flag_values": list(range(7)), "flag_meanings": PHASES, "kind": "reference"},
            ),
            "configuration": (("time", "qpos"), configuration, {"units": "1", "kind": "truth"}),
            "skeleton": (
                ("time", "node", "axis"),
                skeleton,
                {"units": "m", "frame": "W", "long_name": "chain", "kind": "truth"},
            ),
        },
        coords={
            "time": ("time", time, {"units": "s"}),
            "axis": AXES,
            "joint": ["joint1", "joint2", "joint3"],
        },
        attrs={
            "robot": "hydrus_xi_quad",
            "experiment": "paper",
            "controller": controller,
            "seed": seed,
            "status": status,
            "cause": cause,
            "config": papers_config(controller),
            "versions": json.dumps({"skylimb": "0.1.0", "python": "3.11"}),
            "scene": SCENE,
            "surface": json.dumps(
                {
                    "kind": "board",
                    "origin": CENTRE.tolist(),
                    "axis_u": [float(np.sin(SLOPE)), float(np.cos(SLOPE)), 0.0],
                    "axis_v": [0.0, 0.0, 1.0],
                    "normal": NORMAL.tolist(),
                    "slope": SLOPE,
                }
            ),
            "contact_axis": "x",
            "sliding_axes": ["y", "z"],
        },
    )


def synthetic_run(controller="hybrid", name=None, **options) -> Run:
    """The same as a `Run` with its metrics."""
    log = synthetic_log(controller, **options)
    return Run(name=name or controller, controller=controller, log=log, metrics=metrics(log))


def event(kind="push", time=2.0, duration=1.0, words="2 N on link4", **keys):
    """An event as a log has it."""
    own = {"force": [0.0, 2.0, 0.0], "torque": [0.0, 0.0, 0.0], "link": "link4", "point": [0.0, 0.0, 0.0]}
    more = {**(own if kind == "push" else {}), **keys}
    return {"kind": kind, "time": time, "duration": duration, "words": words, **more}


def with_events(log: xr.Dataset, *events: dict) -> xr.Dataset:
    """The log of a flight to which this happened."""
    return log.assign_attrs(events=json.dumps(events))


@pytest.fixture(scope="session")
def make_event():
    return event


@pytest.fixture(scope="session")
def happening():
    return with_events


@pytest.fixture(scope="session")
def make_log():
    return synthetic_log


@pytest.fixture(scope="session")
def make_run():
    return synthetic_run


@pytest.fixture(scope="session")
def four_runs():
    """The paper's comparison, with one flight that was lost half way."""
    names = ("pid", "impedance", "admittance", "hybrid")
    runs = {
        name: synthetic_run(name, error=(0.1 + 0.01 * i, 0.05 + 0.01 * i, -0.02))
        for i, name in enumerate(names)
    }
    whole = synthetic_log("admittance", status="FAILED", cause="tilt above 1 rad at t = 5.00 s")
    log = whole.isel(time=slice(0, 1000))
    runs["admittance"] = Run("admittance", "admittance", log, metrics(log))
    return runs
