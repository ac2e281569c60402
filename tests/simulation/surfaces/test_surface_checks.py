"""What is refused before anything flies."""

import numpy as np
import pytest

from skylimb.base.errors import ConfigError
from skylimb.simulation.surfaces import (
    Board,
    Corrugated,
    Cylinder,
    Step,
    require_clear,
    require_fits,
    require_path,
    way_clear,
)


def circle(radius, center=(0.0, 1.0)):
    t = np.linspace(0, 2 * np.pi, 50)
    return np.stack(
        [np.zeros_like(t), center[0] + radius * np.cos(t), center[1] + radius * np.sin(t)], axis=-1
    )


def test_a_tip_that_fits_and_one_that_does_not():
    require_fits(Corrugated(), 0.004)
    with pytest.raises(ConfigError, match=r"corrugated.*16.3 mm.*20 mm"):
        require_fits(Corrugated(), 0.02)
    with pytest.raises(ConfigError, match="step"):
        require_fits(Step(fillet_radius=0.0), 0.004)
    require_fits(Board(), 1.0)


def test_a_surface_in_the_robot_is_refused():
    points = np.array([[0.0, 0.0, 1.0], [0.6, 0.1, 1.0]])
    require_clear(Board(), points, 0.1)
    with pytest.raises(ConfigError, match=r"board.*intersects the robot.*100 mm deep.*0.600"):
        require_clear(Board(position=(0.6, 0.0, 1.0)), points, 0.1)


def test_the_message_names_the_standoff_that_is_clear():
    points, axis = np.array([[0.9, 0.2, 1.0], [1.05, -0.1, 1.2]]), np.array([0.8, 0.0, 0.6])
    for surface in (Board(), Board(slope=0.35), Cylinder(radius=0.5)):
        way = way_clear(surface, points, 0.1, axis, keep=0.02)
        gaps = surface.signed_distance(points - way * axis, 0.0) - 0.1
        assert gaps.min() == pytest.approx(0.02, abs=2e-4)
    with pytest.raises(ConfigError, match=r"150 mm deep.*approach\.standoff is .*with 0\.226 m more"):
        require_clear(Board(), points, 0.1, "the robot", axis)
    with pytest.raises(ConfigError, match=r"approach\.standoff .*no larger one is clear"):
        require_clear(Board(), points, 0.1, "the robot", np.array([0.0, 0.0, 1.0]))
    assert way_clear(Board(), points[:1], 0.05) == 0.0


def test_a_hollow_cylinder_whose_rim_reaches_the_robot_is_refused():
    wide = Cylinder(concave=True, size=(1.9, 2.0))
    with pytest.raises(ConfigError, match="cylinder"):
        require_clear(wide, np.array([[0.5, 0.85, 1.0]]), 0.05)


def test_a_path_off_the_surface_is_refused():
    require_path(Board(), circle(0.3))
    with pytest.raises(ConfigError, match=r"the path leaves surface 'board'.*1 m x 1 m"):
        require_path(Board(size=(1.0, 1.0)), circle(0.6))
    with pytest.raises(ConfigError, match="the path leaves surface 'cylinder'"):
        require_path(Cylinder(radius=0.2), circle(0.3))


def test_a_surface_covers_its_size_and_no_more():
    surface = Board(size=(1.0, 0.6), slope=0.3, pitch=-0.2)
    u, v = np.array([0.0, 0.49, 0.51, -0.49, 0.0, 0.0]), np.array([0.0, 0.29, 0.0, -0.29, 0.31, -0.31])
    points = surface.to_world(np.stack([np.full(6, -0.05), u, v], axis=-1))
    assert surface.covers(points).tolist() == [True, True, False, True, False, False]
