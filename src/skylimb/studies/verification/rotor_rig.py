"""A test rig for rotors: a body with four of them, in no gravity, whose thrusts are commanded by hand."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from skylimb.base.bound_function import BoundFunction
from skylimb.robots.description import PostureFamily, RobotDescription, Rotor, Servos, Tip
from skylimb.robots.links import Inertial, Joint, Link
from skylimb.robots.model import Robot
from skylimb.simulation.plant import Plant, build_plant
from skylimb.simulation.plant_config import PlantConfig
from skylimb.simulation.plant_tick import plant_numbers, rotor_scales
from skylimb.simulation.surfaces import Board
from skylimb.simulation.vehicle import actuator_function

PERIOD = 0.005  # s, control period of the rigs
FACTOR = 4e-5  # N s^2
LAG = 0.05  # s
MASS, ACROSS, ALONG = 4.0, 0.2, 0.3  # kg and kg m^2 of the rigs' body
ARM = 0.3  # m, from the body's middle to each of its rotors
FINE = 0.0005  # s, physics step where another model is beside


def description(
    inertia: float = 3e-4,
    spins: tuple[int, ...] = (1, 1, 1, 1),
    drag: float = 0.0,
    torque: float = math.inf,
    hinge: Joint | None = None,
) -> RobotDescription:
    """A body with four rotors around it whose axes are its own z, in no gravity.

    Args:
        inertia: of each rotor, kg m^2.
        spins: of the four.
        drag: torque over thrust, m.
        torque: greatest of a motor, N m.
        hinge: between the body and a second one, "arm", which then carries the rotors.
    """
    carrier = "body" if hinge is None else "arm"
    links = [Link("body", Inertial(MASS, np.zeros(3), np.diag([ACROSS, ACROSS, ALONG])))]
    if hinge is not None:
        links.append(Link("arm", Inertial(0.3, np.zeros(3), 2e-3 * np.eye(3))))
    rotors = tuple(
        Rotor(
            f"rotor{index + 1}", carrier, ARM * np.array([x, y, 0.0]), np.eye(3), spin, -spin * drag,
            0.0, 40.0, LAG, FACTOR, inertia, torque,
        )
        for index, (spin, x, y) in enumerate(zip(spins, (1, 0, -1, 0), (0, 1, 0, -1), strict=True))
    )  # fmt: skip
    return RobotDescription(
        "rig", "", "body", tuple(links), () if hinge is None else (hinge,), rotors,
        () if hinge is None else ("hinge",), (), _servos(len(links) - 1), _servos(0), np.zeros(0),
        Tip("body", np.array([0.5, 0.0, 0.0]), 0.004),
        PostureFamily(np.zeros(len(links) - 1), np.zeros(len(links) - 1), 0.0, 1.0, 0.0),
        "body", "rig", Path(), gravity=0.0,
    )  # fmt: skip


def _servos(n: int) -> Servos:
    """Of hinges that nothing holds."""
    return Servos(*(value * np.ones(n) for value in (1e-9, 0.0, 1e-9, 1.0)))


@dataclass
class RotorRig:
    """A described robot in no gravity, far from any surface, whose rotors are commanded by hand.

    Attributes:
        plant: of the robot, as every flight has it.
        data: its state; it is advanced.
    """

    plant: Plant
    data: mujoco.MjData

    @classmethod
    def of(
        cls, described: RobotDescription, thrusts: float, physics_step: float = 0.001, **given: Any
    ) -> RotorRig:
        """The rig at rest, with these thrusts (N) and keys of the plant."""
        config = PlantConfig(rotors="speed", physics_step=physics_step, **given)
        plant = build_plant(Robot(described), far_away(), config, PERIOD)
        plant.model.opt.gravity[:] = 0.0
        data = mujoco.MjData(plant.model)
        data.act[: plant.robot.n_rotors] = thrusts
        return cls(plant, data)

    def fly(self, thrusts: np.ndarray, ticks: int) -> np.ndarray:
        """Command thrusts (N) for some ticks; thrusts, velocities and positions after each, (ticks, ...)."""
        plant, data = self.plant, self.data
        sizes = plant.robot.n_rotors, plant.robot.n_joints, plant.robot.n_vectoring
        command = [np.broadcast_to(thrusts, sizes[0]).astype(float), *map(np.zeros, sizes[1:])]
        rates = data.qvel[3:].copy()  # as if it had moved like this before
        after, numbers = rates.copy(), plant_numbers(plant, PERIOD)
        scales, held = rotor_scales(plant.model, sizes[0]), np.zeros(1)
        drive = BoundFunction(
            actuator_function(plant, PERIOD),
            (data.qpos, data.qvel, data.act, data.history, numbers, scales, held, rates, *command),
            (data.ctrl, data.qfrc_applied, after),
        )
        found = []
        for _ in range(ticks):
            drive.evaluate()
            rates[:] = after
            mujoco.mj_step(plant.model, data, plant.substeps)
            found.append(np.concatenate([data.act[: sizes[0]], data.qvel, data.qpos]))
        return np.array(found)


def far_away() -> Board:
    """A surface that no rig reaches."""
    return Board(position=(100.0, 0.0, 0.0))


def speeds_of(thrusts: np.ndarray) -> np.ndarray:
    """The speeds of these thrusts (N), rad/s."""
    return np.sqrt(thrusts / FACTOR)


def times_of(ticks: int) -> np.ndarray:
    """The ends of so many ticks, s."""
    return PERIOD * np.arange(1, ticks + 1)
