"""A campaign whose controllers know what a calibration found."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import tomli_w

from skylimb.base.errors import ConfigError
from skylimb.robots.loader import load_robot
from skylimb.studies.campaign.frozen import campaign_from_mapping, freeze
from skylimb.studies.campaign.spec import CampaignSpec

ROBOT = load_robot("hydrus_xi_quad")


@pytest.fixture
def calibration(tmp_path: Path) -> Path:
    """A calibration.toml of the robot that ships."""
    path = tmp_path / "calibration.toml"
    tables = {
        "format": "skylimb calibration",
        "robot": ROBOT.name,
        "robot_digest": ROBOT.description.digest,
        "attitude_misalignment": {"value": [0.01, 0.0, 0.02]},
        "cog_offset": {"value": [0.01, -0.005, 0.01]},
        "rotor_scale": {"value": [0.98, 1.0, 1.02, 1.0]},
        "rotor_lag": {"value": 0.06},
        "latency": {"value": 0.03},
    }
    path.write_text(tomli_w.dumps(tables), "utf-8")
    return path


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
