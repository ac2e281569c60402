"""What the axes of a task are called."""

import pytest

from skylimb.analysis.scores.axis_names import (
    GENERIC,
    PAPER,
    AxisNames,
    axis_names,
    common_names,
    names_of_vectors,
)
from skylimb.analysis.scores.registry import SCORES
from skylimb.control.missions.frame import contact_frame

MINUS = "\N{MINUS SIGN}"


@pytest.mark.parametrize(
    ("contact_axis", "names"),
    [
        ((1.0, 0.0, 0.0), PAPER),
        ((0.0, 0.0, 1.0), AxisNames("y", f"{MINUS}x", "z")),  # a ceiling
        ((0.0, 0.0, -1.0), AxisNames("y", "x", f"{MINUS}z")),  # a floor
        ((0.6, 0.0, 0.8), AxisNames("y", "v", "n")),
        ((0.6, 0.8, 0.0), AxisNames("u", "z", "n")),
    ],
)
def test_an_axis_has_its_name_in_the_world_where_it_is_one(contact_axis, names):
    frame = contact_frame(contact_axis)
    assert names_of_vectors(frame.sliding_u, frame.sliding_v, frame.contact) == names


def test_the_words_say_which_axis_is_which():
    assert str(PAPER) == "contact axis n = x, sliding axes u = y and v = z"
    assert str(AxisNames("y", "v", "n")) == "contact axis n, sliding axes u = y and v"


def test_lines_of_a_ceilings_table_name_what_they_measure():
    ceiling = AxisNames("y", f"{MINUS}x", "z")
    assert SCORES["error_u_median"].line(ceiling) == "|y error|, median"
    assert SCORES["error_v_median"].line(ceiling) == "|x error|, median"
    assert SCORES["displacement_median"].line(ceiling) == "|z displacement|, median"
    assert SCORES["displacement_median"].titled(ceiling).endswith("from the mission (m)")
    floor = AxisNames("y", "x", f"{MINUS}z")
    assert SCORES["estimated_force_median"].line(floor) == f"estimated in {MINUS}z, median"
    assert SCORES["error_u_spread"].text(ceiling).endswith("the |y error| of the CoG to the mission")


@pytest.mark.parametrize("axes", [GENERIC, PAPER])
def test_no_description_keeps_a_place_for_a_name(axes):
    for score in SCORES.values():
        for text in (score.text(axes), score.line(axes)):
            assert "{" not in text
            assert text
    assert SCORES["error_v_median"].text() == "Median |v error| of the CoG to the mission"


def test_runs_that_touch_in_different_directions_have_general_names(make_log):
    wall, ceiling = make_log(), make_log()
    ceiling.attrs |= {"contact_axis": [0.0, 0.0, 1.0], "sliding_axes": [0.0, 1.0, 0.0, -1.0, 0.0, 0.0]}
    assert axis_names(wall) == PAPER
    assert axis_names(ceiling).n == "z"
    assert common_names([wall, wall]) == PAPER
    assert common_names([wall, ceiling]) == GENERIC
    assert common_names([]) == GENERIC
