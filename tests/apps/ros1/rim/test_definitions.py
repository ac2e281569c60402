"""Message classes from .msg files at run time: the digests are those of the lab's own build."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from skylimb.apps.ros1.rim.definitions import Definitions
from skylimb.base.errors import ConfigError

DIGESTS = {
    "spinal/Imu": "ae078a6c",
    "spinal/FourAxisCommand": "058c4b50",
    "spinal/RollPitchYawTerms": "e02c9784",
    "spinal/PMatrixPseudoInverseWithInertia": "e67a441f",
    "spinal/DesireCoord": "c66f4de7",
    "spinal/FlightConfigCmd": "34283d92",
    "spinal/ServoStates": "8ab23ee1",
    "spinal/ServoControlCmd": "7b019fc2",
    "aerial_robot_msgs/FlightNav": "7500a934",
    "aerial_robot_msgs/PoseControlPid": "5ccc2d67",
}


@pytest.mark.parametrize(("name", "digest"), DIGESTS.items())
def test_digests_are_the_labs(definitions: Definitions, name: str, digest: str) -> None:
    found: Any = definitions.find(name)
    assert found._md5sum.startswith(digest)


def test_an_older_definition_has_another_digest(ros: None, tmp_path: Path) -> None:
    (tmp_path / "spinal" / "msg").mkdir(parents=True)
    text = "time stamp\nfloat32[3] acc_data\nfloat32[3] gyro_data\nfloat32[3] mag_data\nfloat32[3] angles\n"
    (tmp_path / "spinal" / "msg" / "Imu.msg").write_text(text, encoding="utf-8")
    found: Any = Definitions([tmp_path]).find("spinal/Imu")
    assert not found._md5sum.startswith("ae078a6c")


def test_what_is_not_there_is_none_and_what_cannot_be_read_is_said(ros: None, tmp_path: Path) -> None:
    assert Definitions().find("spinal/Imu") is None
    assert Definitions().find("std_msgs/Empty") is not None
    with pytest.raises(ConfigError, match="does not exist"):
        Definitions([tmp_path / "nowhere"])
    (tmp_path / "spinal" / "msg").mkdir(parents=True)
    (tmp_path / "spinal" / "msg" / "Imu.msg").write_text("float32[3 acc\n", encoding="utf-8")
    with pytest.raises(ConfigError, match="is no message definition"):
        Definitions([tmp_path]).find("spinal/Imu")
