"""A valve: one geometry to physics and analysis, turned up to its stop, the same with every driver."""

import dataclasses
import json

import numpy as np
import pytest

import skylimb
from skylimb.analysis.viewer.payload import viewer_payload
from skylimb.base.errors import ConfigError
from skylimb.flight.drivers.native import fly_native
from skylimb.flight.flying import fly_here
from skylimb.flight.takeoff import take_off
from skylimb.simulation.surface_at import turned_valve
from skylimb.simulation.surfaces import Valve, surface_from_mapping
from skylimb.simulation.surfaces.geom import GEOM

QUICK = {"phases.hover": 0.5, "phases.tare": 1.0, "phases.settle": 0.5, "phases.hover_end": 0.0}


@pytest.fixture(scope="module")
def takeoff():
    return take_off("valve", (None,), 0, QUICK)[0]


def test_closest_points_are_those_of_the_engine(rng, gap_of):
    valve = Valve(slope=0.2, pitch=-0.1, roll=0.3, lever_angle=0.4, travel=2.0)
    angles = rng.uniform(0.0, 2.0, 50)
    points = valve.to_world(rng.uniform(-0.4, 0.4, (50, 3)))
    turned = turned_valve(valve, angles, np.zeros(50), points, 0.005)
    times, gap = 0.005 * np.arange(50), gap_of(valve)
    measured = [gap(point, angle) for point, angle in zip(points, angles, strict=True)]
    np.testing.assert_allclose(turned.signed_distance(points, times), measured, atol=1e-6)
    # The normal is the direction in which the distance grows.
    step = 1e-6 * turned.normal(points, times)
    grown = turned.signed_distance(points + step, times) - turned.signed_distance(points, times)
    np.testing.assert_allclose(grown, 1e-6, rtol=1e-3)


def test_inside_the_nearest_face_counts():
    valve = Valve(position=(0.0, 0.0, 0.0))
    foot, normal = valve.local_closest(np.array([[0.0, 0.2, 0.012], [0.0, 0.34, 0.0]]))
    np.testing.assert_allclose(foot, [[0.0, 0.2, 0.015], [0.0, 0.35, 0.0]], atol=1e-12)
    np.testing.assert_allclose(normal, [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]], atol=1e-12)
    np.testing.assert_allclose(valve.signed_distance(np.array([[0.0, 0.2, 0.012]])), -0.003)


def test_a_turning_lever_moves_as_fast_as_its_arm_is_long():
    valve = Valve(position=(1.0, 0.0, 1.0))
    turned = turned_valve(valve, np.zeros(1), np.array([0.5]), np.array([[1.0, 0.2, 1.0]]), 0.005)
    np.testing.assert_allclose(turned.velocity(np.zeros(1)), [[0.0, 0.0, 0.1]], atol=1e-12)


def test_it_is_turned_to_its_stop(flight, log):
    assert not flight.cause
    angle = log.valve_angle
    assert angle.attrs["units"] == "rad"
    assert float(angle[0]) == 0.0
    assert float(angle[-1]) == pytest.approx(np.pi / 2, abs=0.005)
    # Friction of 0.3 N m is more than 1 N at 0.28 m, and the damper adds little.
    push = np.linalg.norm(log.contact_force.values, axis=1)
    turning = (angle > 0.3) & (angle < 1.2)
    assert 0.9 < push[turning].mean() < 1.5


def test_it_is_not_pressed_harder_on_the_way_back(log):
    push = np.linalg.norm(log.contact_force.values, axis=1)
    at_stop = push[log.phase.values == 4][-200:].max()
    assert push[log.phase.values > 4].max() < 1.1 * at_stop


def test_gap_and_slip_are_those_to_the_lever(log):
    touching = (log.contact > 0.5) & (log.contact_force_normal > 0.3)
    assert np.abs(log.surface_gap.values[touching]).max() < 1e-3
    # The lever moves at 0.04 m/s, the tip along it by millimetres.
    middle = touching & (log.valve_angle > 0.3) & (log.valve_angle < 1.2)
    assert np.median(log.slip_speed.values[middle]) < 0.02


def test_every_driver_flies_the_same_flight(takeoff, flight):
    short = takeoff.changed(dataclasses.replace(takeoff.experiment, stop_at=13.0))
    here = fly_here(short)
    native = fly_native([short])[0]
    np.testing.assert_array_equal(here.signals, native.signals)
    assert here.signal("configuration")[-1, -1] > 0.1  # it turns by then


def test_the_replay_shows_the_lever_turn(tmp_path, log):
    run = skylimb.run("valve", set={**QUICK, "stop_at": 14.0})
    shown = viewer_payload({"valve": run})["flights"][0]
    levers = [shape for shape in shown["shapes"] if shape["kind"] == "box" and shape["size"][1] == 0.15]
    assert len(levers) == 1
    assert levers[0]["body"] > 0
    assert json.loads(run.log.attrs["surface"])["kind"] == "valve"
    assert "valve_angle" in run.log


def test_description_builds_it_again():
    valve = Valve(lever_angle=0.3, friction_torque=0.7)
    assert surface_from_mapping(valve.describe()["parameters"]) == valve


@pytest.mark.parametrize(
    ("given", "why"),
    [
        ({"surface.outer": 0.04}, "surface.outer = 0.04 m must be greater than surface.inner"),
        ({"surface.static_ratio": 1.5}, "'valve' stays where it is and has one friction"),
        ({"surface.sway_amplitude": 0.01}, "'valve' stays where it is and has one friction"),
        ({"plant.foot": 0.05}, "'valve' turns"),
        ({"events": [{"kind": "surface", "time": 5.0, "friction": 0.1}]}, "'valve' cannot change in flight"),
    ],
)
def test_what_it_cannot_be_is_refused(given, why):
    with pytest.raises(ConfigError, match=why):
        take_off("valve", (None,), 0, given)


def test_the_mission_flies_to_where_the_surface_is_believed():
    (right,) = take_off("valve", (None,), 0, QUICK)
    (wrong,) = take_off("valve", (None,), 0, {**QUICK, "surface_error": [0.01, -0.02, 0.03]})
    moved = wrong.mission.tip_path - right.mission.tip_path
    np.testing.assert_allclose(moved, np.tile([0.01, -0.02, 0.03], (len(moved), 1)), atol=1e-12)
    np.testing.assert_array_equal(wrong.plant.model.geom(GEOM).pos, right.plant.model.geom(GEOM).pos)
