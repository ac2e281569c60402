"""Two springs in series: a board pushes body and arm, and each gives way as its own stiffness says."""

import pytest

import skylimb

K_A, K_X, MASS = 16.0, 2.5, 4.120637


@pytest.mark.slow
def test_displacement_of_hybrid_over_impedance_is_that_of_springs_in_series() -> None:
    settings = {
        "surface.slope": 0.0,
        "surface.friction": 0.0,
        "surface.advance_distance": 0.10,
        "surface.advance_speed": 0.01,
        "surface.advance_start": 16.0,
        "approach.depth": 0.0,
        "trajectory.shape": "hold",
        "trajectory.duration": 40.0,
        "controller.allocation.leak.compensate": True,
    }
    runs = skylimb.compare("paper", ("impedance", "hybrid"), set=settings)
    moved = {}
    for name, run in runs.items():
        assert run.status == "OK", run.cause
        log = run.log
        away = (log["cog_position"] - log["cog_position_reference"]).sel(axis="x")

        def mean(start: float, end: float, signal=away, log=log) -> float:
            return float(signal.where((log["time"] > start) & (log["time"] < end)).mean())

        moved[name] = mean(48.0, 53.0) - mean(14.0, 16.0)
    ratio = moved["hybrid"] / moved["impedance"]
    assert ratio == pytest.approx(K_A / (K_A + MASS * K_X), rel=0.03)
