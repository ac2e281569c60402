"""What is guessed of a propeller whose link alone is known: nothing that turns faster than one can."""

import math

import pytest

from skylimb.apps.robot_import.doubts import Doubt
from skylimb.apps.robot_import.mapping import MappedRotor
from skylimb.apps.robot_import.tree import UrdfTree
from skylimb.apps.robot_import.turning_guess import turning


def guessed(izz: float, thrust: float) -> tuple[float, float, str]:
    """Inertia, thrust over squared speed, and what is said of it, of a link of 30 g."""
    inertial = f'<inertial><mass value="0.03"/><inertia izz="{izz}"/></inertial>'
    doubts: list[Doubt] = []
    tree = UrdfTree(f'<robot name="it"><link name="prop">{inertial}</link></robot>'.encode(), "it.urdf")
    inertia, factor = turning(tree, MappedRotor("prop"), thrust, doubts)
    assert inertia is not None
    assert factor is not None
    return inertia, factor, str(doubts[-1])


@pytest.mark.parametrize(("thrust", "diameter", "turns"), [(8.0, 0.17, "17000"), (30.0, 0.33, "8600")])
def test_a_motor_without_its_propeller_gets_one_of_its_thrust(
    thrust: float, diameter: float, turns: str
) -> None:
    inertia, factor, told = guessed(2e-5, thrust)
    assert inertia == 2e-5
    # Not the 350 m/s and more that a disc of 73 mm would take.
    assert math.sqrt(thrust / factor) * diameter / 2.0 == pytest.approx(150.0, rel=0.02)
    assert (
        f"as for a propeller of {diameter} m (by its thrust, as its link is too small): {turns} rpm" in told
    )
    assert f"150 m/s at its tip for {thrust:g} N" in told


def test_a_disc_that_can_be_one_is_taken() -> None:
    _, factor, told = guessed(3e-4, 8.0)  # 0.28 m
    assert "as for a propeller of 0.28 m (by its link's inertia): " in told
    assert factor == pytest.approx(0.12 * 0.283**4 / (2.0 * math.pi) ** 2, rel=0.01)
