"""What happened to a flight is marked in every figure over time, and nothing is where nothing happened."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from skylimb.analysis.figures import cog_tracking, contact_direction, style, task_progress
from skylimb.analysis.figures.controller_replay import replayed_figures
from skylimb.analysis.figures.marks import LOOKS, event_signs
from skylimb.analysis.figures.plotting import plotted
from skylimb.analysis.recording import Run

Draw = Callable[[Mapping[str, Run]], Figure]


def replayed(runs: Mapping[str, Run]) -> Figure:
    (run,) = runs.values()
    return replayed_figures(run, run)["estimates"]


DRAWN: dict[str, Draw] = {
    "cog_tracking": cog_tracking,
    "contact_direction": contact_direction,
    "task_progress": task_progress,
    "signal": lambda runs: plotted(runs, "cog_position"),
    "replayed": replayed,
}


def panels(figure: Figure) -> list[Axes]:
    return [ax for ax in figure.axes if ax.axison]


def begins(ax: Axes) -> list[tuple[float, str]]:
    """Where lines from bottom to top stand, s, and their colours."""
    return [
        (float(np.asarray(line.get_xdata())[0]), str(line.get_color()))
        for line in ax.lines
        if np.array_equal(line.get_ydata(), [0, 1]) and np.ptp(np.asarray(line.get_xdata())) == 0.0
    ]


def bands(ax: Axes) -> Iterator[tuple[float, float]]:
    for patch in ax.patches:
        if isinstance(patch, Rectangle) and patch.get_alpha():
            yield patch.get_x(), patch.get_x() + patch.get_width()


def numbers(figure: Figure) -> list[str]:
    return [text.get_text() for ax in figure.axes for text in ax.texts if text.get_text()[:1].isdigit()]


def legend(figure: Figure) -> list[str]:
    return [text.get_text() for each in figure.legends for text in each.get_texts()]


def run_of(log, name: str = "hybrid") -> Run:
    return Run(name, name, log, {})


@pytest.mark.parametrize("name", DRAWN)
def test_a_line_where_it_begins_and_a_band_while_it_lasts(name, make_log, make_event, happening):
    log = happening(
        make_log(slide=2.0), make_event(time=2.0, duration=1.5), make_event("gain", 5.0, 9.0, "a")
    )
    figure = DRAWN[name]({"hybrid": run_of(log)})
    end = float(log.time.values[-1])
    for ax in panels(figure):
        assert begins(ax) == [(2.0, LOOKS["push"][1]), (5.0, LOOKS["gain"][1])]
        assert list(bands(ax)) == [(2.0, 3.5), (5.0, end)]  # no farther than the flight
    assert numbers(figure) == ["1", "2"]  # in one of a flight's panels
    assert {"1: 2 N on link4", "2: a"} <= set(legend(figure))


@pytest.mark.parametrize("name", DRAWN)
def test_nothing_is_drawn_where_nothing_happened(name, make_log, happening):
    log = make_log(slide=2.0)
    for calm in (log, happening(log)):
        figure = DRAWN[name]({"hybrid": run_of(calm)})
        assert [begins(ax) for ax in panels(figure)] == [[]] * len(panels(figure))
        assert [list(bands(ax)) for ax in panels(figure)] == [[]] * len(panels(figure))
        assert numbers(figure) == []
        assert not any("event" in text for text in legend(figure))


def test_kinds_differ_by_style_and_a_kind_that_is_new_is_marked_too(make_log, make_event, happening):
    events = [make_event(kind, 1.0 + k, 0.0) for k, kind in enumerate([*LOOKS, "earthquake"])]
    figure = cog_tracking({"hybrid": run_of(happening(make_log(slide=2.0), *events))})
    ax = panels(figure)[0]
    lines = [line for line in ax.lines if np.array_equal(line.get_ydata(), [0, 1])]
    dashes = {str(line._unscaled_dash_pattern) for line in lines}  # type: ignore[attr-defined]
    assert len(dashes) == len(events)
    assert list(bands(ax)) == []  # at once
    assert {f"event: {kind}" for kind in [*LOOKS, "earthquake"]} <= set(legend(figure))


def test_every_flight_has_its_numbers_and_the_legend_words_that_hold_for_all(make_log, make_event, happening):
    log = make_log(slide=2.0)
    pushed, other = (
        happening(log, make_event()),
        happening(log, make_event(time=4.0), make_event("gain", 5.0)),
    )
    same = cog_tracking({"a": run_of(pushed), "b": run_of(pushed)})
    assert numbers(same) == ["1", "1"]
    assert "1: 2 N on link4" in legend(same)
    apart = cog_tracking({"a": run_of(pushed), "b": run_of(other), "c": run_of(log)})
    assert numbers(apart) == ["1", "1", "2"]
    assert [text for text in legend(apart) if "event" in text] == ["event: push", "event: gain"]


def test_long_words_are_left_to_the_reports_list(make_log, make_event, happening):
    log = happening(
        make_log(slide=2.0), make_event("surface", 2.0, 0.2, "surface position to " + 9 * "1.234 ")
    )
    assert [str(sign.get_label()) for sign in event_signs({"a": run_of(log)})] == ["event: surface"]


def test_marks_that_would_lie_on_each_other_are_one(make_log, make_event, happening):
    drag = [make_event(time=2.0 + 0.033 * k, duration=0.033, words=f"{k} N") for k in range(30)]
    figure = contact_direction({"a": run_of(happening(make_log(slide=2.0), *drag, make_event("gain", 5.0)))})
    style.png(figure)
    above = panels(figure)[0]
    counted = [[int(k) for k in text.split("\N{EN DASH}")] for text in numbers(figure)]
    assert [first for first, *_ in counted[1:]] == [numbers[-1] + 1 for numbers in counted[:-1]]
    assert (counted[0][0], counted[-1]) == (1, [31])
    edges = np.array([text.get_window_extent().intervalx for text in above.texts])
    assert (edges[1:, 0] > edges[:-1, 1]).all()
    assert 2 < len(begins(above)) < 15
    covered = np.array(list(bands(above)))[:-1]
    assert covered.min() == 2.0
    assert np.diff(covered, axis=1).sum() == pytest.approx(30 * 0.033)


def test_a_mark_at_the_end_is_not_cut_off(make_log, make_event, happening):
    log = make_log(slide=2.0)
    end = float(log.time.values[-1])
    late = happening(log, *(make_event(time=end - 0.02 * k) for k in range(12)))
    figure = cog_tracking({"a": run_of(late)})
    style.png(figure)
    (text,) = panels(figure)[0].texts
    assert text.get_window_extent().x1 <= panels(figure)[0].get_window_extent().x1


def test_a_replay_begins_where_its_record_does(make_log, make_event, happening):
    log = happening(make_log(slide=2.0), make_event(time=4.0, duration=0.5))
    part = log.isel(time=slice(200, None))
    begin = float(part.time.values[0])
    again = part.assign_coords(time=part.time - begin)
    figure = replayed_figures(run_of(part), run_of(again))["estimates"]
    assert begins(panels(figure)[0])[0][0] == pytest.approx(4.0)
