"""The recorded thrusts are those that act: Pinocchio's momentum of the robot changes by them."""

from __future__ import annotations

from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
import pytest

import skylimb
from skylimb.robots import load_robot

pin: Any = import_module("pinocchio")

AIR = {"plant.wall_loss": 0.16, "plant.wall_pull": 0.16, "plant.rotor_drag": 0.3}
WEAK = {
    "plant.thrust_scale": 0.9,
    "events": [
        {"kind": "rotor", "time": 0.2, "duration": 0.1, "rotor": "rotor2", "effectiveness": 0.8},
        {"kind": "rotor", "time": 0.4, "duration": 0.1, "rotor": "rotor3", "effectiveness": 0.0},
    ],
}
BEGIN, END, WINDOW = 5, 550, 20


class Balance(NamedTuple):
    """Momentum's change less all that acts but the air, and the air by its formula, N and N m, (k, 6)."""

    left: np.ndarray
    air: np.ndarray


def flown(**given: Any) -> Any:
    """The paper's hover, without a controller's saturation and with a tick a step."""
    settings = {"controller_rate": 1000.0, "sensors.rate": 200.0, "approach.standoff": 0.05, **given}
    flight = skylimb.begin("paper", controller="pid", set=settings)
    for _ in range(END + 1):
        flight.tick()
    return flight


def balance(flight: Any, air: bool) -> Balance:
    """Over windows of the flight, by the robot's URDF, its rotors' factors and the record alone."""
    d, plant = load_robot("hydrus_xi_quad").description, flight.takeoff.plant
    model = pin.buildModelFromUrdf(str(d.folder / d.sources[1].path.name), pin.JointModelFreeFlyer())
    data, dt = model.createData(), flight.takeoff.period
    frames = [model.getFrameId(rotor.link, pin.FrameType.BODY) for rotor in d.rotors]
    mass, names = pin.computeTotalMass(model), [*d.shape_joints, *d.vectoring_joints]
    qpos, thrusts = flight.signal("configuration"), flight.signal("thrusts")
    speeds, into = flight.signal("rotor_speeds"), plant.surface.R_WS[:, 0]
    at, share = into @ np.array(plant.surface.position), 0.3 * np.sqrt(mass / (4 * d.gravity))

    def placed(row: np.ndarray) -> np.ndarray:
        x = pin.neutral(model)
        x[:3], x[3:7] = row[:3], np.roll(row[3:7], -1)
        for name, angle in zip(names, row[plant.places], strict=True):
            joint = model.joints[model.getJointId(name)]
            x[joint.idx_q : joint.idx_q + joint.nq] = (
                [angle] if joint.nq == 1 else [np.cos(angle), np.sin(angle)]
            )
        return x

    x = [placed(row) for row in qpos[: END + 1]]
    momenta, acting, blown = [], [], []
    for k in range(BEGIN, END):
        v = pin.difference(model, x[k - 1], x[k]) / dt
        pin.ccrba(model, data, x[k], v)
        pin.forwardKinematics(model, data, x[k], v)
        pin.updateFramePlacements(model, data)
        momentum, wrench = data.hg.vector.copy(), np.zeros(6)
        wrench[2] = -mass * d.gravity
        gust = np.zeros(6)
        for index, (rotor, frame) in enumerate(zip(d.rotors, frames, strict=True)):
            pose = data.oMf[frame]
            axis, arm, thrust = pose.rotation[:, 2], pose.translation - data.com[0], thrusts[k, index]
            force = thrust * axis
            wrench += np.r_[force, np.cross(arm, force) + rotor.drag_torque_coefficient * force]
            momentum[3:] += rotor.spin * (rotor.inertia or 0.0) * speeds[k, index] * axis
            velocity = pin.getFrameVelocity(model, data, frame, pin.LOCAL_WORLD_ALIGNED).linear
            radius = rotor.radius or 0.0
            near = (radius / max(at - into @ pose.translation, radius)) ** 2
            push = near * thrust * 0.16 * (into - axis)
            push -= share * np.sqrt(thrust) * (velocity - axis * (axis @ velocity))
            gust += np.r_[push, np.cross(arm, push)]
        momenta.append(momentum)
        acting.append(wrench)
        blown.append(gust if air else np.zeros(6))
    starts = range(0, END - BEGIN - WINDOW, WINDOW)
    change = [(momenta[i + WINDOW] - momenta[i]) / (WINDOW * dt) for i in starts]
    mean = [[np.mean(one[i + 1 : i + WINDOW + 1], axis=0) for i in starts] for one in (acting, blown)]
    return Balance(np.array(change) - np.array(mean[0]), np.array(mean[1]))


def rms(values: np.ndarray) -> np.ndarray:
    return np.sqrt(np.mean(values**2, axis=0))


@pytest.mark.parametrize("air", [False, True])
def test_momentum_changes_by_the_recorded_thrusts(air: bool) -> None:
    found = balance(flown(**WEAK, **(AIR if air else {})), air)
    assert np.all(rms(found.air[:, :3]) > 0.05) == air
    off = rms(found.left - found.air)
    assert np.all(off[:3] < 0.05), off
    assert np.all(off[3:] < 0.02), off
