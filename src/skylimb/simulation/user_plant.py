"""A simulator of a user's own in the engine's place: it is driven by forces and says the truth by name.

The lag of the robot's rotors, the speed of its servos, sensors with noise and delay, pushes, faults, record
and scores stay what they are (`plant_steps`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

from skylimb.base.errors import ConfigError
from skylimb.base.keys.key import shown
from skylimb.robots.description import RobotDescription
from skylimb.simulation.plant import Plant
from skylimb.simulation.spring_contact import SpringContact
from skylimb.simulation.surfaces import Surface


class Drive(NamedTuple):
    """What drives the robot over one step of the physics; all of it is held over the step.

    Servos and torques are those of the shape joints, then of the vectoring joints, (m,).

    Attributes:
        thrusts: that the rotors really give, N, (n,), along z of each rotor's frame; its drag torque about
            that axis is `drag_torque_coefficient` times as much.
        set_points: of the servos, rad.
        stiffness: of the servos, N m/rad.
        damping: of the servos, N m s/rad.
        torque_limits: of the servos, N m.
        friction: dry friction of the joints, N m.
        brake: of the damper that holds a joint that sticks in its dry friction, N m s/rad.
        force: besides (pushes, the air), on the root link at its origin, W, N, (3,).
        torque: besides (these, the rotors' angular momentum), on the root link in its own axes, N m, (3,).
        joint_torques: the same on the joints, N m.
    """

    thrusts: np.ndarray
    set_points: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    torque_limits: np.ndarray
    friction: np.ndarray
    brake: np.ndarray
    force: np.ndarray
    torque: np.ndarray
    joint_torques: np.ndarray

    def servo_torques(self, angles: np.ndarray, rates: np.ndarray) -> np.ndarray:
        """What servos and dry friction give at these joint angles, rad, and rates, rad/s, (m,) N m."""
        wanted = self.stiffness * (self.set_points - angles) - self.damping * rates
        friction = np.clip(self.brake * rates, -self.friction, self.friction)
        return np.clip(wanted, -self.torque_limits, self.torque_limits) - friction


@dataclass(frozen=True)
class Beginning:
    """Where a flight begins, and what is flown.

    Attributes:
        robot: that really flies, with all that its files say and how the experiment's plant differs.
        surface: what it touches; `surface.motion` says where one that moves is at a time.
        step: of the physics, s.
        truth: at rest in hover, by the names that `step` of a plant gives.
        thrusts: that the rotors give already, N.
        touch: what the surface does to a tip, for a plant whose own contact is not wanted.
        scene: robot and surface as MJCF text.
    """

    robot: RobotDescription
    surface: Surface
    step: float
    truth: Mapping[str, np.ndarray]
    thrusts: np.ndarray
    touch: SpringContact
    scene: str


class UserPlant(Protocol):
    """Any simulator: it begins where it is asked to, and is then stepped."""

    def start(self, beginning: Beginning) -> Mapping[str, Any]:
        """Put the robot at its beginning, at rest; the truth there, by name."""
        ...

    def step(self, drive: Drive) -> Mapping[str, Any]:
        """Advance by one step of the physics.

        Returns:
            The truth at its end. Of the root link: `root_position` of its origin and `root_velocity` in W,
            `root_quaternion` with w first, `root_angular_velocity` in its own axes. `joint_angles`,
            `joint_rates`, `vectoring_angles`, `vectoring_rates`. Where there is touch, also `contact_force`
            on the robot, its mean over the step, and `contact_point`, both in W.
        """
        ...


def require_own(plant: Plant, own: UserPlant) -> None:
    """Raise a `ConfigError` for what is no plant, or is asked for more than such a plant gets."""
    missing = [name for name in ("start", "step") if not callable(getattr(own, name, None))]
    if missing or isinstance(own, type):
        what = f"has no {' and no '.join(missing)}" if missing else "is a class, not one of its objects"
        raise ConfigError(f"plant = {shown(own)} {what}; a plant has start(beginning) and step(drive)")
    asked = (
        (plant.foot is not None, "plant.foot"),
        (plant.peg is not None, "plant.peg"),
        (plant.surface.turns, f"surface.kind = '{plant.surface.kind}', of which a part turns"),
    )
    for holds, what in asked:
        if holds:
            raise ConfigError(f"plant '{plant_name(own)}' touches with the tip's ball alone: not with {what}")


def plant_name(own: UserPlant) -> str:
    """What a user's plant is called: its `name`, else its class's."""
    return str(getattr(own, "name", type(own).__name__))
