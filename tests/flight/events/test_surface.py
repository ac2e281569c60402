"""A surface that changes in flight: the same in every driver, and told by the record."""

import dataclasses
from typing import Any

import numpy as np
import pytest

from short_flights import CIRCLE
from skylimb.base.errors import ConfigError
from skylimb.flight.drivers.native import fly_native
from skylimb.flight.events import SurfaceChange
from skylimb.flight.events.surface import surface_table
from skylimb.flight.experiments.experiment import experiment_from_mapping, load_experiment
from skylimb.flight.flying import begin_loop, fly_here
from skylimb.flight.simulated_run import scored_run
from skylimb.flight.takeoff import take_off
from skylimb.simulation.surfaces import surface_from_mapping

BOARD = [
    {"time": 2.3, "position": [1.497, 0.0, 1.2], "slope": -0.3, "pitch": 0.02},
    {"time": 2.4, "friction": 0.15, "stiffness": 3000.0, "duration": 0.3},
    {"time": 2.45, "slope": -0.31, "duration": 0.0},
    {"time": 3.2, "present": False},
    {"time": 3.4, "present": True, "position": [1.5, 0.0, 1.2]},
]
CURVED = [
    {"time": 0.0, "roll": 0.02, "duration": 0.0},
    {"time": 3.0, "position": [1.49, 0.0, 1.2], "pitch": 0.02},
]
GONE = [{"time": 2.6, "present": False}, {"time": 3.2, "present": True}]


def made(experiment="paper", controller="hybrid", changes=(), **settings):
    events = [{"kind": "surface", **change} for change in changes]
    set = {**(CIRCLE if experiment == "paper" else {}), **settings, "events": events}
    (takeoff,) = take_off(experiment, (controller,), 1, set)
    return takeoff


@pytest.mark.parametrize(
    ("experiment", "controller", "changes", "settings"),
    [
        ("paper", "hybrid", BOARD, {}),
        ("paper", "following", BOARD, {}),
        ("sine_gentle", "hybrid", CURVED, {**CIRCLE, "surface.slope": 0.0}),
        ("friction_patches", "hybrid", GONE, CIRCLE),
        ("paper", "pid", GONE, {"surface.sway_amplitude": 0.01}),
    ],
)
def test_compiled_and_native_flights_are_the_same_to_the_bit(experiment, controller, changes, settings):
    takeoff = made(experiment, controller, changes, **settings)
    before = [getattr(takeoff.plant.model, name).copy() for name in NUMBERS]
    here, native = fly_here(takeoff), fly_native([takeoff])[0]
    assert (here.ticks, here.cause) == (native.ticks, native.cause)
    assert np.array_equal(here.signals, native.signals, equal_nan=True)
    without = fly_here(made(experiment, controller, (), **settings))
    assert not np.array_equal(here.signals, without.signals[: here.ticks], equal_nan=True)
    if experiment != "friction_patches":  # whose friction is written into the model in any case
        for name, old in zip(NUMBERS, before, strict=True):
            assert np.array_equal(getattr(takeoff.plant.model, name), old), name


NUMBERS = ("geom_pos", "geom_quat", "pair_friction", "pair_solref", "pair_gap", "geom_sameframe")


def test_a_flight_without_changes_writes_nothing_into_its_model():
    takeoff = made()
    assert takeoff.surface_table is None
    driver: Any = begin_loop(takeoff).driver
    assert driver._model is takeoff.plant.model


def test_a_change_that_comes_to_what_is_there_changes_no_bit():
    surface = load_experiment("paper").surface
    same = [
        {"time": 0.5, "friction": surface.friction},
        {"time": 0.9, "slope": surface.slope, "present": True},
    ]
    here, without = fly_here(made(changes=same)), fly_here(made())
    assert np.array_equal(here.signals, without.signals, equal_nan=True)


@pytest.fixture(scope="module")
def run():
    takeoff = made(changes=BOARD)
    return scored_run(takeoff, fly_here(takeoff))


def between(log, first, last):
    return log.sel(time=slice(first, last))


def test_the_record_knows_where_the_surface_was(run):
    log = run.log
    pressed = between(log, 2.8, 3.19)
    assert float(pressed.contact.mean()) > 0.9
    assert (abs(pressed.surface_gap.values) < 0.004).all()
    normal = pressed.contact_normal.values[-1]
    assert normal @ run.log.contact_normal.values[0] < 0.9999
    # The place of touch lies on the plane that the record tells.
    away = pressed.contact_point.values - pressed.surface_position.values
    assert np.nanmax(abs(np.sum(away[1:] * pressed.contact_normal.values[:-1], axis=1))) < 0.003
    assert (between(log, 0.0, 2.3).surface_position.values == [1.5, 0.0, 1.2]).all()
    assert float(log.surface_friction[-1]) == 0.15
    assert float(log.surface_stiffness[-1]) == 3000.0


def test_a_surface_that_is_taken_away_touches_nothing_and_has_no_gap(run):
    gone = between(run.log, 3.21, 3.395)
    assert not gone.contact.any()
    assert np.isnan(between(run.log, 3.2, 3.395).surface_gap).all()
    assert not gone.surface_present.any()
    assert np.isfinite(between(run.log, 3.4, 9.0).surface_gap).all()


def test_friction_and_stiffness_are_those_of_the_pair():
    slippery = made(changes=[{"time": 2.5, "friction": 0.0, "duration": 0.0}])
    log = scored_run(slippery, fly_here(slippery)).log
    sliding = between(log, 2.6, 4.0)
    assert np.abs(sliding.contact_force_tangential).max() < 1e-3
    assert np.abs(between(log, 2.0, 2.4).contact_force_tangential).max() > 0.05
    soft = made(changes=[{"time": 2.5, "stiffness": 500.0, "duration": 0.0}])
    pressed = between(scored_run(soft, fly_here(soft)).log, 3.0, 3.5)
    assert float(-pressed.surface_gap.mean()) == pytest.approx(
        float(pressed.contact_force_normal.mean()) / 500.0, rel=0.05
    )


def test_the_run_says_that_figures_draw_the_surface_where_it_was(run):
    assert any("moved or taken away in flight, from t = 2.3 s on" in note for note in run.notes)
    quiet = made(changes=[{"time": 1.3, "friction": 0.2}])
    assert scored_run(quiet, fly_here(quiet)).notes == ()


@pytest.mark.parametrize(
    ("experiment", "change", "settings", "words"),
    [
        ("paper", {"time": 1.0}, {}, "changes nothing"),
        ("paper", {"time": 1.0, "slope": 0.1}, {"surface.sway_amplitude": 0.01}, "cannot be moved or tilted"),
        ("friction_patches", {"time": 1.0, "friction": 0.1}, {}, "friction cannot change .* friction_map"),
        ("paper", {"time": 1.0, "friction": 0.1}, {"surface.static_ratio": 1.5}, "static_ratio"),
        ("paper", {"time": 1.0, "stiffness": 9e5}, {}, "too stiff"),
        ("paper", {"time": 1.0, "friction": -0.1}, {}, "outside of 0"),
    ],
)
def test_what_cannot_be_is_refused(experiment, change, settings, words):
    with pytest.raises(ConfigError, match=words):
        made(experiment, changes=[change], **settings)


def test_a_change_begins_at_what_the_surface_is_and_ends_at_its_value():
    surface = surface_from_mapping({"position": [1.0, 0.0, 1.0], "slope": 0.1})
    times = np.arange(400) * 0.005
    changes = [
        SurfaceChange(time=0.5, slope=0.3, friction=0.7, duration=0.4),
        SurfaceChange(time=0.7, slope=-0.1, duration=0.2),
        SurfaceChange(time=1.0, present=False),
    ]
    table = surface_table(changes, surface, times)
    slope, friction, present = table[:, 3], table[:, 6], table[:, 8]
    assert (slope[:101] == 0.1).all()
    assert slope[140] == pytest.approx(0.2)  # half way in time and value, where the second begins
    assert slope[141] < slope[140] < slope[139] + 0.01
    assert (slope[180:] == -0.1).all()
    assert (friction[180:] == 0.7).all()
    assert friction[150] < 0.7
    assert (present[:200] == 1.0).all()
    assert not present[200:].any()
    assert (table[:, :3] == [1.0, 0.0, 1.0]).all()
    mixed = surface_table(changes[::-1], surface, times)
    assert np.array_equal(table, mixed)


def test_changes_survive_the_way_through_a_file():
    events = [{"kind": "surface", **change} for change in BOARD]
    experiment = load_experiment("paper", {"events": events})
    again = experiment_from_mapping(experiment.to_mapping(), "again")
    assert again.events == experiment.events
    assert dataclasses.replace(experiment, events=()).to_mapping().get("events") is None
