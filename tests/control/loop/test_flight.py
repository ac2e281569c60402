"""The raw record of a flight, and the mission as it was flown."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from skylimb.base.errors import UserCodeError
from skylimb.base.packing import Layout
from skylimb.base.signals import require_free
from skylimb.control.loop.flight import (
    Flight,
    flown_mission,
    mission_clock,
    mission_signals,
    mission_ticks,
    unfinished,
)
from skylimb.control.loop.terminations import Terminations, find_loss, watched_columns
from skylimb.control.missions.frame import contact_frame
from skylimb.control.missions.mission import Mission
from skylimb.control.missions.reference import Reference, zero_reference

DT = 0.01
SIMULATED: Layout[dict[str, Any]] = Layout(
    {
        "configuration": np.zeros(9),
        "configuration_velocity": np.zeros(8),
        "thrusts_command": np.zeros(2),
        "joint_angles_command": np.zeros(1),
        "contact_force": np.zeros(3),
        "own": 0.0,
    }
)
PACED: Layout[dict[str, Any]] = Layout({"mission_time": 0.0, "pace": 0.0})


def mission(ticks: int = 40) -> Mission:
    zeros, k = zero_reference(1, 1)._asdict(), np.arange(float(ticks))
    zeros.pop("ahead")
    rows: dict[str, Any] = {name: np.zeros((ticks, *np.shape(entry))) for name, entry in zeros.items()}
    rows["position"] = np.column_stack([k, 0.0 * k, 1.0 + 0.0 * k])
    return Mission(
        DT * k,
        DT,
        Reference(**rows),
        np.zeros(ticks, int),
        contact_frame((1.0, 0.0, 0.0)),
        rows["position"],
        False,
        2.0,
    )


def paced(paces: list[float]) -> Flight:
    """A flight whose controller set these paces: each one is that of the next tick."""
    times = DT * np.concatenate([[0.0], np.cumsum(paces)[:-1]])
    return Flight(np.column_stack([times, paces]), PACED, len(paces), "")


def test_a_flight_without_a_pace_goes_with_the_mission() -> None:
    flight = Flight(np.zeros((7, SIMULATED.size)), SIMULATED, 7, "")
    clock = mission_clock(mission(), flight)
    np.testing.assert_array_equal(clock.ticks, np.arange(7.0))
    np.testing.assert_array_equal(clock.pace, np.ones(7))
    np.testing.assert_array_equal(mission_ticks(mission(), flight, 4), [4.0, 5.0, 6.0])
    whole = mission()
    assert flown_mission(whole, flight) is whole


def test_a_flights_own_clock_is_read_from_its_signals() -> None:
    flight = paced([0.5, 0.25, 1.0, 7.0, 1e9, 1.0])
    clock = mission_clock(mission(), flight)
    np.testing.assert_allclose(clock.ticks[:5], [0.0, 0.5, 0.75, 1.75, 8.75])
    np.testing.assert_array_equal(clock.pace, [1.0, 0.5, 0.25, 1.0, 7.0, 100.0])
    np.testing.assert_allclose(mission_ticks(mission(), flight, 2)[:3], [0.75, 1.75, 8.75])
    assert flown_mission(mission(), paced([0.5] * 9)).reference.position[5, 0] == pytest.approx(2.5)


def test_a_clock_on_a_whole_tick_stays_there_though_seconds_are_rounded() -> None:
    paces = [1.0] * 39
    clock = mission_clock(mission(), paced(paces))
    np.testing.assert_array_equal(clock.ticks, np.arange(39.0))


def test_a_mission_that_was_held_back_is_not_finished() -> None:
    every = len(mission().flight_times(True))
    done, short = paced([1.0] * 40), paced([0.25] * every)
    assert unfinished(mission(), done).cause == ""
    assert unfinished(mission(), short).cause == (
        f"the controller held the mission back, which was at {0.0025 * (every - 1):.3f} s of "
        "0.390 s when 2 times its time were over"
    )
    stopped = unfinished(mission(), paced([0.5] * 40)).cause
    assert stopped == "stopped from outside at t = 0.400 s, before the mission's end"
    free = Flight(np.zeros((40, SIMULATED.size)), SIMULATED, 40, "")
    assert unfinished(mission(), free) is free


def simulated(ticks: int = 30) -> np.ndarray:
    rows = np.zeros((ticks, SIMULATED.size))
    rows[:, 0], rows[:, 2], rows[:, 3] = np.arange(ticks), 1.0, 1.0
    return rows


def test_a_simulated_flight_is_judged_by_its_configuration() -> None:
    assert find_loss(Flight(simulated(), SIMULATED, 30, ""), mission(), Terminations()) is None
    for column, value, cause in (
        (1, 2.5, "lost position"),
        (2, 0.0, "hit the floor"),
        (4, 0.6, "lost attitude"),
        (5, 0.6, "lost attitude"),
        (20, np.inf, "diverged"),
    ):
        rows = simulated()
        rows[17:, column] = value
        found = find_loss(Flight(rows, SIMULATED, 30, ""), mission(), Terminations())
        assert found is not None
        assert found[0] == 17
        assert found[1].startswith(cause)
        assert find_loss(Flight(rows, SIMULATED, 17, ""), mission(), Terminations()) is None
    turned = simulated()
    turned[:, 6] = 0.9  # about the vertical: no tilt
    assert find_loss(Flight(turned, SIMULATED, 30, ""), mission(), Terminations()) is None


def test_of_two_reasons_the_first_tick_counts_and_an_earlier_one_is_not_looked_at() -> None:
    rows = simulated()
    rows[12:, 2], rows[9:, 4] = 0.0, 0.6
    flight = Flight(rows, SIMULATED, 30, "")
    assert find_loss(flight, mission(), Terminations()) == (
        9,
        "lost attitude: tilt above 1 rad at t = 0.090 s",
    )
    assert find_loss(flight, mission(), Terminations(), 20) == (
        20,
        "lost attitude: tilt above 1 rad at t = 0.200 s",
    )


def test_a_controllers_own_signals_may_stay_open() -> None:
    rows = simulated()
    rows[:, SIMULATED.slices["own"]] = np.nan
    assert find_loss(Flight(rows, SIMULATED, 30, ""), mission(), Terminations()) is None
    assert len(watched_columns(SIMULATED)) == SIMULATED.size - 1


def test_signals_have_their_shape() -> None:
    flight = Flight(simulated(), SIMULATED, 12, "")
    assert flight.signal("own").shape == (12,)
    assert flight.signal("configuration").shape == (12, 9)
    assert flight.has("own")
    assert not flight.has("nothing")


def test_the_commanded_force_is_told_at_the_missions_own_clock() -> None:
    whole = mission()
    assert "contact_force_commanded" not in mission_signals(whole, 5)
    force = np.maximum(np.arange(40.0) - 2.0, 0.0)
    whole = replace(whole, reference=whole.reference._replace(force=force))
    flight = paced([0.5] * 8)
    told = mission_signals(flown_mission(whole, flight), flight.ticks)["contact_force_commanded"]
    np.testing.assert_allclose(told, [np.nan] * 5 + [0.5, 1.0, 1.5])


def test_no_law_records_the_commanded_force() -> None:
    require_free({"contact_force_reference": 1.0}, "a law")
    with pytest.raises(UserCodeError, match="contact_force_commanded"):
        require_free({"contact_force_commanded": 1.0}, "a law")
