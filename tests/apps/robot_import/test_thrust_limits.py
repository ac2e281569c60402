"""Limits of an axle as thrusts: what is believed, and what is named where it cannot be."""

import pytest

from skylimb.apps.robot_import.checking import check_robot_file
from skylimb.apps.robot_import.thrust_limits import Axle, thrust_limits
from skylimb.base.errors import DescriptionError


@pytest.mark.parametrize(
    ("lower", "upper", "told"),
    [
        ("0.5", "8N", "upper = '8N' is no number"),
        ("8", "0", "lower 8 is above upper 0"),
        ("0", "-8", "lower 0 is above upper -8"),
        ("0", "1e9", "upper 1e+09 is no thrust below 1000 N"),
    ],
)
def test_limits_that_are_said_but_wrong_are_named(lab_file, lower: str, upper: str, told: str) -> None:
    assert thrust_limits(Axle("rotor1", lower, upper)) == (None, None, told)
    path = lab_file(('lower="0.5" upper="12"', f'lower="{lower}" upper="{upper}"'))
    doubts = [str(doubt) for doubt in check_robot_file(path).doubts if doubt.what.startswith("greatest")]
    assert len(doubts) == 1
    named = "greatest thrust of joint rotor1 and rotor2, rotor3, rotor4, each"
    assert doubts[0].startswith(f"{named}: {told}; 2 times the weight is assumed")


@pytest.mark.parametrize(
    ("lower", "upper", "low", "high"),
    [
        ("0", "14", 0.0, 14.0),
        ("", "", None, None),
        ("-1e16", "1e16", None, None),
        ("-3.14", "3.14", None, None),
        ("0", "6.283185307179586", None, None),
        ("0", "0", None, None),
    ],
)
def test_limits_that_are_no_thrusts_are_no_mistake(
    lower: str, upper: str, low: float | None, high: float | None
) -> None:
    assert thrust_limits(Axle("rotor1", lower, upper)) == (low, high, "")


def test_a_comma_in_a_number_is_named_with_its_link(lab_file) -> None:
    path = lab_file(('<mass value="0.3"', '<mass value="0,3"'))
    with pytest.raises(
        DescriptionError, match=r"value = '0,3' of <mass> in link 'battery' is no number; a decimal poi"
    ):
        check_robot_file(path)
