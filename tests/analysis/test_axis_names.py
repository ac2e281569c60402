"""What the axes of a task are called."""

import pytest

from skylimb.analysis.axis_names import GENERIC, PAPER, AxisNames, axis_names, common_names, names_of_vectors
from skylimb.analysis.measures import SETS, describe, row_label
from skylimb.analysis.score_names import DESCRIPTIONS, NUMERIC_KEYS
from skylimb.missions.frame import contact_frame

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
    assert row_label("error_u_median", ceiling) == ("|y error|, median", "m")
    assert row_label("error_v_median", ceiling) == ("|x error|, median", "m")
    assert row_label("displacement_median", ceiling) == ("|z displacement|, median", "m")
    floor = AxisNames("y", "x", f"{MINUS}z")
    assert row_label("estimated_force_median", floor) == (f"estimated in {MINUS}z, median", "N")
    assert describe("error_u_spread", ceiling)[0].endswith("the |y error| of the CoG to the mission")


@pytest.mark.parametrize("axes", [GENERIC, PAPER])
def test_no_description_keeps_a_place_for_a_name(axes):
    for key in (*NUMERIC_KEYS, *SETS["paper"].keys, *SETS["contact"].keys):
        for text in (describe(key, axes)[0], row_label(key, axes)[0]):
            assert "{" not in text
            assert text
    assert DESCRIPTIONS["error_v_median"][0] == "Median |v error| of the CoG to the mission"


def test_runs_that_touch_in_different_directions_have_general_names(make_log):
    wall, ceiling = make_log(), make_log()
    ceiling.attrs |= {"contact_axis": [0.0, 0.0, 1.0], "sliding_axes": [0.0, 1.0, 0.0, -1.0, 0.0, 0.0]}
    assert axis_names(wall) == PAPER
    assert axis_names(ceiling).n == "z"
    assert common_names([wall, wall]) == PAPER
    assert common_names([wall, ceiling]) == GENERIC
    assert common_names([]) == GENERIC
