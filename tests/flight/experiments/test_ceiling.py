"""The pen on a mast, against a ceiling."""

import pytest

import skylimb

OFF = {
    "plant.thrust_scale": 1.011,
    "plant.rotor_scale": [0.989, 0.992, 1.015, 0.980],
    "sensors.attitude_misalignment": [0.011, 0.010, -0.001],
    "plant.mass_scale": 0.996,
    "plant.cog_offset": [-0.004, -0.005, -0.001],
}
"""Errors of a robot that does not know itself."""


@pytest.mark.parametrize(("latency", "others"), [(0.0188, {}), (0.028, {}), (0.0201, OFF)])
def test_following_flies_it_also_where_the_robot_does_not_know_itself(
    latency: float, others: dict[str, object]
) -> None:
    run = skylimb.run("ceiling", "following", set={"sensors.latency": latency, **others})
    assert run.status == "OK", run.cause
    assert run.metrics["pen_line_rms"] < 0.010
    assert run.log.tilt.sel(time=slice(0.5, 6.0)).max() < 0.08  # no limit cycle in free flight
