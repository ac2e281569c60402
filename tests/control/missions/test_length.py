"""A mission that would not fit into memory is refused before anything is made for it."""

import re
import tracemalloc
from pathlib import Path

import pytest

from skylimb.base.errors import ConfigError
from skylimb.control.missions.length import MOST_TICKS, tick_count
from skylimb.flight.takeoff import take_off


def test_ticks_are_counted_with_both_ends_and_bounded() -> None:
    assert tick_count(1.0, 0.005) == 201
    assert tick_count((MOST_TICKS - 1) * 0.005, 0.005) == MOST_TICKS
    for duration in (MOST_TICKS * 0.005, 1e300, float("inf"), float("nan")):
        with pytest.raises(ConfigError, match="500000 ticks at most, here 2500 s"):
            tick_count(duration, 0.005)


LONG = [
    ("paper", {"trajectory.laps": 1000.0, "trajectory.period": 3600.0}, "most of it its slide"),
    ("paper", {"approach.speed": 1e-9}, "most of it its approach"),
    ("paper", {"approach.retreat_speed": 1e-300}, "most of it its retreat"),
    ("paper", {"trajectory.shape": "line", "trajectory.speed": 0.001, "controller_rate": 1e3}, "here 500 s"),
    ("push", {"trajectory.duration": 36000.0}, "3.601e+04 s"),
    ("free_flight", {"posture.hold": 3600.0}, "posture.waypoints: the way through them takes 1.08"),
    ("paper", {"trajectory.shape": "drawing", "trajectory.text": "a" * 501}, "501 letters, more than 500"),
]  # fmt: skip


@pytest.mark.parametrize(("experiment", "changes", "words"), LONG)
def test_what_is_too_long_is_refused_before_it_is_made(experiment: str, changes: dict, words: str) -> None:
    take_off("push", ["hybrid"])
    tracemalloc.start()
    try:
        with pytest.raises(ConfigError, match=re.escape(words)):
            take_off(experiment, ["hybrid"], set=changes)
        assert tracemalloc.get_traced_memory()[1] < 50e6
    finally:
        tracemalloc.stop()


def test_a_flight_that_may_wait_is_bounded_with_its_patience() -> None:
    changes = {"trajectory.period": 300.0, "phases.patience": 20.0}
    assert take_off("paper", ["hybrid"], set=changes)  # keeps to the mission's own clock
    with pytest.raises(ConfigError, match=r"20 times as long with phases\.patience"):
        take_off("paper", ["following"], set=changes)


@pytest.mark.parametrize(
    ("shapes", "words"),
    [
        ("".join(f'<path d="M{i} 0 l0 9" stroke="red"/>' for i in range(1001)), "1001 strokes, more than"),
        (f'<path d="M0 0 {"L9 9 L0 9 " * 10001}" stroke="red"/>', "points, more than 20000"),
        ("<!-- " + "x" * 4_000_000 + " -->", "more than 4 MB"),
    ],
)  # fmt: skip
def test_a_drawing_has_so_many_strokes_and_points_at_most(tmp_path: Path, shapes: str, words: str) -> None:
    file = tmp_path / "large.svg"
    file.write_text(f'<svg xmlns="http://www.w3.org/2000/svg">{shapes}</svg>')
    with pytest.raises(ConfigError, match=re.escape(words)):
        take_off("paper", ["hybrid"], set={"trajectory.shape": "drawing", "trajectory.file": str(file)})
