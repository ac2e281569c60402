"""A live flight is the flight that its experiment describes, whatever was done on the way."""

import dataclasses

import numpy as np
import pytest

from of_kind import of_kind
from skylimb.apps.studio.changes import with_events, with_gain, with_push
from skylimb.apps.studio.live_flight import LiveFlight
from skylimb.base.errors import ConfigError
from skylimb.flight.drivers.native import fly_native
from skylimb.flight.events import Push
from skylimb.flight.experiments.experiment import Experiment
from skylimb.flight.flying import fly_here
from skylimb.flight.takeoff import Takeoff, prepare, take_off


def flown_anew(flight: LiveFlight) -> Takeoff:
    """The take-off that a live flight's experiment describes, made from scratch."""
    takeoff = flight.takeoff
    return prepare(flight.experiment, takeoff.robot, takeoff.controller)


def branch(flight: LiveFlight, experiment: Experiment) -> None:
    flight.come_to(flight.takeoff.changed(experiment), flight.ticks)


def to_tick(flight: LiveFlight, tick: int) -> None:
    while flight.ticks < tick:
        assert flight.tick()


PUSH = Push(0.75, duration=100.0, force=(0.5, 2.0, 0.0), link="link4", point=(0.1, 0.0, 0.0))
KEY = "translation.damping_ratio"


def edited(takeoff: Takeoff) -> LiveFlight:
    """A flight that was pushed, changed, rewound into the push, and pushed otherwise from there."""
    flight = LiveFlight(takeoff)
    to_tick(flight, 100)
    branch(flight, with_gain(flight.experiment, flight.time, KEY, (1.4, 1.3, 1.2)))
    to_tick(flight, 150)
    branch(flight, with_events(flight.experiment, PUSH))
    to_tick(flight, 300)
    branch(flight, with_push(flight.experiment, flight.first, flight.time))
    to_tick(flight, 330)
    flight.rewind(230)
    assert flight.ticks == 230
    assert of_kind(flight.experiment, Push) == [dataclasses.replace(PUSH, duration=0.4)]
    branch(flight, with_gain(flight.experiment, flight.time, KEY, (1.1, 1.2, 1.3)))
    to_tick(flight, 420)
    return flight


@pytest.mark.parametrize("controller", ["hybrid", "following"])
def test_an_edited_flight_is_the_flight_of_its_experiment_to_the_bit(short, controller):
    (takeoff,) = take_off("paper", (controller,), 3, short)
    flight = edited(takeoff)
    here, native = fly_here(flown_anew(flight)), fly_native([flown_anew(flight)])[0]
    assert np.array_equal(here.signals[:420], flight.recent, equal_nan=True)
    assert np.array_equal(native.signals[:420], flight.recent, equal_nan=True)


def test_a_flight_that_was_stopped_is_repeated_with_the_time_of_its_stop(short):
    (takeoff,) = take_off("paper", ("hybrid",), 0, short)
    flight = LiveFlight(takeoff)
    to_tick(flight, 137)
    stopped = prepare(*_stopped(flight))
    again, native = fly_here(stopped), fly_native([stopped])[0]
    assert again.ticks == native.ticks == 137
    assert again.cause == native.cause == flight.flight().cause
    assert "stopped from outside at t = 0.685 s" in again.cause
    assert np.array_equal(again.signals, flight.recent, equal_nan=True)


def _stopped(flight: LiveFlight):
    experiment = dataclasses.replace(flight.experiment, stop_at=flight.time)
    return experiment, flight.takeoff.robot, flight.takeoff.controller


def test_a_branch_that_cannot_be_changes_nothing(short):
    (takeoff,) = take_off("paper", ("hybrid",), 0, short)
    flight = LiveFlight(takeoff)
    before = flight.experiment
    with pytest.raises(ConfigError, match="unknown gain"):
        branch(flight, with_gain(before, flight.time, "translation.dampin_ratio", 1.0))
    with pytest.raises(ConfigError, match="link of a push"):
        branch(flight, with_events(before, Push(0.0, duration=1.0, force=(1.0, 0.0, 0.0), link="leg")))
    assert flight.experiment is before
    assert flight.tick()


def test_a_flight_leaves_the_plant_of_its_take_off_alone(short):
    (takeoff,) = take_off("friction_patches", ("hybrid",), 0, {})
    friction = takeoff.plant.model.pair_friction.copy()
    flight = LiveFlight(takeoff)
    to_tick(flight, 40)
    assert np.array_equal(takeoff.plant.model.pair_friction, friction)
    assert not np.array_equal(flight._plant.model.pair_friction, friction)


def test_a_rewound_flight_that_ended_goes_on(short):
    (takeoff,) = take_off("paper", ("hybrid",), 0, short)
    flight = LiveFlight(takeoff)
    while flight.tick():
        pass
    assert flight.over
    assert flight.flight().cause == ""
    end, rows = flight.ticks, flight.recent.copy()
    flight.rewind(200)
    assert not flight.over
    while flight.tick():
        pass
    assert flight.ticks == end
    assert np.array_equal(flight.recent, rows, equal_nan=True)
