"""A short time ahead, flown many times over: the simulator with an inner loop, on the native batch.

Every rollout begins at the state that an estimate says, behind a board across the contact axis that stands
where the pen touches it. What is not estimated is what it is in a hover: rotors, servos, the inner loop's own
memory. A surface that comes toward the path is a board that stands still, in a frame that goes with it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from skylimb.base.rotations import quaternion_from_rotation
from skylimb.control.controller import load_controller
from skylimb.flight.drivers.native.lockstep import LockStep
from skylimb.flight.experiments.experiment import experiment_with, load_experiment
from skylimb.flight.takeoff import prepare
from skylimb.robots.model import Robot
from skylimb.simulation.rows import reference_layout

PERIOD = 0.005
AHEAD = np.array([1.0, 0.0, 0.0])
"""Contact axis of the model's board."""
_BOARD = {
    "surface.slope": 0.0,
    "sensors.latency": 0.0,
    "sensors.rate": 0.0,
    "supervisor.on": False,
    "phases.hover": 0.5,
    "stop_at": 1.5,
    "terminations.distance": 1000.0,
}
_QUIET = ("position", "velocity", "attitude", "angular_velocity", "joint", "vectoring")
_INNER = {
    "estimation.law": "momentum",
    "estimation.smoothing.on": False,
    "contact.law": "open",
    "shape.law": "fixed",
    "translation.law": "impedance",
    "translation.virtual_mass_ratio": [1.0, 1.0, 1.0],
}


class Begin(NamedTuple):
    """Where rollouts begin: estimated body and arm, measured angles, depth of the pen in the board, m."""

    body: Any
    joint_angles: np.ndarray
    vectoring_angles: np.ndarray
    arm: np.ndarray
    depth: float


class Flown(NamedTuple):
    """Of rollouts, at every tick: the tip, W, m, (n, ticks, 3), and the normal force, N, (n, ticks).

    A rollout that was lost has no numbers.
    """

    tip: np.ndarray
    force: np.ndarray


class Rollouts:
    """As many flights of the model as there are samples.

    Args:
        robot: the controller's model.
        count: how many.
        ticks: that each lasts.
        spring: gains of the inner loop's impedance, normalized_stiffness and damping_ratio.
        friction: of the model's board.
    """

    def __init__(self, robot: Robot, count: int, ticks: int, spring: dict[str, Any], friction: float) -> None:
        quiet = {f"sensors.{name}_noise": 0.0 for name in _QUIET}
        changes = {**_BOARD, **quiet, "surface.friction": friction}
        experiment = experiment_with(load_experiment("paper"), changes)
        inner = _INNER | {f"translation.{name}": value for name, value in spring.items()}
        self._takeoff = prepare(experiment, robot, load_controller("following", robot, inner))
        self._ticks = ticks
        self._flights = LockStep([self._takeoff] * count, ticks)
        self._own = [self._flights.own_references(place) for place in range(count)]
        self._signals = self._takeoff.tick.signals.slices
        self._asked = reference_layout(robot)
        plant, start = self._takeoff.plant, self._takeoff.start
        self._places, self._rotors = plant.places, robot.n_rotors
        self._sag = start.act[self._rotors :] - start.qpos[plant.places]
        self._front = float(experiment.surface.position[0]) - robot.description.tip.radius

    def fly(self, begin: Begin, reference: Any, positions: np.ndarray, speed: float) -> Flown:
        """Fly them all.

        Args:
            begin: where.
            reference: of the tick; posture, heading and axes are taken from it.
            positions: where each wants the centre of gravity to be at every tick, (count, ticks + 1, 3).
            speed: at which the surface comes along the contact axis, m/s.
        """
        body, model = begin.body, begin.body.model
        count, R_WB = len(positions), body.R_WC @ model.R_root_C.T
        tip = body.position + begin.arm
        shift = np.array([self._front + begin.depth - tip[0], -tip[1], 1.2 - tip[2]])
        start = self._takeoff.start
        qpos, qvel, act = start.qpos.copy(), np.zeros_like(start.qvel), start.act.copy()
        angles = np.concatenate([begin.joint_angles, begin.vectoring_angles])
        qpos[:3] = body.position + shift - R_WB @ model.cog_root
        qpos[3:7], qpos[self._places] = quaternion_from_rotation(R_WB), angles
        rates = model.R_root_C @ body.angular_velocity
        qvel[:3] = body.velocity - speed * AHEAD - R_WB @ np.cross(rates, model.cog_root)
        qvel[3:6] = rates
        act[: self._rotors], act[self._rotors :] = model.hover_thrusts, angles + self._sag
        # Set points that hold the measured angles; `align` keeps the tip link on its heading at any of them.
        q, psi = np.split(angles + self._sag, [len(begin.joint_angles)])
        still = reference._replace(
            joint_angles=q, vectoring_angles=psi, align=1.0, tare=0.0, adapt=0.0, touch=0.0,
            acceleration=np.zeros(3), ahead=(),
        )  # fmt: skip
        row, where = self._asked.pack(still), self._asked.slices
        times = PERIOD * np.arange(self._ticks + 1)
        for place in range(count):
            self._flights.again(place, qpos, qvel, act)
            asked = self._own[place][: self._ticks + 1]
            asked[:] = row
            asked[:, where["position"]] = positions[place] + shift - np.outer(speed * times, AHEAD)
            velocity = np.gradient(positions[place], PERIOD, axis=0)
            asked[:, where["velocity"]] = velocity - speed * AHEAD
        self._flights.fly(range(count), self._ticks)
        rows = self._flights.rows[:, : self._ticks]
        cog = rows[..., self._signals["cog_position_estimate"]] - shift
        cog = cog + (speed * times[:-1])[:, None] * AHEAD
        lever = body.R_WC.T @ begin.arm
        tips = cog + _turned(rows[..., self._signals["attitude_estimate"]], lever)
        return Flown(tips, -rows[..., self._signals["contact_force"]] @ AHEAD)


def _turned(rpy: np.ndarray, lever: np.ndarray) -> np.ndarray:
    """A vector of {C} in W at every tick."""
    (a, b, c), (x, y, z) = np.moveaxis(rpy, -1, 0), lever
    y, z = np.cos(a) * y - np.sin(a) * z, np.sin(a) * y + np.cos(a) * z
    x, z = np.cos(b) * x + np.sin(b) * z, np.cos(b) * z - np.sin(b) * x
    return np.stack([np.cos(c) * x - np.sin(c) * y, np.sin(c) * x + np.cos(c) * y, z], axis=-1)
