"""A plan with its plant: refused where only the plant knows, shared where nothing has changed."""

import dataclasses
import math

import numpy as np
import pytest

from short_flights import HOLD
from skylimb.base.errors import ConfigError
from skylimb.flight.events import EventContext, GainChange, Push
from skylimb.flight.loading import plan_flights
from skylimb.flight.takeoff import take_off


def test_a_robot_that_would_start_inside_of_the_surface_as_its_servos_give_way_is_refused() -> None:
    """The servos give way by 3 mm upward before take-off, so that a tip 1 mm below the ceiling is in it."""
    near = {"approach.standoff": 0.001}
    assert plan_flights("ceiling", ("hybrid",), set=near)
    with pytest.raises(ConfigError, match=r"intersects hydrus_xi_quad_mast at the start: 1\.9\d* mm deep"):
        take_off("ceiling", ("hybrid",), set=near)
    assert take_off("ceiling", ("hybrid",), set={"approach.standoff": 0.004})


def test_a_robot_whose_posture_reaches_into_the_surface_is_refused_before_there_is_a_plant() -> None:
    with pytest.raises(ConfigError, match="intersects hydrus_xi_quad at the start"):
        plan_flights("paper", ("hybrid",), set={"approach.standoff": 0.0})


def test_what_a_change_does_not_touch_is_shared() -> None:
    (takeoff,) = take_off("paper", ("hybrid",), 0, HOLD)
    experiment = takeoff.experiment
    pushed = takeoff.changed(dataclasses.replace(experiment, events=(Push(0.2, duration=0.1),)))
    assert pushed.experiment.events == (Push(0.2, duration=0.1),)
    assert takeoff.experiment.events == ()
    for shared in ("mission", "plant", "start", "tick", "fixed_rows", "times"):
        assert getattr(pushed, shared) is getattr(takeoff, shared), shared
    noisy = takeoff.changed(dataclasses.replace(experiment, seed=1))
    assert noisy.plant is takeoff.plant
    assert not np.array_equal(noisy.rows.ticks, takeoff.rows.ticks)
    with pytest.raises(ConfigError, match="after the flight's end"):
        takeoff.changed(dataclasses.replace(experiment, events=(Push(99.0, duration=0.1),)))


def test_a_flight_is_stopped_at_the_time_that_the_experiment_names() -> None:
    (takeoff,) = take_off("paper", ("hybrid",), set={**HOLD, "stop_at": 0.5})
    assert takeoff.count == len(takeoff.rows) == 100
    assert len(takeoff.fixed_rows) == len(takeoff.times) > 100
    assert math.isclose(takeoff.times[1], takeoff.period)


def test_events_that_were_checked_are_not_asked_again_until_what_they_act_on_changes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A live flight has an event for each touch of a slider; the hundredth costs no more than the first."""
    gains = tuple(GainChange(0.1 * n, "allocation.leak.cutoff", 1.0 + 0.01 * n) for n in range(1, 5))
    (takeoff,) = take_off("paper", ("hybrid",), 0, HOLD)
    takeoff = takeoff.changed(dataclasses.replace(takeoff.experiment, events=gains[:3]))
    asked: list[GainChange] = []
    real = GainChange.require

    def require(event: GainChange, context: EventContext) -> None:
        asked.append(event)
        real(event, context)

    monkeypatch.setattr(GainChange, "require", require)
    more = takeoff.changed(dataclasses.replace(takeoff.experiment, events=gains))
    assert set(asked) == {gains[3]}
    bad = dataclasses.replace(gains[3], key="translation.mass_ratio")
    with pytest.raises(ConfigError, match="unknown gain"):
        more.changed(dataclasses.replace(more.experiment, events=(*gains, bad)))
    asked.clear()
    surface = dataclasses.replace(more.experiment.surface, friction=0.1)
    more.changed(dataclasses.replace(more.experiment, surface=surface))
    assert set(asked) == set(gains)
