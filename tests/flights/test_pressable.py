"""A force that cannot be held, or leaves too little over, is refused before take-off."""

import warnings

import numpy as np
import pytest

import skylimb
from skylimb.errors import ConfigError
from skylimb.flights.takeoff import take_off

FORCE = "controller.translation.force"
FLY = {"approach.doubtful": "fly"}


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
    change = {"kind": "gain", "time": 12.0, "key": "translation.force", "value": 20.0}
    with pytest.raises(ConfigError, match="commands a force of 20 N"):
        skylimb.begin("ceiling", "following", set={"events": [change]})
    assert take_off("ceiling", ["following"], set={"events": [change | {"value": 15.0}], **FLY})


@pytest.mark.filterwarnings("ignore:a force of")
@pytest.mark.parametrize(("experiment", "force"), [("paper", 12.0), ("ceiling", 15.0), ("push", 20.0)])
def test_a_force_that_can_be_held_or_is_never_pressed_takes_off(experiment: str, force: float) -> None:
    assert take_off(experiment, ["following"], set={FORCE: force, **FLY})


@pytest.mark.parametrize(
    ("degrees", "held", "most"), [(20.0, "3.5", "2.1"), (-20.0, "2.9", "1.8"), (0.0, "4.0", "2.4")]
)
def test_a_force_that_leaves_too_little_over_is_refused_with_what_takes_off(
    degrees: float, held: str, most: str
) -> None:
    leaning = {"surface.slope": np.radians(degrees), "surface.friction": 0.8}
    with pytest.raises(ConfigError) as caught:
        take_off("paper", ["drawing"], set={FORCE: 3.0, **leaning})
    words = str(caught.value)
    assert words.startswith("a force of 3 N is too much: at a friction of 0.8")
    assert ("a slope of" in words) is (degrees != 0.0)
    assert f"can hold about {held} N at rest" in words
    assert f"; {most} N and less take off" in words
    assert 'approach.doubtful = "fly" flies 3 N' in words
    assert "\n" not in words
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        take_off("paper", ["drawing"], set={FORCE: float(most) - 0.1, **leaning})


def test_who_wants_to_flies_it_and_is_warned() -> None:
    with pytest.warns(UserWarning, match=r"5 N is too much: .* can hold about 5\.\d N"):
        assert take_off("paper", ["following"], set={FORCE: 5.0, **FLY})


def test_more_than_half_is_a_warning_and_half_is_none() -> None:
    with pytest.warns(UserWarning, match=r"3 N is doubtful: at a friction of 0\.4 and a slope of 20 degrees"):
        take_off("paper", ["following"], set={FORCE: 3.0})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        take_off("paper", ["following"], set={FORCE: 2.6})
        take_off("ceiling", ["following"], set={FORCE: 3.0})


def test_without_friction_there_is_no_drag_to_leave_room_for() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        take_off("paper", ["following"], set={FORCE: 5.0, "surface.friction": 0.0})
