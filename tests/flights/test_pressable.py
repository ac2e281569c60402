"""A force that cannot be held is refused before take-off; a doubtful one is flown with a warning."""

import warnings

import numpy as np
import pytest

import skylimb
from skylimb.errors import ConfigError
from skylimb.experiments.experiment import load_experiment
from skylimb.flights.loading import take_off
from skylimb.flights.pressable import warn_of_friction

FORCE = "controller.translation.force"


def test_a_force_beyond_the_thrusts_is_refused_with_what_can_be_held() -> None:
    with pytest.raises(ConfigError) as caught:
        skylimb.begin("ceiling", "following", set={FORCE: 20.0})
    words = str(caught.value)
    assert words.startswith("controller 'following' commands a force of 20 N; in its nominal posture ")
    assert "hydrus_xi_quad_mast can hold about 19." in words
    assert "thrusts of 1 .. 30 N" in words


def test_a_force_beyond_the_tilt_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"tilted by at most 0\.3 rad"):
        skylimb.begin("paper", "following", set={FORCE: 20.0, "terminations.tilt": 0.3})


def test_a_force_that_a_gain_change_raises_is_looked_at() -> None:
    change = {"time": 12.0, "key": "translation.force", "value": 20.0}
    with pytest.raises(ConfigError, match="commands a force of 20 N"):
        skylimb.begin("ceiling", "following", set={"gain_changes": [change]})
    assert take_off("ceiling", ["following"], set={"gain_changes": [change | {"value": 15.0}]})


@pytest.mark.parametrize(("experiment", "force"), [("paper", 12.0), ("ceiling", 15.0), ("push", 20.0)])
def test_a_force_that_can_be_held_or_is_never_pressed_takes_off(experiment: str, force: float) -> None:
    assert take_off(experiment, ["following"], set={FORCE: force})


def test_drag_that_cannot_be_held_is_a_warning() -> None:
    steady, dragged = (load_experiment("ceiling", {"surface.friction": friction}) for friction in (0.1, 1.5))
    (takeoff,) = take_off(steady, ["following"], set={FORCE: 6.0})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warn_of_friction(steady, takeoff.robot, takeoff.controller)
    with pytest.warns(UserWarning, match="6 N is doubtful: at a friction of 1.5"):
        take_off(dragged, ["following"], set={FORCE: 6.0})


@pytest.mark.parametrize(("degrees", "most"), [(20.0, 3.4), (-20.0, 2.9)])
def test_the_slope_counts_with_the_drag(degrees: float, most: float) -> None:
    leaning = {"surface.slope": np.radians(degrees), "surface.friction": 0.8}
    with pytest.warns(UserWarning, match=rf"{degrees:g} degrees hydrus_xi_quad can hold about {most}"):
        take_off("paper", ["following"], set={FORCE: 5.0, **leaning})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        take_off("paper", ["following"], set={FORCE: most - 0.1, **leaning})
