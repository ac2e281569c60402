"""A sweep is every combination flown, its scores one dataset over the swept keys."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import skylimb
from skylimb.analysis.scores.user_scores import load_user_scores
from skylimb.base.errors import ConfigError, UnknownNameError
from skylimb.studies.campaign.sweep import _files

EXAMPLES = Path(__file__).parents[3] / "examples"
SHORT = {
    "approach.contact": False,
    "phases.hover": 0.1,
    "phases.tare": 0.2,
    "phases.settle": 0.0,
    "phases.hover_end": 0.1,
    "trajectory.shape": "hold",
}
OWN = str(EXAMPLES / "user_controller.py")


@pytest.fixture(scope="module")
def swept() -> xr.Dataset:
    return skylimb.sweep(
        "paper",
        ["hybrid", OWN],
        {"plant.mass_scale": [1.0, 1.1], "trajectory.duration": np.array([0.1, 0.2])},
        seeds=(5, 6),
        set=SHORT,
        use=[EXAMPLES / "user_metric.py"],
        logs=["thrusts", "tilt"],
        workers=0,
    )


def test_scores_stand_over_the_swept_keys(swept: xr.Dataset) -> None:
    assert swept.tilt_max.dims == ("plant.mass_scale", "trajectory.duration", "seed", "controller")
    assert swept.seed.values.tolist() == [5, 6]
    assert swept["trajectory.duration"].values.tolist() == [0.1, 0.2]
    assert swept["trajectory.duration"].attrs["units"] == "s"
    assert swept.controller.values.tolist() == ["hybrid", "user_controller"]
    assert (swept.status == "OK").all()
    assert swept.tilt_max.attrs == {"units": "rad", "long_name": "Largest tilt"}
    assert swept.tilt_spread_roll.attrs["units"] == "rad"


def test_each_place_has_the_flight_of_its_values(swept: xr.Dataset) -> None:
    for controller, name in (("hybrid", "hybrid"), (OWN, "user_controller")):
        settings = {**SHORT, "plant.mass_scale": 1.1, "trajectory.duration": 0.1}
        run = skylimb.run("paper", controller, seed=6, set=settings)
        place = {"plant.mass_scale": 1.1, "trajectory.duration": 0.1, "seed": 6, "controller": name}
        here = swept.sel(place)
        assert float(here.tilt_max) == run.metrics["tilt_max"]
        count = run.log.sizes["time"]
        np.testing.assert_array_equal(here.thrusts.values[:count], run.log.thrusts.values)
        assert np.isnan(here.thrusts.values[count:]).all()
    assert swept.thrusts.dims[-2:] == ("time", "rotor")
    assert swept.thrusts.attrs["units"] == "N"


def test_gains_are_swept_by_name() -> None:
    found = skylimb.sweep(
        "paper",
        OWN,
        {"controller.velocity.2": [3.0, 6.0]},
        set={**SHORT, "controller.spin": [12.0, 12.0, 5.0]},
    )
    assert found.tilt_max.dims == ("controller.velocity.2", "seed")
    assert found["controller.velocity.2"].attrs["units"] == "1/s"
    assert found.displacement_median[0, 0] != found.displacement_median[1, 0]


@pytest.mark.parametrize(
    ("over", "error", "message"),
    [
        ({"surface.frction": [0.1]}, UnknownNameError, "did you mean 'surface.friction'|friction"),
        ({"surface.friction": 0.1}, ConfigError, r"over\['surface.friction'\] = 0.1 should be a list"),
        ({"surface.friction": []}, ConfigError, r"over\['surface.friction'\] is empty"),
        ({"surface.friction": [-1.0]}, ConfigError, "surface.friction = -1"),
        ({"seed": [1, 2]}, ConfigError, r"seeds = \[1, 2\] flies these seeds"),
        (["surface.friction"], ConfigError, r"over = \['surface.friction'\] should be a table"),
    ],
)
def test_what_cannot_be_swept_is_refused(over: Any, error: type, message: str) -> None:
    with pytest.raises(error, match=message):
        skylimb.sweep("paper", "hybrid", over, set=SHORT, workers=0)


@pytest.mark.parametrize("seeds", [0, -2, [], [1.5], ["a"], 2.0, "12"])
def test_seeds_that_are_none_are_refused(seeds: Any) -> None:
    with pytest.raises(ConfigError, match=re.escape(f"seeds = {seeds!r} ")):
        skylimb.sweep("paper", "hybrid", seeds=seeds, set=SHORT, workers=0)
    with pytest.raises(ConfigError, match=r"set\['seed'\] = 3: .* seeds says which"):
        skylimb.sweep("paper", "hybrid", set={**SHORT, "seed": 3}, workers=0)


def test_seeds_and_signals_come_as_numpy_has_them_or_alone() -> None:
    count: Any = np.int64(2)
    found = skylimb.sweep("paper", "pid", seeds=count, set=SHORT, logs="tilt", workers=0)
    assert found.seed.values.tolist() == [0, 1]
    assert found.tilt.dims[-1] == "time"
    listed = skylimb.sweep("paper", "pid", seeds=np.array([1]), set=SHORT, workers=0)
    assert listed.tilt_max[0] == found.tilt_max[1]


def test_a_metric_at_hand_is_found_in_its_file() -> None:
    (overshoot, *_) = load_user_scores([EXAMPLES / "user_metric.py"])
    assert _files([overshoot, str(EXAMPLES / "user_metric.py")]) == (str(EXAMPLES / "user_metric.py"),)
    nowhere = skylimb.metric(eval("lambda run: 1.0"))
    with pytest.raises(ConfigError, match="a sweep needs the Python file"):
        _files([nowhere])
