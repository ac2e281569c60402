"""The observer in flight: a step of force on a hovering robot with ideal sensors and no rotor lag."""

import numpy as np
import pytest

import skylimb

IDEAL = {
    "sensors.rate": 0.0,
    "sensors.latency": 0.0,
    "sensors.position_noise": 0.0,
    "sensors.velocity_noise": 0.0,
    "sensors.attitude_noise": 0.0,
    "sensors.angular_velocity_noise": 0.0,
    "sensors.joint_noise": 0.0,
    "sensors.vectoring_noise": 0.0,
    "plant.rotor_lag": 0.0,
}


@pytest.fixture(scope="module")
def pushed() -> skylimb.Run:
    return skylimb.run("push", controller="impedance", set=IDEAL)


def test_the_estimate_answers_a_step_like_a_first_order_low_pass(pushed: skylimb.Run) -> None:
    force = -pushed.log["external_force_estimate"].sel(axis="x").values
    since = pushed.log["time"].values - 8.0
    after = (since >= 0.0) & (since < 12.0)
    passed = np.interp(1.0 - np.exp(-1.0), force[after][:400], since[after][:400])
    assert passed == pytest.approx(1.0 / 3.0, rel=0.02)
    assert force[after][-400:] == pytest.approx(1.0, abs=0.01)


def test_the_bias_in_free_flight_is_small(pushed: skylimb.Run) -> None:
    log = pushed.log
    before = log.where(log["time"] < 8.0, drop=True)
    untared = before["external_force_estimate"] + before["external_force_bias"]
    assert np.abs(untared.mean("time").values).max() < 0.02


def test_the_push_shows_in_the_motion_as_the_impedance_says(pushed: skylimb.Run) -> None:
    log = pushed.log
    late = log.where((log["time"] > 18.0) & (log["time"] < 20.0), drop=True)
    away = (late["cog_position"] - late["cog_position_reference"]).sel(axis="x").mean()
    # Along x, M_d = m: no feedback of the force, a spring of m K.
    assert float(away) == pytest.approx(-1.0 / (4.120637 * 2.5), rel=0.03)
