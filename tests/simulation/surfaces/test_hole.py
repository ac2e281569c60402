"""A peg and a chamfered hole: one geometry to physics and analysis, in and out again, with every driver."""

import dataclasses

import numpy as np
import pytest

from skylimb.base.errors import ConfigError
from skylimb.flight.drivers.native import fly_native
from skylimb.flight.flying import fly_here
from skylimb.flight.takeoff import take_off
from skylimb.simulation.contact import pair_compliance
from skylimb.simulation.surfaces import Hole, surface_from_mapping

QUICK = {"phases.hover": 0.5, "phases.tare": 1.0, "phases.settle": 3.0, "trajectory.duration": 3.0}


@pytest.fixture(scope="module")
def takeoff():
    return take_off("peg", (None,), 0, QUICK)[0]


def test_closest_points_are_those_of_the_engine(rng, gap_of):
    hole = Hole(slope=0.2, pitch=-0.1, roll=0.3)
    local = rng.uniform(-0.06, 0.06, (80, 3))
    local[:, 0] -= 0.01
    gaps = hole.signed_distance(hole.to_world(local))
    measured = gap_of(hole)
    np.testing.assert_allclose(gaps, [measured(point) for point in hole.to_world(local)], atol=1e-6)
    outside = gaps > 0.0
    normals = hole.normal(hole.to_world(local[outside]))
    grown = hole.signed_distance(hole.to_world(local[outside]) + 1e-7 * normals) - gaps[outside]
    np.testing.assert_allclose(grown, 1e-7, rtol=1e-3)


@pytest.mark.parametrize(
    ("place", "gap"),
    [
        ((0.04, 0.0, 0.0), 0.017),  # on its axis, to the walls
        ((0.055, 0.0, 0.0), 0.005),  # above the floor
        ((-0.01, 0.1, 0.0), 0.01),  # before the face
        ((0.0, 0.027, 0.0), 0.01 / np.sqrt(2.0)),  # over the chamfer
        ((0.04, 0.016, 0.0), 0.001),
    ],
)
def test_gaps_are_those_of_the_drawing(place, gap):
    hole = Hole(position=(0.0, 0.0, 0.0))
    assert hole.signed_distance(np.array([place])) == pytest.approx(gap, abs=1e-12)


def test_each_touch_has_the_surfaces_stiffness(takeoff):
    model, contact = takeoff.plant.model, takeoff.plant.surface.contact
    assert model.npair == 25
    assert "tip_peg" in takeoff.plant.scene
    solref = pair_compliance(model, contact)[:2]
    np.testing.assert_allclose(model.pair_solref, np.tile(solref, (25, 1)), rtol=1e-12)


def test_it_goes_down_to_the_floor_and_out_again(takeoff, flight, log):
    assert not flight.cause
    surface = takeoff.plant.surface
    front = surface.to_local(log.tip_position.values)[:, 0] + takeoff.robot.description.tip.radius
    slide = log.phase.values == 4
    assert front[slide][-200:] == pytest.approx(surface.depth, abs=1e-3)
    force = log.contact_force.values[slide][-200:].mean(axis=0)
    assert -surface.R_WS[:, 0] @ force == pytest.approx(2.4, abs=0.7)  # the push still comes
    assert front[-1] < -0.05
    # On its way in it touches the chamfer, which pushes it aside.
    assert np.abs(log.contact_force.values[:, 1:]).max() > 0.2


def test_every_driver_flies_the_same_flight(takeoff, flight):
    short = takeoff.changed(dataclasses.replace(takeoff.experiment, stop_at=7.0))
    here, native = fly_here(short), fly_native([short])[0]
    np.testing.assert_array_equal(here.signals, native.signals)
    assert native.signal("contact_duty").max() > 0.0


def test_a_peg_stands_along_its_stem():
    tip = take_off("peg", (None,))[0].robot.description.tip
    np.testing.assert_array_equal(tip.along, [1.0, 0.0, 0.0])
    stem = dataclasses.replace(tip, stem=np.asarray(tip.position) - np.array([0.0, 0.0, 0.2]))
    np.testing.assert_allclose(stem.along, [0.0, 0.0, 1.0])


def test_description_builds_it_again():
    hole = Hole(radius=0.02, depth=0.1)
    assert surface_from_mapping(hole.describe()["parameters"]) == hole


@pytest.mark.parametrize(
    ("given", "why"),
    [
        ({"plant.peg": [0.018, 0.12]}, "does not fit into a hole of 0.017 m"),
        ({"plant.peg": [0.015, 0.02]}, "longer than it is wide"),
        ({"surface.chamfer": 0.07}, "must be less than surface.depth"),
        ({"surface.size": [0.4, 0.3]}, "as high as wide"),
        ({"surface.static_ratio": 1.5}, "'hole' stays where it is and has one friction"),
        ({"surface.sway_amplitude": 0.01}, "'hole' stays where it is and has one friction"),
        ({"plant.foot": 0.05}, "'hole' has walls"),
        ({"events": [{"kind": "surface", "time": 5.0, "friction": 0.1}]}, "'hole' cannot change in flight"),
    ],
)
def test_what_it_cannot_be_is_refused(given, why):
    with pytest.raises(ConfigError, match=why):
        take_off("peg", (None,), 0, given)


def test_a_hole_needs_a_peg_and_a_peg_a_hole():
    with pytest.raises(ConfigError, match=r"plant\.peg needs a surface of kind 'hole'"):
        take_off("paper", ("pid",), 0, {"plant.peg": [0.015, 0.12]})
    with pytest.raises(ConfigError, match="needs a peg"):
        take_off("paper", ("pid",), 0, {"surface": {"kind": "hole"}})
