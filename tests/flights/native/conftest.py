"""Short flights, ready for either driver."""

from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np
import pytest

import skylimb
from skylimb.control.cascade import Cascade
from skylimb.experiments.flyable import first_row
from skylimb.experiments.run import prepare_flight
from skylimb.simulation.drivers import fly_compiled, interventions, mission_rows
from skylimb.simulation.flight import Flight
from skylimb.simulation.native import NativeJob, native_available
from skylimb.simulation.plant import initial_data
from skylimb.simulation.tick import compile_tick

SHORT = {
    "phases.hover": 0.4,
    "phases.tare": 0.3,
    "phases.settle": 0.3,
    "phases.hover_end": 0.1,
    "approach.depth": 0.05,
    "approach.standoff": 0.02,
    "approach.speed": 0.2,
    "approach.retreat_speed": 0.3,
    "trajectory.radius": 0.05,
    "trajectory.period": 1.5,
}


@pytest.fixture(scope="session", autouse=True)
def _compiler() -> None:
    if not native_available():
        pytest.skip("no C compiler on this machine")


def _make_job(
    experiment: str = "paper", controller: str = "hybrid", set: dict[str, Any] | None = None, seed: int = 0
) -> NativeJob:
    """A flight of a shipped experiment with some of its values changed."""
    changes = {**(SHORT if experiment == "paper" else {}), **(set or {}), "seed": seed}
    flown = skylimb.load_experiment(experiment, changes)
    robot = skylimb.load_robot(flown.robot)
    cascade = skylimb.load_controller(controller, robot)
    assert isinstance(cascade, Cascade)
    plant, mission = prepare_flight(flown, robot, cascade.preset.vectoring.purpose)
    data = initial_data(plant, first_row(mission))
    root = np.concatenate([data.qpos[0:7], data.qvel[0:6]])
    tick = compile_tick(cascade, plant, flown.sensors, root, flown.control_period)
    rows = mission_rows(plant, mission, flown.sensors, flown.seed, cascade.paced)
    rows = rows.with_changes(flown.gain_changes, tick, flown.control_period)
    return NativeJob(tick, plant, data, mission, rows, flown.disturbance)


def _fly_slowly(job: NativeJob) -> Flight:
    """The Python driver on the same job, whose own data stays as it is."""
    data = mujoco.MjData(job.plant.model)
    mujoco.mj_copyData(data, job.plant.model, job.data)
    times = job.mission.flight_times(job.compiled.clock is not None)
    outside = interventions(job.plant, data, times, job.disturbance)
    return fly_compiled(job.compiled, job.plant, data, job.mission, job.rows, outside)


@pytest.fixture(scope="session")
def make_job() -> Callable[..., NativeJob]:
    return _make_job


@pytest.fixture(scope="session")
def fly_slowly() -> Callable[[NativeJob], Flight]:
    return _fly_slowly
