"""What the distance to the nearest point forgives shows in the distances between whole lines."""

import functools
import itertools
import json
from typing import NamedTuple

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

from skylimb.analysis.recording import Run
from skylimb.analysis.scores.drawn_strokes import lift
from skylimb.analysis.scores.fidelity import Fidelity, fidelity, frechet
from skylimb.analysis.scores.metrics import metrics
from skylimb.analysis.scores.pen_line import pen_deviation
from skylimb.analysis.scores.strokes import drawn_line

CENTRE = np.array([1.2, 0.0, 1.2])
SQUARE = np.array([[0.0, 0.0], [0.1, 0.0], [0.1, 0.1], [0.0, 0.1], [0.0, 0.0]])


def along(corners, pitch=0.0005):
    """Points along straight lines between corners, (n, 2)."""
    parts = [
        np.linspace(a, b, max(2, round(float(np.hypot(*(b - a))) / pitch)))
        for a, b in itertools.pairwise(corners)
    ]
    return np.vstack(parts)


def circle(centre, radius):
    angle = np.linspace(0.0, 2.0 * np.pi, 200)
    return centre + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def flight(lines, parts, dt=0.01):
    """A log with a reference, flown through parts: (phase, touching, (n, 2) of the pen).

    One sample a point.
    """
    uv = np.vstack([points for _, _, points in parts])
    phase = np.concatenate([[{"slide": 0, "lift": 1}[name]] * len(points) for name, _, points in parts])
    touch = np.concatenate([[touching] * len(points) for _, touching, points in parts]).astype(np.int8)
    gap = np.full((1, 2), np.nan)
    reference = np.vstack([row for line in lines for row in (np.asarray(line, dtype=float), gap)][:-1])
    tip = CENTRE + np.column_stack([np.zeros(len(uv)), uv])
    return xr.Dataset(
        {
            "tip_position": (("time", "axis"), tip),
            "phase": (("time",), phase, {"flag_values": [0, 1], "flag_meanings": "slide lift"}),
            "contact": (("time",), touch),
            "reference_line": (("reference_point", "plane"), reference),
        },
        coords={"time": dt * np.arange(len(uv))},
        attrs={"path_center": json.dumps(CENTRE.tolist()), "contact_axis": "x", "sliding_axes": ["y", "z"]},
    )


AIR = along(np.array([[0.0, 0.0], [0.2, 0.2]]), 0.002)


def small_and_large(draw_small=True, tail=None, lead=None):
    """A square and a small circle inside of it, with a lift between the two."""
    small = circle(np.array([0.1, 0.05]), 0.006)
    parts = [("slide", True, along(SQUARE))]
    if tail is not None:
        parts.append(("lift", True, tail))
    parts.append(("lift", False, AIR))
    if lead is not None:
        parts.append(("lift", True, lead))
    parts.append(("slide", draw_small, small))
    return flight([SQUARE, small], parts)


class Drawn(NamedTuple):
    whole: Fidelity
    strokes: tuple[Fidelity, ...]
    lift_time: float
    lift_touch: float


def drawn_of(log: xr.Dataset) -> Drawn:
    """All that a flight's log says of its drawing."""
    line, lifted = drawn_line(log), lift(Run("", "", log))
    assert line is not None
    return Drawn(line.whole, line.strokes, lifted["time"], lifted["touch_time"])


def test_what_is_drawn_on_its_line_is_faithful() -> None:
    log = small_and_large()
    drawn = drawn_of(log)
    assert drawn.whole.frechet < 0.001
    assert drawn.whole.missing < 0.001
    assert drawn.whole.stray < 0.001
    assert drawn.whole.length == pytest.approx(0.4 + 2.0 * np.pi * 0.006, rel=1e-3)
    assert drawn.whole.drawn == pytest.approx(drawn.whole.length, rel=0.02)
    assert [stroke.frechet < 0.001 for stroke in drawn.strokes] == [True, True]
    assert drawn.lift_touch == 0.0
    assert drawn.lift_time == pytest.approx(0.01 * len(AIR))


def test_a_missing_small_circle_is_seen_where_nearest_points_forgive() -> None:
    log = small_and_large(draw_small=False)
    assert np.sqrt(np.mean(pen_deviation(log) ** 2)) < 0.001
    drawn = drawn_of(log)
    assert np.isnan(drawn.strokes[1].frechet)
    assert drawn.strokes[1].drawn == 0.0
    # In order: the leash reaches from the square's last corner to the far side of the circle.
    assert drawn.whole.frechet == pytest.approx(np.hypot(0.106, 0.05), abs=0.002)
    assert metrics(log)["strokes"][1]["frechet"] is None


def test_cut_corners_are_seen_where_nearest_points_forgive() -> None:
    """A star drawn as the polygon inside of it, and back and forth along one side of a square."""
    to_and_fro = np.array([[0.0, 0.0], [0.1, 0.0], [0.1, 0.1], [0.1, 0.0], [0.0, 0.0]])
    log = flight([SQUARE], [("slide", True, along(to_and_fro))])
    assert pen_deviation(log).max() < 0.001
    drawn = drawn_of(log)
    assert drawn.whole.stray < 0.001
    assert drawn.whole.missing == pytest.approx(0.1, abs=0.001)
    assert drawn.whole.frechet == pytest.approx(0.1, abs=0.001)
    spike = np.array([[0.0, 0.0], [0.05, 0.0], [0.06, 0.02], [0.07, 0.0], [0.12, 0.0]])
    blunt = np.array([[0.0, 0.0], [0.12, 0.0]])
    cut = flight([spike], [("slide", True, along(blunt))])
    assert np.sqrt(np.mean(pen_deviation(cut) ** 2)) < 0.003
    found = drawn_of(cut)
    assert found.whole.frechet == pytest.approx(0.02, abs=0.001)
    assert found.whole.missing == pytest.approx(0.02, abs=0.001)


def test_a_line_drawn_backwards_is_as_far_as_its_ends() -> None:
    line = np.array([[0.0, 0.0], [0.1, 0.0]])
    log = flight([line], [("slide", True, along(line)[::-1])])
    drawn = drawn_of(log)
    assert pen_deviation(log).max() < 1e-9
    assert drawn.whole.frechet == pytest.approx(0.1, abs=0.001)


def test_a_tail_belongs_to_the_stroke_before_and_a_lead_to_the_one_after() -> None:
    tail = along(np.array([[0.0, 0.0], [-0.03, 0.0]]))
    lead = along(np.array([[0.15, 0.05], [0.106, 0.05]]))
    log = small_and_large(tail=tail, lead=lead)
    drawn = drawn_of(log)
    assert drawn.strokes[0].stray == pytest.approx(0.03, abs=0.001)
    assert drawn.strokes[0].frechet == pytest.approx(0.03, abs=0.001)
    assert drawn.strokes[0].drawn == pytest.approx(0.43, rel=0.02)
    assert drawn.strokes[1].stray == pytest.approx(0.044, abs=0.001)
    assert drawn.lift_touch == pytest.approx(0.01 * (len(tail) + len(lead)))


def test_a_drawing_that_is_stopped_has_each_stroke_where_it_was_drawn() -> None:
    """With a stroke missing all that was drawn belonged to the first, and the place was that of nothing."""
    third = circle(np.array([0.05, 0.02]), 0.006)
    away = ("lift", False, AIR)
    parts = [("slide", True, along(SQUARE)), away, ("slide", True, circle(np.array([0.1, 0.05]), 0.006))]
    stopped = drawn_line(flight([SQUARE, parts[2][2], third], parts))
    assert stopped is not None
    assert [stroke.kept for stroke in stopped.strokes] == [True, True, False]
    assert stopped.strokes[2].drawn == 0.0
    assert stopped.place < 0.001


def test_a_pen_that_never_leaves_has_its_lift_divided_in_the_middle() -> None:
    small = circle(np.array([0.2, 0.0]), 0.006)
    way = along(np.array([[0.0, 0.0], [0.2, 0.0]]))
    log = flight(
        [SQUARE, small], [("slide", True, along(SQUARE)), ("lift", True, way), ("slide", True, small)]
    )
    drawn = drawn_of(log)
    assert drawn.lift_touch == pytest.approx(drawn.lift_time)
    assert drawn.strokes[1].stray == pytest.approx(0.1 - 0.006, abs=0.002)


@pytest.mark.parametrize("stands", [1.0, 1.75, 2.25, 2.5])
def test_a_landing_is_no_touch_of_a_lifted_pen(stands: float) -> None:
    """The clock waits at the end of the lift, between two ticks too, until the law has felt the surface."""
    log = small_and_large(lead=along(np.array([[0.107, 0.05], [0.106, 0.05]]), 0.0005))
    lift_samples = np.flatnonzero(log.phase.values == 1)
    clock = log.time.values.copy()
    waits = 6  # samples; the last three touch, and the clock goes on with the last tick of the lift
    clock[lift_samples[-waits:-1]] = clock[lift_samples[-1]] - 0.01 * stands
    landed = drawn_of(log.assign(mission_time=("time", clock)))
    assert drawn_of(log).lift_touch > 0.0
    assert landed.lift_touch == 0.0
    assert landed.lift_time == pytest.approx(0.01 * (len(lift_samples) - waits))


def test_a_log_that_begins_with_a_gap_has_the_same_lifts() -> None:
    """Time was counted in steps as long as the first one."""
    whole = small_and_large(tail=along(np.array([[0.0, 0.0], [0.02, 0.02]]), 0.002))
    gap = whole.isel(time=np.r_[0, 40 : whole.sizes["time"]])
    assert drawn_of(gap).lift_time == pytest.approx(drawn_of(whole).lift_time)
    assert drawn_of(gap).lift_touch == pytest.approx(drawn_of(whole).lift_touch)


def test_the_verdict_holds_a_drawing_to_order_and_lifts() -> None:
    tolerances = {"pen_line": 0.02, "path": 0.95, "contact": 0.0, "strokes": 0.0, "lifted": 0.05}
    tail = along(np.array([[0.0, 0.0], [-0.03, 0.0]]))

    def missed(log):
        scores = metrics(log.assign_attrs(tolerances=json.dumps(tolerances)))
        return [name for name, check in scores["checks"].items() if not check["kept"]]

    assert missed(small_and_large()) == []
    assert missed(small_and_large(draw_small=False)) == ["path", "strokes"]
    assert missed(small_and_large(tail=tail)) == ["strokes", "lifted"]


def test_a_log_without_a_line_has_no_scores_of_one(make_log) -> None:
    scores = metrics(make_log().drop_vars("tip_position"))
    assert scores["strokes"] == []
    assert scores["line_shape"] is None


def test_the_length_is_not_that_of_the_pens_trembling() -> None:
    line = along(np.array([[0.0, 0.0], [0.1, 0.0]]), 0.0001)
    trembling = line + 0.0002 * np.random.default_rng(1).normal(size=line.shape)
    log = flight([line], [("slide", True, trembling)])
    drawn = drawn_of(log)
    assert drawn.whole.drawn == pytest.approx(0.1, rel=0.2)


points = st.lists(st.tuples(st.integers(-9, 9), st.integers(-9, 9)), min_size=1, max_size=9)


@settings(max_examples=60, deadline=None)
@given(points, points)
def test_the_frechet_distance_is_that_of_its_definition(first, second) -> None:
    p, q = np.array(first, dtype=float), np.array(second, dtype=float)

    @functools.cache
    def leash(i: int, j: int) -> float:
        here = float(np.hypot(*(p[i] - q[j])))
        if i == j == 0:
            return here
        ways = [leash(a, b) for a, b in ((i - 1, j), (i - 1, j - 1), (i, j - 1)) if a >= 0 and b >= 0]
        return max(here, min(ways))

    assert frechet(p, q) == pytest.approx(leash(len(p) - 1, len(q) - 1))


def test_many_points_are_thinned() -> None:
    line = np.column_stack([np.linspace(0.0, 1.0, 20_000), np.zeros(20_000)])
    assert frechet(line, line + np.array([0.0, 0.1])) == pytest.approx(0.1, abs=1e-3)


def test_nothing_drawn_has_no_distance() -> None:
    found = fidelity([SQUARE], [])
    assert np.isnan([found.frechet, found.missing, found.stray]).all()
    assert (found.length, found.drawn) == (pytest.approx(0.4), 0.0)
