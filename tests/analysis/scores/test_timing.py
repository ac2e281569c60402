"""Whether the pen was where it was to be at each moment, and how long a flight took."""

import json

import numpy as np
import pytest
import xarray as xr

from skylimb.analysis.figures.traces import pen_traces
from skylimb.analysis.recording import Run
from skylimb.analysis.scores.metrics import metrics
from skylimb.flight.experiments.tolerances import Tolerances

PHASES = {"flag_values": range(4), "flag_meanings": "settle slide lift retreat"}
LINE = {"frechet", "of_size", "finest", "pen_line", "marks", "path", "strokes", "longer", "behind"}
SIZES = pytest.mark.parametrize("size", [0.010, 0.025, 0.15, 0.6])


def circle(size, turned):
    angle = 2.0 * np.pi * turned
    return 0.5 * size * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def drawn(size, turned, **more):
    """A log of a circle that is commanded at an even speed and drawn as it is turned, (2000,), 0 to 1."""
    even = np.linspace(0.0, 1.0, 2000)
    points = [np.column_stack([np.zeros(2000), circle(size, part)]) for part in (even, turned)]
    tolerances = {name: value for name, value in vars(Tolerances()).items() if name in LINE}
    return xr.Dataset(
        {
            "tip_position_reference": (("time", "axis"), points[0]),
            "tip_position": (("time", "axis"), points[1]),
            "phase": (("time",), np.ones(2000, int), PHASES),
            "contact": (("time",), np.ones(2000, np.int8)),
            **{name: (("time",), values) for name, values in more.items()},
        },
        coords={"time": 0.005 * np.arange(2000)},
        attrs={
            "path_center": json.dumps([0.0, 0.0, 0.0]), "contact_axis": "x", "sliding_axes": ["y", "z"],
            "tolerances": json.dumps(tolerances),
        },
    )  # fmt: skip


EVEN = np.linspace(0.0, 1.0, 2000)


@SIZES
def test_a_pen_that_stands_and_then_dashes_is_not_done(size):
    for turned in (np.clip(20.0 * EVEN - 19.0, 0.0, 1.0), np.clip(20.0 * EVEN, 0.0, 1.0)):
        scores = metrics(drawn(size, turned))
        assert {name for name, check in scores["checks"].items() if not check["kept"]} == {"behind"}
        assert scores["missed"][0].startswith("the pen is ")
        assert scores["pen_behind"] > 0.9 * size


@SIZES
def test_a_pen_that_is_a_little_late_is_done(size):
    late = min(0.08, max(0.006, 0.2 * size)) / (np.pi * size)
    scores = metrics(drawn(size, np.clip(EVEN - late, 0.0, 1.0)))
    assert scores["checks"]["behind"]["kept"]
    assert scores["pen_behind"] == pytest.approx(late * np.pi * size, rel=0.1)


def test_one_moment_of_standing_is_no_lag():
    """For a twentieth of the time, and back at once."""
    stands = EVEN.copy()
    stands[1000:1090] = stands[1000]
    assert metrics(drawn(0.6, stands))["pen_behind"] == pytest.approx(0.0, abs=1e-9)


def test_how_long_it_took_and_at_which_pace():
    free = metrics(drawn(0.6, EVEN))
    assert (free["duration"], free["pace_mean"]) == (pytest.approx(9.995), 1.0)
    slow = metrics(drawn(0.6, EVEN, mission_time=3.0 + 0.33 * 0.005 * np.arange(2000)))
    assert slow["duration"] == free["duration"]
    assert slow["pace_mean"] == pytest.approx(0.33)


def test_without_a_reference_of_the_moment_nothing_is_late():
    scores = metrics(drawn(0.6, EVEN).drop_vars("tip_position_reference"))
    assert scores["pen_behind"] is None
    assert "behind" not in scores["checks"]


RADIUS = 0.3


def around_a_post(turned, beside=0.0):
    """A log of a way once around a post at an even speed, by a pen at some angles (2000,), rad.

    The post lies so far `beside` its believed place, m. The angles are about that place.
    """
    log = drawn(0.5, EVEN)
    even = np.linspace(-np.pi, np.pi, 2000)
    touched = beside * np.sin(turned) + np.sqrt(RADIUS**2 - (beside * np.cos(turned)) ** 2)
    for name, angle, far in (("tip_position_reference", even, RADIUS), ("tip_position", turned, touched)):
        points = np.stack([RADIUS - far * np.cos(angle), far * np.sin(angle), 0.0 * angle], axis=1)
        log[name] = (("time", "axis"), points)
    return log.assign_attrs(wrap_radius=RADIUS)


def seen_as_all_around():
    """Angles of a pen that goes from the front to one side, to the other, and back: never behind its post."""
    even = np.linspace(-np.pi, np.pi, 2000)
    return np.where(abs(even) > 0.5 * np.pi, np.sign(even) * np.pi - even, even)


def test_a_pen_that_stays_before_its_post_does_not_go_around_it():
    scores = metrics(around_a_post(seen_as_all_around()))
    assert not scores["checks"]["behind"]["kept"]
    assert scores["pen_behind"] > 0.25
    late = metrics(around_a_post(np.linspace(-np.pi, np.pi, 2000) - 0.1))
    assert late["checks"]["behind"]["kept"]
    assert late["pen_behind"] == pytest.approx(RADIUS * 0.1)


def test_a_line_around_a_post_is_as_long_as_the_way_around_it():
    """Seen from before the post it would be twice its width, with its back on its front."""
    even = np.linspace(-np.pi, np.pi, 2000)
    scores = metrics(around_a_post(even))
    assert scores["line_length"] == pytest.approx(2.0 * np.pi * RADIUS, rel=1e-3)
    assert scores["line_shape"] == pytest.approx(0.0, abs=1e-6)
    assert scores["done"]


def test_traces_around_a_post_are_unrolled_as_they_are_scored():
    """Seen from before it the pen's trace would be as wide as the post, and its back lie on its front."""
    run = Run("a", "task_frame", around_a_post(np.linspace(-np.pi, np.pi, 2000)), {})
    (ax,) = (ax for ax in pen_traces({"a": run}).axes if ax.lines)
    nominal, pen = (np.asarray(line.get_xdata()) for line in ax.lines[:2])
    for line in (nominal, pen):
        assert np.ptp(line) == pytest.approx(2.0 * np.pi * RADIUS, rel=0.01)
        assert (np.diff(line) > 0.0).all() or (np.diff(line) < 0.0).all()
    assert ax.get_xlabel() == "around the post (m)"


@pytest.mark.parametrize("beside", [-0.008, 0.0, 0.008])
def test_a_post_beside_its_place_is_no_error_of_the_line(beside):
    """The pen goes on to each angle about the post that was believed in until it touches the true one.

    Seen from before it the line would be 8 mm beside its place, and what it overshoots its end by on top.
    """
    even = np.linspace(-np.pi, np.pi + 0.015 / RADIUS, 2000)
    scores = metrics(around_a_post(even, beside))
    assert scores["done"], scores["missed"]


@pytest.mark.parametrize(
    "turned",
    [
        seen_as_all_around(),
        np.pi * (EVEN - 1.0),  # half the way
        np.pi * (2.0 * EVEN - 1.0) - 1.6 * np.maximum(EVEN - 0.9, 0.0),  # 48 mm short of its end
    ],
)
def test_a_line_that_is_not_all_around_its_post_is_missed(turned):
    assert not metrics(around_a_post(turned))["checks"]["strokes"]["kept"]
