"""The mission's clock, the one interpolation, and what lies ahead."""

from typing import Any

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skylimb.base.packing import Layout
from skylimb.control.missions.clock import (
    Clock,
    limited_pace,
    next_clock,
    reference_between,
    start_of_mission,
)
from skylimb.control.missions.frame import contact_frame
from skylimb.control.missions.mission import PHASES, Mission
from skylimb.control.missions.reference import ACCELERATIONS, RATES, Reference, zero_reference
from skylimb.control.missions.table import Window, reference_table, window_of

LAYOUT = Layout(zero_reference(2, 1))
TICKS = 12


def numbered() -> Mission:
    """A mission whose every number tells its tick."""
    zeros, k = zero_reference(2, 1)._asdict(), np.arange(float(TICKS))
    zeros.pop("ahead")
    rows: dict[str, Any] = {
        name: 100.0 * index + (k if np.ndim(entry) == 0 else np.repeat(k[:, None], len(entry), axis=1))
        for index, (name, entry) in enumerate(zeros.items())
    }
    return Mission(
        times=0.01 * k,
        period=0.01,
        reference=Reference(**rows),
        phase=np.arange(TICKS) % len(PHASES),
        frame=contact_frame((1.0, 0.0, 0.0)),
        tip_path=np.repeat(k[:, None], 3, axis=1),
        contact=True,
        patience=2.5,
    )


def test_the_clock_begins_at_the_missions_own_pace() -> None:
    assert start_of_mission() == (0.0, 1.0)


@given(st.floats(0.0, 50.0), st.floats(0.0, 100.0))
def test_the_clock_goes_on_by_its_pace(ticks: float, pace: float) -> None:
    assert next_clock(Clock(ticks, 1.0), pace) == (pytest.approx(ticks + pace), pytest.approx(pace))


@pytest.mark.parametrize(
    ("pace", "limited"), [(-1.0, 0.0), (np.nan, 0.0), (1e9, 100.0), (np.inf, 100.0), (0.3, 0.3), (99.0, 99.0)]
)
def test_no_pace_derails_the_clock(pace: float, limited: float) -> None:
    assert float(limited_pace(pace)) == limited
    assert float(next_clock(Clock(3.0, 1.0), pace).ticks) == 3.0 + limited


def test_between_two_rows_entries_are_linear_and_rates_go_with_the_pace() -> None:
    mission = numbered()
    here, there = mission.row(3), mission.row(4)
    found = reference_between(here, there, Clock(3.25, 0.5))
    for name in Reference._fields[:-1]:
        factor = 0.5 if name in RATES else 0.25 if name in ACCELERATIONS else 1.0
        wanted = factor * (0.75 * getattr(here, name) + 0.25 * getattr(there, name))
        np.testing.assert_allclose(getattr(found, name), wanted, err_msg=name)


def test_the_rates_are_those_of_velocity_and_acceleration() -> None:
    assert set(RATES) == {"velocity", "tip_velocity"}
    assert set(ACCELERATIONS) == {"acceleration", "tip_acceleration"}


def test_along_a_clock_the_mission_is_what_each_tick_was_sent() -> None:
    mission = numbered()
    clock = Clock(np.array([0.0, 0.5, 1.75, 10.5, 11.0]), np.array([1.0, 0.5, 1.25, 0.4, 0.5]))
    flown = mission.along(clock)
    np.testing.assert_allclose(flown.times, 0.01 * np.arange(5))
    np.testing.assert_array_equal(flown.phase, [0, 0, 1, 2, 3])
    np.testing.assert_allclose(flown.tip_path[:, 1], clock.ticks)
    for k in range(5):
        sent = mission.at(Clock(float(clock.ticks[k]), float(clock.pace[k])))
        for name in Reference._fields[:-1]:
            np.testing.assert_allclose(getattr(flown.reference, name)[k], getattr(sent, name), err_msg=name)


def test_a_preview_shows_what_comes_and_stops_at_the_end() -> None:
    mission = numbered()
    reference = mission.at(Clock(8.0, 1.0), (1, 2, 9))
    assert [float(ahead.heading) - 300.0 for ahead in reference.ahead] == [9.0, 10.0, 11.0]
    assert float(reference.heading) == 308.0
    assert reference.ahead[0].ahead == ()
    between = mission.at(Clock(8.5, 0.5), (1, 9))
    assert [float(ahead.heading) - 300.0 for ahead in between.ahead] == [9.5, 11.0]
    assert mission.at(Clock(25.0, 1.0)).heading == 311.0


@pytest.mark.parametrize("paced", [False, True])
@pytest.mark.parametrize("preview", [(), (1,), (2, 5)])
@pytest.mark.parametrize("ticks", [0.0, 3.0, 3.25, 10.0, 11.0])
def test_a_window_of_packed_rows_gives_the_same_reference(
    paced: bool, preview: tuple[int, ...], ticks: float
) -> None:
    mission, window = numbered(), Window(preview, paced)
    if not paced and ticks % 1.0:
        pytest.skip("a clock that goes with the flight stands on whole ticks")
    clock = Clock(ticks, 0.5 if ticks % 1.0 else 1.0)
    table = reference_table(mission, LAYOUT, window)
    assert window.rows == 1 + max((0, *preview)) + paced
    assert len(table) == TICKS + max(window.rows - 1, 1)
    flat = table[int(ticks) : int(ticks) + window.rows].ravel()
    assert len(flat) == window.rows * LAYOUT.size
    wanted = mission.at(clock, preview)
    found = window.read(LAYOUT, flat, clock)
    # The same on symbols, as the compiled tick reads it.
    x, t, p = ca.SX.sym("x", len(flat)), ca.SX.sym("t"), ca.SX.sym("p")
    symbolic = window.read(LAYOUT, x, Clock(t, p))
    evaluate = ca.Function("f", [x, t, p], [symbolic.position, *(a.tip_velocity for a in symbolic.ahead)])
    numbers = evaluate.call([flat, clock.ticks, clock.pace])
    np.testing.assert_allclose(np.ravel(numbers[0]), wanted.position)
    assert len(found.ahead) == len(wanted.ahead) == len(preview)
    for mine, theirs, number in zip(found.ahead, wanted.ahead, numbers[1:], strict=True):
        np.testing.assert_allclose(mine.tip_velocity, theirs.tip_velocity)
        np.testing.assert_allclose(np.ravel(number), theirs.tip_velocity)
        np.testing.assert_allclose(mine.position, theirs.position)
    for name in Reference._fields[:-1]:
        np.testing.assert_allclose(getattr(found, name), getattr(wanted, name), err_msg=name)


def test_previews_in_seconds_become_ticks() -> None:
    assert window_of((0.05, 0.1, 0.52), True, 0.005) == Window((10, 20, 104), True)
    assert window_of((), False, 0.005).rows == 1


def test_a_table_is_shared_and_cannot_be_changed() -> None:
    mission = numbered()
    table = reference_table(mission, LAYOUT, Window())
    assert reference_table(mission, LAYOUT, Window()) is table
    with pytest.raises(ValueError, match="read-only"):
        table[0, 0] = 1.0


def test_a_paced_flight_may_take_longer() -> None:
    mission = numbered()
    assert mission.period == pytest.approx(0.01)
    np.testing.assert_array_equal(mission.flight_times(False), mission.times)
    np.testing.assert_allclose(mission.flight_times(True), 0.01 * np.arange(30))


def test_ticks_of_phases() -> None:
    mission = numbered()
    np.testing.assert_array_equal(np.flatnonzero(mission.in_phase("tare")), [1, 9])
    np.testing.assert_array_equal(np.flatnonzero(mission.in_phase("hover", "lift")), [0, 7, 8])
    assert float(mission.first.heading) == 300.0


def test_the_heading_of_a_contact_axis() -> None:
    assert contact_frame((0.0, 1.0, 0.0)).heading == pytest.approx(np.pi / 2)
    assert contact_frame((np.sqrt(0.5), 0.0, np.sqrt(0.5))).heading == 0.0
    assert contact_frame((0.0, 0.0, 1.0)).heading == 0.0
    frame = contact_frame((0.0, 1.0, 0.0))
    np.testing.assert_allclose(np.cross(frame.contact, frame.sliding_u), frame.sliding_v, atol=1e-12)


def test_a_flight_of_one_tick_has_the_missions_period() -> None:
    flown = numbered().along(Clock(np.zeros(1), np.ones(1)))
    assert len(flown.times) == 1
    assert flown.period == 0.01
