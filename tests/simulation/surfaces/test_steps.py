"""Surfaces of flat faces: which way a step goes."""

import pytest

from skylimb.simulation.surfaces import Step


@pytest.mark.parametrize("rise", [0.01, -0.02])
def test_beyond_its_offset_the_wall_stands_closer_by_the_rise(rise: float) -> None:
    profile = Step(rise=rise, offset=0.1).profile
    before, beyond = (float(profile.height(u, 0.0)) for u in (-0.2, 0.4))
    assert before - beyond == pytest.approx(rise)  # heights count away from the robot
