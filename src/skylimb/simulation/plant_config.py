"""How the real robot differs from its description, and which plants there can be; said without an engine."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np

from skylimb.base.errors import ConfigError
from skylimb.base.keys import Key, configuration
from skylimb.robots.description import RobotDescription, Rotor
from skylimb.simulation.surfaces import Surface

Peg = tuple[float, float]
"""Radius and length, m."""


@configuration
class PlantConfig:
    """How the physics is stepped, and how the real robot differs from its description."""

    physics_step: Annotated[
        float,
        Key("s", "time step of the physics; a control period is a whole number of them", low=1e-5, high=0.01),
    ] = 0.001
    thrust_scale: Annotated[float, Key("", "true over commanded thrust, all rotors", low=0.5, high=1.5)] = 1.0
    rotor_scale: Annotated[
        tuple[float, ...], Key("", "the same for each rotor on its own; empty for ones", low=0.0, high=1.5)
    ] = ()
    rotor_lag: Annotated[
        float,
        Key("s", "time constant of the thrust; -1 keeps the description's", low=-1.0, high=1.0),
    ] = -1.0
    rotors: Annotated[
        Literal["described", "speed", "thrust"],
        Key(
            "",
            "'speed': their speed lags, within the motor's torque, and turns the robot; 'thrust': the "
            "paper's, whose thrust lags and which have no inertia; 'described': 'speed' where the robot's "
            "file says what it takes",
        ),
    ] = "described"
    rotor_inertia: Annotated[
        float,
        Key("kg m^2", "of each rotor; -1 keeps the description's", low=-1.0, high=0.1),
    ] = -1.0
    rotor_drag: Annotated[
        float,
        Key(
            "1/s",
            "drag of the rotors and flapping of their blades: in hover over the robot's mass and speed; 0.2 "
            "to 0.54 on quadrotors",
            low=0.0,
            high=5.0,
        ),
    ] = 0.0
    wall_loss: Annotated[
        float,
        Key(
            "",
            "share of its thrust that a rotor loses beside the surface's plane, its disc's radius away; "
            "falls with the distance squared; below 0 it gains",
            low=-0.5,
            high=0.5,
        ),
    ] = 0.0
    wall_pull: Annotated[
        float,
        Key("", "share of its thrust by which that plane draws it there, likewise", low=-0.5, high=0.5),
    ] = 0.0
    joint_stop_stiffness: Annotated[
        float | None,
        Key(
            "N m/rad",
            "of the joints' stops; none for the engine's own soft ones",
            above=0.0,
            high=1e6,
        ),
    ] = None
    joint_stop_damping: Annotated[float, Key("N m s/rad", "of these stops", low=0.0, high=1e4)] = 1.0
    mass_scale: Annotated[
        float, Key("", "true over described mass and inertia, all links", low=0.5, high=2.0)
    ] = 1.0
    cog_offset: Annotated[
        tuple[float, float, float],
        Key("m", "true less described centre of gravity, root link's axes", low=-0.2, high=0.2),
    ] = (0.0, 0.0, 0.0)
    foot: Annotated[
        float | None,
        Key("m", "half the side of a square foot at the tip; none for the tip's ball alone", 0.005, 0.5),
    ] = None
    peg: Annotated[
        tuple[float, float] | None,
        Key(
            "m",
            "radius and length of a peg at the tip, for a hole; none for the tip's ball alone",
            0.001,
            1.0,
        ),
    ] = None
    servo_stiffness_scale: Annotated[
        float, Key("", "true over described stiffness of the shape servos", low=1e-3, high=100.0)
    ] = 1.0


def physics_steps(config: PlantConfig, dt: float) -> int:
    """Steps of the physics in a control period of `dt` s.

    Raises:
        ConfigError: when that is no whole number.
    """
    steps = round(dt / config.physics_step)
    if steps < 1 or abs(steps * config.physics_step - dt) > 1e-9:
        raise ConfigError(
            f"controller_rate = {1.0 / dt:g} Hz has a period of {dt:g} s, which is no whole number of "
            f"plant.physics_step = {config.physics_step:g} s"
        )
    return steps


def thrust_scales(description: RobotDescription, config: PlantConfig) -> np.ndarray:
    """True over commanded thrust of every rotor, (n,).

    Raises:
        ConfigError: when a scale does not fit the rotors.
    """
    scales = np.ones(len(description.rotors)) * config.thrust_scale
    if not config.rotor_scale:
        return scales
    if len(config.rotor_scale) != len(scales):
        raise ConfigError(
            f"plant.rotor_scale has {len(config.rotor_scale)} entries; {description.name} has "
            f"{len(scales)} rotors"
        )
    return scales * np.asarray(config.rotor_scale)


def require_plant(description: RobotDescription, surface: Surface, config: PlantConfig, dt: float) -> None:
    """Raise a `ConfigError` unless robot, surface and plant go together, at a control period of `dt` s."""
    physics_steps(config, dt)
    thrust_scales(description, config)
    require_rotors(description, config)
    require_air(description, surface, config)
    if config.foot is not None:
        require_plain(surface)
    require_hole(surface, config.peg)


def turning(description: RobotDescription, config: PlantConfig) -> bool:
    """Whether the rotors have a speed and an inertia."""
    if config.rotors != "described":
        return config.rotors == "speed"
    return not any(_unsaid(rotor, config) for rotor in description.rotors)


def _unsaid(rotor: Rotor, config: PlantConfig) -> list[str]:
    """Keys without which a rotor has no speed."""
    needed = {"thrust_factor": rotor.thrust_factor}
    if config.rotor_inertia < 0.0:
        needed["inertia"] = rotor.inertia
    return [key for key, value in needed.items() if value is None]


def require_rotors(description: RobotDescription, config: PlantConfig) -> None:
    """Raise a `ConfigError` where rotors are to have a speed, and the robot's file says too little of it.

    A lag or an inertia below 0 is refused, too; only -1 stands for what that file says.
    """
    for key in ("rotor_lag", "rotor_inertia"):
        value = getattr(config, key)
        if -1.0 < value < 0.0:
            raise ConfigError(f"plant.{key} = {value:g} is below 0; -1 keeps what the robot's file says")
    if not turning(description, config):
        if config.rotor_inertia > 0.0:
            raise ConfigError(
                f"plant.rotor_inertia = {config.rotor_inertia:g} kg m^2 has no effect on rotors without a "
                "speed: it needs plant.rotors = 'speed'"
            )
        return
    for rotor in description.rotors:
        lacking = _unsaid(rotor, config)
        if lacking:
            raise ConfigError(
                f"plant.rotors = 'speed' needs rotors.{lacking[0]}, which {rotor.name} of robot "
                f"{description.name} does not say; add it to its flight TOML, or fly with "
                "plant.rotors = 'thrust'"
            )


def require_air(description: RobotDescription, surface: Surface, config: PlantConfig) -> None:
    """Raise a `ConfigError` where rotors feel a wall that is no still plane, or have no radius."""
    key = next((key for key in ("wall_loss", "wall_pull") if getattr(config, key)), "")
    if not key:
        return
    if surface.moves or surface.turns:
        how = "moves" if surface.moves else "turns"
        raise ConfigError(f"plant.{key} needs a surface that stands still; '{surface.kind}' {how}")
    for rotor in description.rotors:
        if rotor.radius is None:
            raise ConfigError(
                f"plant.{key} needs rotors.radius, which {rotor.name} of robot {description.name} "
                "does not say"
            )


def require_plain(surface: Surface) -> None:
    """Raise a `ConfigError` for a surface whose friction or compliance the loop writes for one ball alone."""
    reasons = (
        (surface.moves, "moves"),
        (surface.turns, "turns"),
        (surface.many, "has walls"),
        (surface.friction_varies, "has a friction that varies"),
    )
    why = next((word for holds, word in reasons if holds), "")
    if why:
        raise ConfigError(
            f"plant.foot needs a surface that stands still and has one friction; '{surface.kind}' {why}"
        )


def require_hole(surface: Surface, peg: Peg | None) -> None:
    """Raise a `ConfigError` unless a peg and a hole come together, and the peg fits."""
    if peg is None:
        if surface.many:
            raise ConfigError(f"a surface of kind '{surface.kind}' needs a peg: plant.peg = [radius, length]")
        return
    if not surface.many:
        raise ConfigError(f"plant.peg needs a surface of kind 'hole'; this one is '{surface.kind}'")
    radius, length = peg
    if radius >= surface.tightest_hollow:
        raise ConfigError(
            f"plant.peg = {list(peg)}: a radius of {radius:g} m does not fit into a hole of "
            f"{surface.tightest_hollow:g} m, surface.radius"
        )
    if length <= 2.0 * radius:
        raise ConfigError(f"plant.peg = {list(peg)}: a peg is longer than it is wide")
