"""A surface that is turned in flight, and back."""

import numpy as np

from skylimb.flight.experiments.experiment import load_experiment
from skylimb.simulation.surface_at import changed_surface
from skylimb.simulation.surface_state import first_row
from skylimb.simulation.surfaces.placement import surface_rotation

DT = 0.005


def test_its_axes_are_those_of_every_tick() -> None:
    surface = load_experiment("paper").surface
    table = np.tile(first_row(surface), (6, 1))
    table[2:4, :6] += 0.3  # elsewhere and turned, then as before
    table[5, 4] += 0.1
    moved = changed_surface(surface, table, DT)
    normals = moved.in_world(np.tile([1.0, 0.0, 0.0], (6, 1)), DT * np.arange(6))
    axes = [surface_rotation(surface.contact_axis, *row[3:6]) for row in table]
    np.testing.assert_array_equal(normals, [R[:, 0] for R in axes])
    np.testing.assert_array_equal(moved.position, table[:, :3])
