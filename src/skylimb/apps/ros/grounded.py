"""The simulated plant as a robot that stands on the ground until its rotors carry it.

The physics knows no ground. A robot whose measured link is as low as it stands, and whose centre of gravity
does not rise, is put back at rest where it stands after every tick. So torques that it would turn by are lost
on the ground, and it leaves it once its rotors lift it, whatever turn they give it.
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from skylimb.apps.ros.tick import STARTED_BY_ITS_USER
from skylimb.base.packing import Layout
from skylimb.control.estimation.records import Measurement
from skylimb.control.records import Command
from skylimb.flight.drivers.hooks import with_own_model
from skylimb.flight.drivers.world import world
from skylimb.flight.events import require_applied
from skylimb.flight.flying import simulated_vehicle
from skylimb.flight.takeoff import Takeoff

STAND = 0.15
"""Height of the measured link of a robot that stands, m."""


class GroundedPlant:
    """The plant; the ground holds whoever sinks below it, at rest and as it came down.

    Args:
        takeoff: gives plant, sensors and surface; its mission only where the robot stands. Its noise comes
            again after its last tick.
        angles: of joints and vectoring joints that it stands with, rad; the mission's first ones by default.
    """

    def __init__(self, takeoff: Takeoff, angles: np.ndarray | None = None) -> None:
        require_applied(takeoff.experiment.events, (), STARTED_BY_ITS_USER)
        here = world(takeoff)
        if here.plant is takeoff.plant:
            here = here._replace(plant=with_own_model(here.plant))
        self._model, self._data = here.plant.model, here.data
        self._data.qpos[2] = STAND
        robot = takeoff.robot
        self._servos = slice(robot.n_rotors, robot.n_rotors + robot.n_joints + robot.n_vectoring)
        springs = (
            self._model.actuator_gainprm[self._servos, 0],
            self._model.actuator_biasprm[self._servos, 1:3],
        )
        self._springs = springs[0].copy(), springs[1].copy()
        if angles is not None:
            self._data.qpos[here.plant.places] = angles
            self._data.act[self._servos] = angles
        self._vehicle = simulated_vehicle(takeoff, here)
        self._places = np.array(here.plant.joint_qpos, int), np.array(here.plant.vectoring_qpos, int)
        self._root = self._model.body(takeoff.robot.description.root).id
        self._stands: np.ndarray | None = np.array(self._data.qpos[0:7])

    @property
    def layout(self) -> Layout[dict[str, Any]]:
        """That of the plant."""
        return self._vehicle.layout

    @property
    def stands(self) -> bool:
        """Whether the ground holds it."""
        return self._stands is not None

    @property
    def over(self) -> str:
        """Why it cannot go on; empty while it can."""
        return self._vehicle.fault()

    def measure(self) -> Measurement:
        """What the sensors say."""
        return self._vehicle.measure()

    def truth(self) -> Measurement:
        """What is really so: without noise, and of this tick."""
        q, v, (joints, gimbals) = np.array(self._data.qpos), np.array(self._data.qvel), self._places
        return Measurement(q[0:3], q[3:7], v[0:3], v[3:6], q[joints], q[gimbals])

    def record(self, measurement: Measurement, command: Command) -> np.ndarray:
        """The tick's signals, truth among them."""
        return self._vehicle.record(measurement, command)

    def apply(self, command: Command) -> None:
        """A tick of physics, then the ground."""
        self._vehicle.apply(command)
        self._hold()

    def enable(self, on: np.ndarray) -> None:
        """Switch the servos' torque: 1 or 0 for each, shape joints first."""
        stiffness, bias = self._springs
        self._model.actuator_gainprm[self._servos, 0] = on * stiffness
        self._model.actuator_biasprm[self._servos, 1:3] = on[:, None] * bias

    def _hold(self) -> None:
        """Put a robot that is on the ground and does not rise back at rest."""
        mujoco.mj_subtreeVel(self._model, self._data)
        if self._data.qpos[2] > STAND or self._data.subtree_linvel[self._root, 2] > 0.0:
            self._stands = None
            return
        if self._stands is None:
            self._stands = np.array(self._data.qpos[0:7])
            self._stands[2] = STAND
        self._data.qpos[0:7] = self._stands
        self._data.qvel[0:6] = 0.0
