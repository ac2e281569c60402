"""Faults that controllers bear by themselves, without a supervisor."""

from __future__ import annotations

import numpy as np
import pytest

import skylimb
from short_flights import HOLD


@pytest.mark.parametrize(("force", "most"), [(1.0, 0.03), (2.0, 0.05)])
@pytest.mark.parametrize("controller", ["following", "drawing"])
def test_a_board_that_goes_lets_no_tip_rush_after_it(controller: str, force: float, most: float) -> None:
    """Pressed with 1 N and nothing done it goes 80 mm and as fast as .15 m/s, with 2 N 230 mm."""
    gone = [{"kind": "surface", "time": 5.0, "present": False}]
    wanted = {"controller.translation.force": force, "trajectory.duration": 4.0, "events": gone}
    flown = skylimb.run("paper", controller, set={**HOLD, **wanted})
    along = flown.log.tip_position.values[:, 0] - flown.log.tip_position.sel(time=5.0).values[0]
    time = flown.log.time.values
    before, after = time < 5.0, (time > 5.0) & (time < 6.5)
    assert 0.0 < along[after].max() < most
    assert np.gradient(along, time)[after].max() < 0.15
    known = flown.log.surface_gone.values > 0.5
    assert known[after].any()
    assert not known[before].any()
