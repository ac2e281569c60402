"""A user's plant in the engine's place: the one call that advances the physics.

It finds controls and forces in the engine's memory, as `mujoco.mj_step` does, and leaves positions,
velocities and the contact's samples there. So every driver, hook, fault and record is the same for each.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np

from skylimb.base.errors import UserCodeError, unknown_name
from skylimb.base.user_code import UserCode
from skylimb.simulation.contact import effective_mass
from skylimb.simulation.plant import Plant
from skylimb.simulation.plant_tick import rotor_scales
from skylimb.simulation.servo_friction import servo_brakes
from skylimb.simulation.spring_contact import SpringContact
from skylimb.simulation.user_plant import Beginning, Drive, UserPlant, plant_name

AS_ASKED = 1e-3
"""By how much a plant may begin elsewhere than it is asked to, m, rad and their rates."""

_CONTACT = ("contact_force", "contact_point")


class PlantSteps:
    """Advances a user's plant, which it puts at its beginning.

    Args:
        plant: the flight's own, as it is described to the engine.
        data: its state at the beginning.
        own: the user's plant.

    Raises:
        UserCodeError: when it fails, begins elsewhere, or says what cannot be the truth.
    """

    def __init__(self, plant: Plant, data: mujoco.MjData, own: UserPlant) -> None:
        self._own, self._reading, self._what = own, plant.reading, f"plant '{plant_name(own)}'"
        robot, n, step = plant.robot.description, plant.robot.n_rotors, float(plant.model.opt.timestep)
        places, rates = plant.places, plant.dofs
        shape = slice(plant.robot.n_joints)
        vectoring = slice(plant.robot.n_joints, None)
        self._rotors, self._servos, self._rates = slice(n), slice(n, n + len(places)), rates
        # Where in the engine's memory each name stands.
        self._memory = {
            "root_position": (data.qpos, [0, 1, 2]),
            "root_quaternion": (data.qpos, [3, 4, 5, 6]),
            "root_velocity": (data.qvel, [0, 1, 2]),
            "root_angular_velocity": (data.qvel, [3, 4, 5]),
            "joint_angles": (data.qpos, places[shape]),
            "joint_rates": (data.qvel, rates[shape]),
            "vectoring_angles": (data.qpos, places[vectoring]),
            "vectoring_rates": (data.qvel, rates[vectoring]),
        }
        dry = {joint.name: joint.friction for joint in robot.joints}
        self._friction = np.array([dry[name] for name in robot.moving_joints])
        brakes = servo_brakes(plant.model)
        self._brake = np.array([brakes.get(rate, 0.0) for rate in rates])
        asked = {name: memory[at] for name, (memory, at) in self._memory.items()}
        touch = SpringContact(plant.surface, robot.tip.radius, effective_mass(plant.model), step)
        thrusts = rotor_scales(plant.model, n) * data.act[:n]
        beginning = Beginning(robot, plant.surface, step, asked, thrusts, touch, plant.scene)
        with UserCode(self._what, own.start):
            said = own.start(beginning)
        truth = self._checked(said, 0.0)
        for name, value in asked.items():
            off = float(np.abs(truth[name] - value).max(initial=0.0))
            if off > AS_ASKED:
                raise UserCodeError(
                    f"{self._what} begins elsewhere than it is asked to: {name} is {off:.3g} off"
                )

    def __call__(self, model: mujoco.MjModel, data: mujoco.MjData, steps: int) -> None:
        """Advance by a number of steps."""
        h, servos, reading = float(model.opt.timestep), self._servos, self._reading
        for sample in range(steps):
            drive = Drive(
                thrusts=model.actuator_gainprm[self._rotors, 0] * data.act[self._rotors],
                set_points=data.act[servos].copy(),
                stiffness=model.actuator_gainprm[servos, 0].copy(),
                damping=-model.actuator_biasprm[servos, 2],
                torque_limits=model.actuator_forcerange[servos, 1].copy(),
                friction=self._friction,
                brake=self._brake,
                force=data.qfrc_applied[0:3].copy(),
                torque=data.qfrc_applied[3:6].copy(),
                joint_torques=data.qfrc_applied[self._rates],
            )
            with UserCode(self._what, self._own.step):
                said = self._own.step(drive)
            truth = self._checked(said, data.time + h)
            self._advance_actuators(model, data, h)
            data.time += h
            for name, (memory, at) in self._memory.items():
                memory[at] = truth[name]
            force, point = (truth.get(name, np.zeros(3)) for name in _CONTACT)
            data.history[reading.found[sample]] = force.any()
            data.history[reading.force[sample]] = force
            data.history[reading.position[sample]] = point

    def _advance_actuators(self, model: mujoco.MjModel, data: mujoco.MjData, h: float) -> None:
        """Rotors as exact first-order filters, set points at their rates: as the engine does."""
        low, high = model.actuator_ctrlrange.T
        controls = np.where(model.actuator_ctrllimited, np.clip(data.ctrl, low, high), data.ctrl)
        rotors, servos = self._rotors, self._servos
        lags = np.maximum(model.actuator_dynprm[rotors, 0], mujoco.mjMINVAL)
        data.act[rotors] += (controls[rotors] - data.act[rotors]) * -np.expm1(-h / lags)
        data.act[servos] += h * controls[servos]

    def _checked(self, said: Any, time: float) -> dict[str, np.ndarray]:
        """The truth as arrays of the right sizes, all finite, the quaternion a unit one of one sign."""
        where = f"{self._what} at t = {time:.4g} s"
        if not isinstance(said, Mapping):
            raise UserCodeError(f"{where} gives {type(said).__name__}, no dict with the truth by name")
        sizes = {name: len(at) for name, (_, at) in self._memory.items()}
        if any(name in said for name in _CONTACT):
            sizes |= dict.fromkeys(_CONTACT, 3)
        for name in said:
            if name not in sizes:
                raise UserCodeError(str(unknown_name(f"truth of {where}", str(name), [*sizes, *_CONTACT])))
        truth = {}
        for name, size in sizes.items():
            if name not in said:
                raise UserCodeError(f"{where} gives no '{name}'")
            with UserCode(f"{where}: {name}"):
                given = np.asarray(said[name])
                value = np.array(np.real(given), dtype=float)
            if np.iscomplexobj(given):
                raise UserCodeError(f"{where} gives {name} = {said[name]}, which is complex")
            if value.shape != (size,):
                raise UserCodeError(f"{where} gives {name} the shape {value.shape}; it has ({size},)")
            if not np.isfinite(value).all():
                raise UserCodeError(f"{where} gives {name} = {value}, which is not finite")
            truth[name] = value
        length = float(np.linalg.norm(truth["root_quaternion"]))
        if abs(length - 1.0) > AS_ASKED:
            raise UserCodeError(f"{where} gives root_quaternion the length {length:.4g}; it is 1")
        # Of an attitude's two quaternions the one near the last: sensors interpolate in time.
        memory, at = self._memory["root_quaternion"]
        truth["root_quaternion"] /= np.copysign(length, truth["root_quaternion"] @ memory[at])
        return truth
