"""A foot of five balls: in the model, refused where it cannot be, and flat on a plane in flight."""

from typing import Any

import mujoco
import numpy as np
import pytest

import skylimb
from skylimb.base.errors import ConfigError
from skylimb.flight.flying import fly_here
from skylimb.flight.simulated_run import scored_run
from skylimb.flight.takeoff import take_off
from skylimb.simulation.tool import BALLS, CORNERS

QUICK = {"phases.hover": 0.5, "phases.tare": 1.5, "phases.hover_end": 0.0}


def plant_of(**given: Any) -> Any:
    (takeoff,) = take_off("face_to_face", (None,), 0, given)
    return takeoff.plant


def test_five_balls_share_the_stiffness_and_stand_in_a_square() -> None:
    foot, ball = plant_of().model, plant_of(**{"plant.foot": None}).model
    assert (foot.npair, ball.npair) == (BALLS, 1)
    np.testing.assert_allclose(foot.pair_solref, np.tile(ball.pair_solref / BALLS, (BALLS, 1)), rtol=1e-12)
    np.testing.assert_array_equal(foot.pair_friction, np.tile(ball.pair_friction, (BALLS, 1)))
    assert foot.opt.impratio == ball.opt.impratio
    places = np.array([foot.geom(f"tip_{k}").pos - foot.geom("tip").pos for k in range(len(CORNERS))])
    np.testing.assert_allclose(places[:, 0], 0.0)
    np.testing.assert_allclose(places[:, 1:], 0.08 * np.array(CORNERS))


def test_the_robot_is_the_described_one_and_the_scene_has_the_foot() -> None:
    plant = plant_of()
    assert plant.as_described
    assert 'name="tip_3"' in plant.scene
    # The plate between them is only looked at.
    assert 'name="tip_plate"' in plant.scene
    assert plant.model.npair == BALLS
    assert 'name="tip_3"' not in plant_of(**{"plant.foot": None}).scene


@pytest.mark.parametrize(
    ("given", "why"),
    [
        ({"surface.static_ratio": 1.5}, "friction that varies"),
        ({"surface.sway_amplitude": 0.01, "surface.sway_frequency": 1.0}, "moves"),
        ({"events": [{"kind": "surface", "time": 5.0, "friction": 0.1}]}, "plant.foot"),
        # As of a ball: a fifth of it is not what acts.
        ({"surface.stiffness": 5e5}, "500000 N/m is too stiff for a time step"),
    ],
)
def test_what_a_foot_or_the_time_step_cannot_do_is_refused(given: dict[str, Any], why: str) -> None:
    with pytest.raises(ConfigError, match=why):
        plant_of(**given)


def test_it_comes_to_lie_flat_and_carries_a_wanted_torque() -> None:
    log = skylimb.run("face_to_face", set=QUICK).log
    end = log.where((log.phase == 4) & (log.time > float(log.time[-1]) - 7.0), drop=True)
    force = end.contact_force.values
    assert np.linalg.norm(force.mean(axis=0)) == pytest.approx(3.0, abs=0.2)
    torque = np.cross(end.contact_point.values - end.tip_position.values, force).mean(axis=0)
    np.testing.assert_allclose(-torque[1:], [0.1, -0.05], atol=0.1)
    # The plane leans by 0.087 rad about z and by 0.07 rad about y.
    np.testing.assert_allclose(np.abs(end.tip_turn.values[:, 1:].mean(axis=0)), [0.07, 0.087], atol=0.02)


def test_the_torque_of_its_contact_is_that_of_all_its_balls() -> None:
    """Friction turns a foot about its normal as well, a torque that no force at one point has."""
    (takeoff,) = take_off("face_to_face", (None,), 0, QUICK | {"trajectory.duration": 8.0})
    flight, model = fly_here(takeoff), takeoff.plant.model
    log = scored_run(takeoff, flight).log
    data, turning = mujoco.MjData(model), np.zeros(3)
    ticks = np.flatnonzero(log.phase.values == 4)[-200:]
    for k in ticks:
        data.qpos[:], data.qvel[:] = (
            flight.signal(name)[k] for name in ("configuration", "configuration_velocity")
        )
        angles = log.joint_angles_command.values[k], log.vectoring_angles_command.values[k]
        data.act[:] = np.concatenate([log.thrusts.values[k], *angles])
        mujoco.mj_forward(model, data)
        for index, contact in enumerate(data.contact):
            wrench = np.zeros(6)
            mujoco.mj_contactForce(model, data, index, wrench)
            turning += np.cross(contact.pos - data.subtree_com[1], contact.frame.reshape(3, 3).T @ wrench[:3])
    mean = log.contact_torque.values[ticks].mean(axis=0)
    np.testing.assert_allclose(mean, turning / len(ticks), atol=0.01)
    assert np.abs(log.contact_couple.values[ticks].mean(axis=0)).max() > 0.015
