"""Drag of rotors and a wall beside them: forces against the engine's, and flights with and without them."""

from __future__ import annotations

from typing import Any

import casadi as ca
import mujoco
import numpy as np
import pytest

import skylimb
from short_flights import HOLD
from skylimb.base.errors import ConfigError
from skylimb.flight.flying import fly, fly_here
from skylimb.flight.takeoff import Takeoff, take_off
from skylimb.simulation.air import AirNumbers, air_forces
from skylimb.simulation.plant import Plant

AIR = {"plant.rotor_drag": 0.54, "plant.wall_loss": 0.16, "plant.wall_pull": 0.16}
ROBOTS = ("paper", "board_dragon", "board_hydrus_xi_hex")


def taken_off(name: str, **given: Any) -> Takeoff:
    (takeoff,) = take_off(name, ("pid",), set=given)
    return takeoff


def drawn(plant: Plant, rng: np.random.Generator) -> mujoco.MjData:
    """A random state somewhere before the wall."""
    data = mujoco.MjData(plant.model)
    data.qpos[:3], quaternion = rng.uniform(-0.5, 0.5, 3), rng.normal(size=4)
    data.qpos[3:7] = quaternion / np.linalg.norm(quaternion)
    data.qpos[plant.places] = rng.uniform(-1.2, 1.2, len(plant.places))
    data.qvel[[*range(6), *plant.dofs]] = rng.normal(size=6 + len(plant.places))
    data.act[: plant.robot.n_rotors] = rng.uniform(2.0, 25.0, plant.robot.n_rotors)
    mujoco.mj_forward(plant.model, data)
    return data


def forces_of(plant: Plant, numbers: AirNumbers, data: mujoco.MjData) -> np.ndarray:
    n = plant.robot.n_rotors
    root = np.concatenate([data.qpos[:7], data.qvel[:6]])
    joints = ca.DM(data.qpos[plant.places]), ca.DM(data.qvel[plant.dofs])
    return np.array(
        ca.evalf(air_forces(plant.robot, numbers, ca.DM(data.act[:n]), ca.DM(root), *joints))
    ).ravel()


@pytest.mark.parametrize("name", ROBOTS)
def test_forces_are_those_that_the_engine_makes_of_them_at_each_hub(name: str) -> None:
    plant, rng = taken_off(name, **AIR).plant, np.random.default_rng(5)
    numbers, model, robot = plant.air, plant.model, plant.robot
    assert numbers is not None
    share = 0.54 * np.sqrt(robot.mass / (robot.n_rotors * robot.description.gravity))
    for _ in range(20):
        data, wanted = drawn(plant, rng), np.zeros(model.nv)
        for index, rotor in enumerate(robot.description.rotors):
            site, velocity = data.site(f"thrust_{rotor.name}"), np.zeros(6)
            mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_SITE, site.id, velocity, 0)
            axis, thrust, hub = site.xmat.reshape(3, 3)[:, 2], data.act[index], site.xpos
            away = max(
                plant.surface.R_WS[:, 0] @ (np.array(plant.surface.position) - hub), rotor.radius or 0.0
            )
            near = ((rotor.radius or 0.0) / away) ** 2
            force = near * thrust * 0.16 * (plant.surface.R_WS[:, 0] - axis)
            force -= share * np.sqrt(thrust) * (np.eye(3) - np.outer(axis, axis)) @ velocity[3:]
            body = int(model.site_bodyid[site.id])
            mujoco.mj_applyFT(model, data, force, np.zeros(3), hub, body, wanted)
        found = forces_of(plant, numbers, data)
        np.testing.assert_allclose(found, wanted[[*range(6), *plant.dofs]], atol=1e-11)


def test_drag_only_ever_takes_power() -> None:
    plant, rng = taken_off("paper", **{"plant.rotor_drag": 0.54}).plant, np.random.default_rng(6)
    assert plant.air is not None
    for _ in range(50):
        data = drawn(plant, rng)
        assert forces_of(plant, plant.air, data) @ data.qvel[[*range(6), *plant.dofs]] < 0.0


def test_a_hovering_robot_is_held_back_by_mass_times_speed() -> None:
    """As it was measured on quadrotors: upright rotors, so the one of all robots without vectoring angles."""
    plant = taken_off("board_hydrus_quad", **{"plant.rotor_drag": 0.5}).plant
    assert plant.air is not None
    data = taken_off("board_hydrus_quad").data()
    data.qvel[:3] = [0.0, 0.3, 0.0]
    found = forces_of(plant, plant.air, data)[:3]
    np.testing.assert_allclose(
        found, [0.0, -0.5 * plant.robot.mass * 0.3, 0.0], atol=0.02 * plant.robot.mass * 0.3
    )


def test_nothing_of_it_is_in_a_tick_unless_it_is_asked_for() -> None:
    still, again, air, more = (
        taken_off("paper", **HOLD, **given)
        for given in ({}, {"plant.rotor_drag": 0.0}, AIR, {**AIR, "plant.rotor_drag": 0.2})
    )
    assert still.plant.air is None
    assert again.tick.function is still.tick.function
    assert air.tick.function is not still.tick.function
    assert more.tick.function is air.tick.function
    assert np.any(more.tick.rotors != air.tick.rotors)


@pytest.mark.parametrize("rotors", ["speed", "thrust"])
def test_all_drivers_fly_in_the_same_air(rotors: str) -> None:
    (takeoff,) = take_off("paper", ("hybrid",), set={**HOLD, **AIR, "plant.rotors": rotors, "stop_at": 2.2})
    plain = take_off("paper", ("hybrid",), set={**HOLD, "plant.rotors": rotors, "stop_at": 2.2})[0]
    compiled, fastest, without = fly_here(takeoff), fly(takeoff), fly_here(plain)
    np.testing.assert_array_equal(fastest.signals[: fastest.ticks], compiled.signals[: compiled.ticks])
    assert np.abs(compiled.signal("configuration") - without.signal("configuration")).max() > 1e-5


def test_a_plant_of_ones_own_is_driven_by_it_too() -> None:
    """What the air does reaches any simulator as pushes do."""

    class Watched:
        def __init__(self) -> None:
            self.forces: list[np.ndarray] = []

        def start(self, beginning: Any) -> Any:
            self.truth = beginning.truth
            return self.truth

        def step(self, drive: Any) -> Any:
            self.forces.append(drive.force)
            return self.truth

    seen = []
    for given in ({}, {"plant.wall_pull": 0.16}):
        own = Watched()
        skylimb.begin("paper", controller="pid", set={**HOLD, **given}, plant=own).tick()
        seen.append(own.forces[-1])
    assert not seen[0].any()
    assert seen[1][0] > 0.05


@pytest.mark.parametrize(
    ("name", "given", "message"),
    [
        ("paper", {"plant.rotor_drag": -0.1}, "plant.rotor_drag = -0.1 1/s is outside of 0 .. 5"),
        ("paper", {"plant.wall_pull": 0.7}, "plant.wall_pull = 0.7 is outside of -0.5 .. 0.5"),
        (
            "paper",
            {"plant.wall_loss": 0.1, "surface.sway_amplitude": 0.01},
            "plant.wall_loss needs a surface that stands still; 'board' moves",
        ),
        (
            "paper",
            {"plant.wall_pull": 0.1, "events": [{"kind": "surface", "time": 5.0, "present": False}]},
            "surface at 5 s: surface away; but a surface that rotors feel",
        ),
    ],
)
def test_nonsense_is_refused_by_name(name: str, given: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        skylimb.run(name, "hybrid", set=given)
