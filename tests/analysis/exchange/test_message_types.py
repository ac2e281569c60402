"""Message types from .msg files: the digests are those of the lab's own build."""

from __future__ import annotations

from pathlib import Path

import pytest

from skylimb.analysis.exchange.message_types import Definitions
from skylimb.base.errors import ConfigError

MESSAGES = Path(__file__).parent / "messages"
DIGESTS = {
    "tf2_msgs/msg/TFMessage": "94810edd",
    "spinal/msg/Imu": "ae078a6c",
    "spinal/msg/FourAxisCommand": "058c4b50",
    "spinal/msg/RollPitchYawTerms": "e02c9784",
    "spinal/msg/PMatrixPseudoInverseWithInertia": "e67a441f",
    "spinal/msg/TorqueAllocationMatrixInv": "048fbe8a",
    "spinal/msg/DesireCoord": "c66f4de7",
    "spinal/msg/FlightConfigCmd": "34283d92",
    "spinal/msg/ServoStates": "8ab23ee1",
    "spinal/msg/ServoControlCmd": "7b019fc2",
    "aerial_robot_msgs/msg/FlightNav": "7500a934",
    "aerial_robot_msgs/msg/PoseControlPid": "5ccc2d67",
}


@pytest.mark.parametrize(("kind", "digest"), DIGESTS.items())
def test_digests_are_the_labs(kind: str, digest: str) -> None:
    definitions = Definitions([MESSAGES])
    assert definitions.knows(kind)
    assert definitions.described(kind)[1].startswith(digest)


def folder_of_imu(folder: Path, text: str) -> Path:
    (folder / "spinal" / "msg").mkdir(parents=True)
    (folder / "spinal" / "msg" / "Imu.msg").write_text(text, encoding="utf-8")
    return folder


def test_an_older_definition_has_another_digest(tmp_path: Path) -> None:
    text = "time stamp\nfloat32[3] acc_data\nfloat32[3] gyro_data\nfloat32[3] mag_data\nfloat32[3] angles\n"
    definitions = Definitions([folder_of_imu(tmp_path, text)])
    assert definitions.knows("spinal/msg/Imu")
    assert not definitions.described("spinal/msg/Imu")[1].startswith("ae078a6c")


def test_what_is_not_there_is_unknown_and_what_cannot_be_read_is_said(tmp_path: Path) -> None:
    assert not Definitions().knows("spinal/msg/Imu")
    assert Definitions().knows("std_msgs/msg/Empty")
    with pytest.raises(ConfigError, match="does not exist"):
        Definitions([tmp_path / "nowhere"])
    for index, text in enumerate(("float32[3 acc\n", "Quartz clock\n")):
        definitions = Definitions([folder_of_imu(tmp_path / str(index), text)])
        with pytest.raises(ConfigError, match="is no message definition"):
            definitions.knows("spinal/msg/Imu")
