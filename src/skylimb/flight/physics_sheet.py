"""The physics of an experiment in SI: masses, dampings, lags and stops that act, and what is not modelled.

An experiment's keys say what was asked for; what acts follows from them, the robot and the engine. Here it is
computed from the model that flies, so that another engine, or a bench, can be set up alike.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import mujoco
import numpy as np

from skylimb.flight.takeoff import Takeoff
from skylimb.robots.description import AIR_DENSITY, RobotDescription
from skylimb.robots.model import Robot
from skylimb.robots.reaction import reaction_zeros, slowest_unstable_zero
from skylimb.simulation.contact import effective_mass
from skylimb.simulation.contact_keys import PAIR_NAME
from skylimb.simulation.imu import ImuConfig
from skylimb.simulation.plant_config import PlantConfig
from skylimb.simulation.robot_bodies import TIP_SITE

_FRONT = 0.5
"""Drag coefficient times frontal area that no robot that ships exceeds, m^2."""
ROTOR_DRAG = 0.54
"""Drag of the rotors over mass and speed, 1/s: the largest that was identified on a racing quadrotor
(Faessler, Franchi and Scaramuzza 2018, 0.54 and 0.39 1/s); blade flapping is in it."""
WALL_SHARE = 0.16
"""Share of its thrust that a rotor beside a wall may lose, its disc's own radius away. Measured is 7 % at 1.5
radii from two walls, near the ground, and less beside one wall ("Thrust variations in small rotors due to
corner and vertex effects", Aeronautical Journal 2025); the rest is the square of the distance."""
_DRAG_MOVES = "which moves the paper's flights by 33 mm and 0.26 N at most (rms)"
_WALL_MOVES = "which move the paper's flights by 120 mm and 1 N at most (rms)"
"""Of 20 draws with each of the paper's controllers (benchmarks/air.py)."""


class Line(NamedTuple):
    """A line of the sheet.

    Attributes:
        group: what it belongs to.
        what: the quantity.
        value: with its unit.
        note: how it comes about; may be empty.
    """

    group: str
    what: str
    value: str
    note: str = ""


def physics_sheet(takeoff: Takeoff) -> list[Line]:
    """The physics of a flight before its first tick.

    Args:
        takeoff: of any experiment with a controller, whose vectoring angles it begins with.
    """
    return [*_contact(takeoff), *_lags(takeoff), *_rotors(takeoff), *_stops(takeoff), *_missing(takeoff)]


def tip_mass(takeoff: Takeoff, held: bool) -> float:
    """Mass that a push on the tip along the surface's normal meets at the start, kg.

    Args:
        takeoff: of the flight.
        held: whether the joints are held, as by very stiff servos; else they are free.
    """
    model, data = takeoff.plant.model, takeoff.data()
    jacobian, M = np.zeros((3, model.nv)), np.zeros((model.nv, model.nv))
    mujoco.mj_jacSite(model, data, jacobian, None, model.site(TIP_SITE).id)
    mujoco.mj_fullM(model, data, M)
    moving = [*range(6)] if held else [*range(6), *takeoff.plant.dofs]
    along = takeoff.experiment.surface.R_WS[:, 0] @ jacobian[:, moving]
    return float(1.0 / (along @ np.linalg.solve(M[np.ix_(moving, moving)], along)))


def _contact(takeoff: Takeoff) -> list[Line]:
    if not takeoff.experiment.approach.contact:
        return []
    contact, model = takeoff.experiment.surface.contact, takeoff.plant.model
    free, held = tip_mass(takeoff, False), tip_mass(takeoff, True)
    average = effective_mass(model, PAIR_NAME)
    damping = contact.normal_damping(average)
    k = contact.stiffness

    def ratio(mass: float) -> str:
        return f"{damping / (2.0 * math.sqrt(k * mass)):.3g}"

    group = "contact"
    return [
        Line(group, "mass at the tip along the normal, joints free", f"{free:.3g} kg", "at the start"),
        Line(group, "the same, joints held", f"{held:.3g} kg", "at the start"),
        Line(group, "mass that sets the damping", f"{average:.4g} kg", "the engine's mean over directions"),
        Line(group, "stiffness", f"{k:g} N/m", "of the tip against the surface, normal"),
        Line(group, "damping that acts", f"{damping:.4g} N s/m", "normal"),
        Line(
            group,
            "damping ratio that acts",
            f"{ratio(free)} free, {ratio(held)} held",
            f"with damping_ratio = {contact.damping_ratio:g} of the mass that sets it"
            if contact.damping is None
            else "from surface.damping",
        ),
        Line(group, "friction", f"{contact.friction:g}", "Coulomb's; it may vary from place to place"),
        Line(
            group,
            "friction turns into the slip at",
            f"{contact.friction_rate:g} 1/s",
            "a force across the slip decays at this rate",
        ),
        Line(group, "physics step", f"{1e3 * float(model.opt.timestep):g} ms", "implicitfast, elliptic cone"),
    ]


def _imu(group: str, config: ImuConfig, description: RobotDescription) -> Line:
    where = f"on link {description.imu.link}"
    if description.imu_mount is None:
        where += ", at its origin: assumed, the robot's file has no [imu]"
    return Line(
        group, "age of what the IMU says", f"{1e3 * config.latency:g} ms" if config.on else "none", where
    )


def _lags(takeoff: Takeoff) -> list[Line]:
    experiment, d = takeoff.experiment, takeoff.plant.robot.description
    sensors, group = experiment.sensors, "lags"
    frames = "a frame at every tick" if sensors.rate == 0.0 else f"a frame every {1e3 / sensors.rate:.3g} ms"
    lines = [
        Line(group, "control period", f"{1e3 * takeoff.period:g} ms", "commands are held over it"),
        Line(group, "age of a frame when it comes", f"{1e3 * sensors.latency:g} ms", frames),
        _imu(group, sensors.imu, d),
        Line(
            group,
            "rotors",
            ", ".join(sorted({f"{1e3 * rotor.lag:g} ms" for rotor in d.rotors})),
            "first order in the thrust" if not takeoff.plant.turning else "first order in the speed",
        ),
    ]
    for title, joints, servos in (
        ("shape servos", d.shape_joints, d.shape_servos),
        ("vectoring servos", d.vectoring_joints, d.vectoring_servos),
    ):
        if joints:
            stiffness, damping, torque, speed = map(_range, vars(servos).values())
            note = f"at most {torque} N m; the set point moves at {speed} rad/s"
            lines.append(Line(group, title, f"{stiffness} N m/rad, {damping} N m s/rad", note))
    return lines


def _range(values: np.ndarray) -> str:
    """One number where all are the same, else the least and the most."""
    return " .. ".join(f"{value:g}" for value in sorted({values.min(), values.max()}))


def _rotors(takeoff: Takeoff) -> list[Line]:
    group, plant = "rotors", takeoff.plant
    if not plant.turning:
        return [Line(group, "inertia", "none", "plant.rotors and the robot's file can give them one")]
    rotors, first = plant.robot.description.rotors, takeoff.mission.first
    zeros = reaction_zeros(plant.robot, first.joint_angles, first.vectoring_angles)
    zero = slowest_unstable_zero(zeros)
    return [
        Line(group, "inertia", _each(f"{rotor.inertia:g} kg m^2" for rotor in rotors), "about the axis"),
        Line(group, "thrust over squared speed", _each(f"{rotor.thrust_factor:g} N s^2" for rotor in rotors)),
        Line(group, "motor torque at most", _each(f"{rotor.torque_max:g} N m" for rotor in rotors)),
        Line(
            group,
            "zero of lift and torque",
            "none in the right half plane" if math.isinf(zero) else f"+{zero:.3g} rad/s",
            "by the reaction to the rotors' change of speed",
        ),
    ]


def _each(values: Iterable[str]) -> str:
    """Values of the rotors, each once."""
    return ", ".join(dict.fromkeys(values))


def _stops(takeoff: Takeoff) -> list[Line]:
    config, robot = takeoff.experiment.plant, takeoff.plant.robot
    lower, upper = robot.joint_limits()
    how = "the engine's own soft stop"
    if config.joint_stop_stiffness is not None:
        how = f"{config.joint_stop_stiffness:g} N m/rad, {config.joint_stop_damping:g} N m s/rad"
    return [
        Line("stops", name, f"{low:.4g} .. {high:.4g} rad", how)
        for name, low, high in zip(robot.description.shape_joints, lower, upper, strict=True)
        if math.isfinite(low)
    ]


def _missing(takeoff: Takeoff) -> list[Line]:
    """What air does where it is asked for, and what is not modelled, each with a bound on its force."""
    robot = takeoff.plant.robot
    # Not of the reference velocity: an experiment may send positions alone.
    steps = np.linalg.norm(np.diff(takeoff.mission.reference.position, axis=0), axis=1)
    speed = float(steps.max(initial=0.0)) / takeoff.period
    air = 0.5 * AIR_DENSITY * _FRONT * speed**2
    at = f"at the mission's greatest speed, {speed:.2g} m/s"
    lines = [
        Line("not modelled", "air drag of the body", f"at most {air:.2g} N", at),
        *_rotors_air(takeoff.experiment.plant, robot, speed),
        Line("not modelled", "play and bending of joints and links", "no bound", "no file says it"),
    ]
    return sorted(lines, key=lambda line: line.group)  # what is there comes first


def _rotors_air(config: PlantConfig, robot: Robot, speed: float) -> list[Line]:
    """Drag of the rotors and a wall beside them: what acts, or else what they would do."""
    drag, wall = "drag of the rotors, blade flapping", "inflow beside a wall"
    share = WALL_SHARE * robot.weight / robot.n_rotors
    lines = [
        Line(
            "not modelled",
            drag,
            f"at most {ROTOR_DRAG * robot.mass * speed:.2g} N",
            f"at the mission's greatest speed, {speed:.2g} m/s; plant.rotor_drag adds it, {_DRAG_MOVES}",
        ),
        Line(
            "not modelled",
            wall,
            f"at most {share:.2g} N a rotor, along its axis and toward the wall",
            "where its disc is as near as its own radius; plant.wall_loss and wall_pull add it, "
            + _WALL_MOVES,
        ),
    ]
    if config.rotor_drag:
        lines[0] = Line("air", drag, f"{config.rotor_drag:g} 1/s", "over mass and speed in hover")
    if config.wall_loss or config.wall_pull:
        lines[1] = Line(
            "air",
            wall,
            f"{config.wall_loss:g} of its thrust lost, {config.wall_pull:g} toward the wall",
            "a disc's radius away; by the square of the distance",
        )
    return lines
