"""What sensors tell beside what they measure."""

from __future__ import annotations

import pytest

from skylimb.analysis.exchange.lab_topics import IMU, MOCAP
from skylimb.analysis.exchange.messages import Imu, Pose
from skylimb.apps.ros.heard import Heard
from skylimb.apps.ros.messages import Arrived

G = 9.81


def felt(heard: Heard, begin: float, end: float, force: float = G) -> Heard:
    for k in range(round((end - begin) / 0.005)):
        at = begin + 0.005 * k
        imu = Imu(at, (0.0, 0.0, 0.0), (0.0, 0.0, force), (1.0, 0.0, 0.0, 0.0))
        heard = heard.take(Arrived(IMU.name, imu, "/spinal", at), G)
    return heard


def test_an_accelerometer_that_is_silent_feels_no_ground() -> None:
    heard = felt(Heard(), 0.0, 1.0)
    assert heard.rest(1.0) == pytest.approx(1.0)
    assert heard.rest(1.2) == 0.0
    heard = felt(heard, 2.0, 2.3)
    assert heard.rest(2.3) == pytest.approx(0.3)  # nobody knows what it felt before
    assert felt(heard, 2.3, 2.4, 0.9 * G).rest(2.4) == 0.0


@pytest.mark.parametrize("rate", [12.0, 100.0, 1000.0])
def test_the_rate_of_the_capture_is_that_of_its_stamps(rate: float) -> None:
    """Frames come in bursts, are lost, and their clock is set."""
    heard = Heard()
    stamps = [k / rate for k in range(100)]
    stamps += [stamps[-1] + 5.0 + k / rate for k in range(100)]
    stamps += [k / rate for k in range(100)]
    for stamp in stamps:
        pose = Pose(stamp, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))
        heard = heard.take(Arrived(MOCAP.name, pose, "/capture", 1.0), G)
    assert heard.rate == pytest.approx(rate)
