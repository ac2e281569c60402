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


RUBBING = {
    "plant.thrust_scale": 0.9917,
    "plant.rotor_scale": [1.0097, 1.0158, 1.0139, 0.9979],
    "plant.mass_scale": 1.006,
    "sensors.attitude_misalignment": [0.0031, -0.0137, 0.0],
    "sensors.latency": 0.0269,
    "surface_error": [-0.0036, -0.0194, -0.0117],
    "surface.slope": -0.0482,
    "surface.pitch": -0.0766,
    "surface.friction": 0.4845,
}
"""Of all draws of the benchmark the one whose force swung most."""

QUICK = {"controller.translation.force_integral": 1.5, "controller.translation.press_damping": 3.3}
"""A force integral that swings with an early easing; the slower one of the preset does not here."""


def test_its_own_controller_keeps_the_force_where_friction_is_high() -> None:
    """An eased press frees a pen that lags; it jumps ahead and is eased again, and the force swings."""
    run = skylimb.run("ceiling", set=RUBBING)
    assert run.done, run.missed
    assert run.metrics["force_error_rms"] < 0.15
    early = skylimb.run("ceiling", set=RUBBING | QUICK | {"controller.contact.ease_beyond": [0.015, 0.04]})
    assert early.metrics["force_error_rms"] > 0.3
