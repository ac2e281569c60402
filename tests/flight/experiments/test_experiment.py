"""An experiment as its file and what was set otherwise."""

import re

import pytest

from skylimb.base.errors import ConfigError, UnknownNameError
from skylimb.flight.experiments.experiment import load_experiment


def test_a_description_says_what_was_set_otherwise():
    """The file speaks of a circle on a board; a report of a line on a cylinder must not."""
    shipped = load_experiment("paper").description
    assert "circle" in shipped
    changes = {"surface.kind": "cylinder", "trajectory.shape": "line", "seed": 3}
    changed = load_experiment("paper", changes).description
    assert changed == f"{shipped}; set otherwise: surface.kind, trajectory.shape"
    assert load_experiment("paper", {"seed": 3}).description == shipped
    assert load_experiment("paper", {**changes, "description": "A line"}).description == "A line"
    many = {f"plant.{key}": 1.01 for key in ("thrust_scale", "mass_scale", "servo_stiffness_scale")}
    many |= {"phases.hover": 2.0, "phases.tare": 3.0, "approach.depth": 0.1}
    assert load_experiment("paper", many).description.endswith(
        "servo_stiffness_scale, phases.hover and 2 more"
    )


def test_a_slots_law_without_its_controller_is_meant() -> None:
    """As a page's table `[allocation]` has it."""
    with pytest.raises(UnknownNameError, match=r"did you mean 'controller\.allocation\.law'\?"):
        load_experiment("paper", {"allocation.law": "bounded"})


@pytest.mark.parametrize(
    ("key", "meant"),
    [
        ("trajectry.radius", "trajectory.radius"),  # not surface.edge_radius, which ends alike
        ("surfce.friction", "surface.friction"),
        ("contrller.translation.force", "controller.translation.force"),
        ("sface", "surface"),  # a table, and not terminations.distance
        ("radus", "trajectory.radius"),
    ],
)
def test_a_key_that_is_spelled_wrong_is_guessed_from_its_table_on(key: str, meant: str) -> None:
    with pytest.raises(UnknownNameError, match=rf"did you mean .*'{re.escape(meant)}'"):
        load_experiment("paper", {key: 1.0})


@pytest.mark.parametrize("key", ["pen_line", "frechet", "of_size", "finest"])
def test_what_a_line_is_divided_by_may_not_be_zero(key) -> None:
    """A line drawn within 11 mm was then missed since it was not drawn."""
    with pytest.raises(ConfigError, match=rf"tolerances\.{key} = 0.* must be above 0"):
        load_experiment("paper", {f"tolerances.{key}": 0.0})
