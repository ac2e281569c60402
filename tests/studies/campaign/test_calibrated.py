"""A campaign whose controllers know what a calibration found."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from skylimb.base.errors import ConfigError
from skylimb.robots.loader import load_robot
from skylimb.studies.campaign.frozen import campaign_from_mapping, freeze
from skylimb.studies.campaign.spec import CampaignSpec

ROBOT = load_robot("hydrus_xi_quad")


@pytest.fixture
def calibration(tmp_path: Path, write_calibration: Callable[[Path], Path]) -> Path:
    return write_calibration(tmp_path / "calibration.toml")


def test_every_controller_has_it(calibration: Path) -> None:
    spec = CampaignSpec("paper", ("pid", "following"), draws=2, calibration=str(calibration))
    campaign = freeze(spec)
    again = campaign_from_mapping(campaign.to_mapping(), "spec.toml")
    for name in campaign.names:
        for flown in (campaign, again):
            controller: Any = flown.load(name, ROBOT)
            assert controller.corrections.cog_offset == (0.01, -0.005, 0.01)
    following: Any = again.load("following", ROBOT)
    assert following.tables()["estimation"]["delay"]["latency"] == 0.03
    varied: Any = again.load("following", ROBOT, {"estimation.delay.latency": 0.01})
    assert varied.tables()["estimation"]["delay"]["latency"] == 0.01


def test_a_controller_in_python_is_refused(calibration: Path) -> None:
    spec = CampaignSpec("paper", ("mine.py",), draws=2, calibration=str(calibration))
    with pytest.raises(ConfigError, match="only presets fly calibrated"):
        freeze(spec)
