"""A recorded flight as the input of `host.c`: what a flight computer would have been given at every tick."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from skylimb.analysis.recording.run import Run
from skylimb.base.packing import Layout, pack_rows
from skylimb.control.controller import Controller, require_compiled
from skylimb.control.estimation.records import ABSENT, zero_measurement
from skylimb.control.missions.reference import zero_reference
from skylimb.control.needs import needs_of, require_imu
from skylimb.flight.experiments.experiment import Experiment, robot_of
from skylimb.flight.export.files import export_c
from skylimb.flight.loading import chosen_controller
from skylimb.flight.plan import mission_of
from skylimb.flight.replay.recorded import recorded, sampled
from skylimb.flight.replay.replay import experiment_of, naming_its_files

FLIGHT = "flight.bin"
"""The input's name beside the code."""


def export_with_flight(run: Run, folder: str | Path, losses: bool | None = None) -> list[Path]:
    """Write the controller of a recorded flight as C, and beside it what that flight would have given it.

    Its supervisor acts when that of the flight did.

    Args:
        run: a recorded flight with its configuration.
        folder: new.
        losses: whether the supervisor looks for lost rotors; None as in the flight.

    Returns:
        The files.
    """
    with tempfile.TemporaryDirectory(prefix="skylimb-") as home, naming_its_files(Path(home)):
        experiment, _ = experiment_of(run, Path(home), {})
        chosen = chosen_controller(None, experiment, robot_of(experiment), {})
        content = host_input(run, experiment, chosen).tobytes()
        limits = experiment.supervisor
        if losses is not None:
            limits = replace(limits, losses=losses)
        return export_c(chosen, folder, experiment.control_period, {FLIGHT: content}, limits)


def host_input(run: Run, experiment: Experiment, controller: Controller) -> np.ndarray:
    """Measurement and reference of every tick of a run, (ticks, width), in the order of `controller.h`.

    Args:
        run: a recorded flight.
        experiment: that was flown.
        controller: that was exported.

    Raises:
        ConfigError: when the controller cannot be exported, or the log holds no pose.
    """
    controller = require_compiled(controller, "written as C")
    robot, period, needs = controller.robot, experiment.control_period, needs_of(controller)
    log, _ = sampled(run.log, period)
    held = recorded(log, robot, period, needs.vectoring)
    mission = mission_of(experiment, robot, needs.vectoring).along(held.clock)
    require_imu(controller, held.measurement.imu is not None, "the log has none")
    measured = held.measurement if needs.imu else held.measurement._replace(imu=ABSENT)
    sizes = Layout(zero_measurement(robot.n_joints, robot.n_vectoring, needs.imu))
    references = Layout(zero_reference(robot.n_joints, robot.n_vectoring))
    return np.hstack(
        [
            pack_rows(sizes, measured, len(held)),
            pack_rows(references, mission.reference, len(held)),
        ]
    )
