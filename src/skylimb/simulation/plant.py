"""The plant: robot, surface and contact as one compiled MuJoCo model.

The plant is built from a robot description like the controller's model, but from its own copy: `PlantConfig`
says how the real robot differs from what the controller believes.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np

from skylimb.base.rotations import quaternion_from_rotation, rot_z
from skylimb.control.missions.mission import Mission
from skylimb.control.missions.reference import Reference
from skylimb.control.posture import heading_of
from skylimb.robots.description import RobotDescription
from skylimb.robots.links import Inertial, Link
from skylimb.robots.model import Robot
from skylimb.simulation.air import AirNumbers, air_numbers
from skylimb.simulation.contact import ContactReading, pair_compliance
from skylimb.simulation.joint_stops import tune_joint_stops
from skylimb.simulation.plant_config import (
    Peg,
    PlantConfig,
    physics_steps,
    require_plant,
    thrust_scales,
    turning,
)
from skylimb.simulation.scene import scene_spec
from skylimb.simulation.servo_friction import tune_servo_friction
from skylimb.simulation.surfaces import Surface
from skylimb.simulation.tool import tune_tool

_SAG_ITERATIONS = 5
_OF_THE_DESCRIPTION = (
    "rotor_lag", "rotor_inertia", "mass_scale", "cog_offset", "servo_stiffness_scale",
)  # fmt: skip
"""Keys of the plant that change what the robot's description says."""


def plant_description(description: RobotDescription, config: PlantConfig) -> RobotDescription:
    """The description of the robot that really flies; the same object when the two do not differ."""
    if all(getattr(config, key) == getattr(PlantConfig(), key) for key in _OF_THE_DESCRIPTION):
        return description

    def scaled(link: Link) -> Link:
        inertial = link.inertial
        com = inertial.com
        if link.name == description.root:
            com = com + np.asarray(config.cog_offset) * (description.mass / inertial.mass)
        mass = inertial.mass * config.mass_scale
        return dataclasses.replace(link, inertial=Inertial(mass, com, inertial.inertia * config.mass_scale))

    lag, inertia = config.rotor_lag, config.rotor_inertia
    rotors = tuple(
        dataclasses.replace(
            rotor,
            lag=rotor.lag if lag < 0.0 else lag,
            inertia=rotor.inertia if inertia < 0.0 else inertia,
        )
        for rotor in description.rotors
    )
    servos = description.shape_servos
    servos = dataclasses.replace(servos, stiffness=servos.stiffness * config.servo_stiffness_scale)
    return dataclasses.replace(
        description, links=tuple(map(scaled, description.links)), rotors=rotors, shape_servos=servos
    )


@dataclass(frozen=True)
class Plant:
    """A compiled scene.

    Attributes:
        robot: model of the robot that really flies.
        as_described: whether that is the robot of the description, without any difference.
        surface: what it touches.
        model: MuJoCo's model, without what is only looked at.
        substeps: physics steps in a control tick.
        reading: where the contact's samples lie.
        joint_qpos: addresses of q in qpos.
        vectoring_qpos: addresses of psi in qpos.
        wall_joint: address of a moving surface's slide in qpos and qvel, or None.
        hinge: address of a valve's hinge in qpos and qvel, or None.
        foot: half the side of a foot at the tip, m, or None.
        peg: radius and length of a peg at the tip, m, or None.
        turning: whether the rotors have a speed and an inertia.
        air: what air does to the rotors besides, or None.
    """

    robot: Robot
    as_described: bool
    surface: Surface
    model: mujoco.MjModel
    substeps: int
    reading: ContactReading
    joint_qpos: tuple[int, ...]
    vectoring_qpos: tuple[int, ...]
    wall_joint: tuple[int, int] | None
    hinge: tuple[int, int] | None = None
    foot: float | None = None
    peg: Peg | None = None
    turning: bool = False
    air: AirNumbers | None = None

    @property
    def places(self) -> list[int]:
        """Where the angles of shape and vectoring joints stand in qpos."""
        return [*self.joint_qpos, *self.vectoring_qpos]

    @property
    def dofs(self) -> list[int]:
        """Where their rates stand in qvel: the free joint has a velocity less than places."""
        return [place - 1 for place in self.places]

    def compliance(self, stiffness: float) -> tuple[float, float, float]:
        """How the contact gives way with a surface of this stiffness, N/m; see `pair_compliance`.

        Raises:
            ConfigError: when the time step cannot carry it.
        """
        return pair_compliance(self.model, dataclasses.replace(self.surface.contact, stiffness=stiffness))

    @cached_property
    def scene(self) -> str:
        """The model as MJCF text, with what is only looked at, for viewer and video."""
        step = float(self.model.opt.timestep)
        spec, _ = scene_spec(self.robot.description, self.surface, step, self.substeps, self.foot, self.peg)
        spec.compile()
        return spec.to_xml()


def build_plant(robot: Robot, surface: Surface, config: PlantConfig, dt: float) -> Plant:
    """Compile the scene for control period `dt`, s.

    `robot` is the one that is described; how the real one differs is in `config`.

    Raises:
        ConfigError: when `dt` is no whole number of physics steps, or a scale does not fit the rotors.
    """
    require_plant(robot.description, surface, config, dt)
    description, substeps = robot.description, physics_steps(config, dt)
    scales = thrust_scales(description, config)
    true = plant_description(description, config)

    spec, parts = scene_spec(true, surface, config.physics_step, substeps, config.foot, config.peg)
    # What is only looked at is left out: without it a step is a tenth faster, and the same to the bit.
    spec.compiler.discardvisual = True
    model = spec.compile()
    tune_tool(model, surface.contact, foot=config.foot is not None)
    tune_servo_friction(model)
    tune_joint_stops(model, true.shape_joints, config.joint_stop_stiffness, config.joint_stop_damping)
    model.actuator_gainprm[: len(scales), 0] = scales
    turns = turning(true, config)
    if turns:
        # What reaches the engine leads the thrust, so that it ends where the rotor's speed does.
        model.actuator_ctrllimited[: len(scales)] = False

    def joint_at(name: str) -> tuple[int, int]:
        joint = model.joint(name).id
        return int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])

    flown = robot if true is description else Robot(true)
    return Plant(
        robot=flown,
        as_described=true is description,
        surface=surface,
        model=model,
        substeps=substeps,
        reading=ContactReading.of(model),
        joint_qpos=tuple(joint_at(name)[0] for name in true.shape_joints),
        vectoring_qpos=tuple(joint_at(name)[0] for name in true.vectoring_joints),
        wall_joint=joint_at(parts.joint) if parts.joint else None,
        hinge=joint_at(parts.hinge) if parts.hinge else None,
        foot=config.foot,
        peg=config.peg,
        turning=turns,
        air=air_numbers(flown, surface, config),
    )


def initial_data(plant: Plant, mission: Mission) -> mujoco.MjData:
    """Data with the robot at rest, hovering as the first row of its mission asks.

    Rotors already give hover thrust, and the joints hang as far from their set points as their servos'
    springs give under it, as after a take-off.
    """
    first, description = mission.first, plant.robot.description
    stiffness = description.servos.stiffness
    set_points = np.concatenate([first.joint_angles, first.vectoring_angles])
    data = mujoco.MjData(plant.model)
    angles = set_points
    for _ in range(_SAG_ITERATIONS):
        _place_at_hover(plant, data, first, angles)
        angles = set_points - _static_servo_torque(plant, data) / stiffness
    _place_at_hover(plant, data, first, angles)
    data.act[plant.robot.n_rotors :] = set_points
    mujoco.mj_forward(plant.model, data)
    return data


def _place_at_hover(plant: Plant, data: mujoco.MjData, first: Reference, angles: np.ndarray) -> None:
    """Put the robot at rest with these servo angles (q, then psi), under its hover thrusts there."""
    joint_angles, vectoring_angles = np.split(angles, [plant.robot.n_joints])
    state = plant.robot.at(joint_angles, vectoring_angles)
    R_WB = rot_z(heading_of(plant.robot, state.tip_heading, first)) @ state.R_root_C.T
    data.qpos[0:3] = first.position - R_WB @ state.cog_root
    data.qpos[3:7] = quaternion_from_rotation(R_WB)
    data.qpos[plant.places] = angles
    data.act[:] = np.concatenate([state.hover_thrusts, angles])


def _static_servo_torque(plant: Plant, data: mujoco.MjData) -> np.ndarray:
    """Torque that each servo (q, then psi) must give to hold this posture at rest under its rotors, N m."""
    model = plant.model
    mujoco.mj_forward(model, data)
    # Each servo is at its set point and gives nothing, so what acts on the joints is the rotors' alone. The
    # free joint has one velocity less than positions.
    return (data.qfrc_bias - data.qfrc_actuator)[plant.dofs]
