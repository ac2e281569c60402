"""What rviz draws around the robot has the sizes and the place of what is flown against."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from skylimb.analysis.exchange.ros2_topics import SCENE
from skylimb.analysis.exchange.ros2_types import Ros2Types
from skylimb.apps.ros2.scene import scene
from skylimb.flight.loading import plan_flights
from skylimb.flight.plan import FlightPlan

TYPES = Ros2Types()


def drawn(plan: FlightPlan) -> list[Any]:
    content = TYPES.write(SCENE.type, scene(plan), 0)
    return TYPES.types.deserialize_cdr(content, SCENE.type).markers


def test_the_paper_s_board() -> None:
    (plan,) = plan_flights("paper", ("hybrid",))
    (board,) = drawn(plan)
    surface: Any = plan.experiment.surface
    assert board.type == board.CUBE
    sizes = sorted([board.scale.x, board.scale.y, board.scale.z])
    np.testing.assert_allclose(sizes[1:], surface.size)
    place = board.pose.position
    normal = np.asarray(surface.describe()["normal"])
    away = (np.array([place.x, place.y, place.z]) - surface.position) @ normal
    assert away == pytest.approx(-0.5 * sizes[0], abs=1e-6)
    assert board.header.frame_id == "world"


def test_a_curved_surface_is_drawn_too() -> None:
    (plan,) = plan_flights("paper", ("hybrid",), set={"surface.kind": "cylinder"})
    assert [one.type for one in drawn(plan)] == [3]
