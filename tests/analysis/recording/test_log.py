"""Every signal of a log has dimensions and a unit; those that count names say which."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from skylimb.analysis.recording.log import build_log
from skylimb.base.signals import Signal

ROBOT: Any = SimpleNamespace(
    rotors=(SimpleNamespace(name="front"), SimpleNamespace(name="back")),
    shape_joints=("joint1",),
    vectoring_joints=(),
)
TIMES = 0.005 * np.arange(4)


def test_what_everybody_knows_needs_no_declaration() -> None:
    values = {"thrusts_command": np.zeros((4, 2)), "cog_position": np.ones((4, 3)), "tilt": np.zeros(4)}
    log = build_log(values, TIMES, ROBOT, attributes={"robot": "two"})
    assert log.thrusts_command.dims == ("time", "rotor")
    assert log.rotor.values.tolist() == ["front", "back"]
    assert log.cog_position.sel(axis="y").values.tolist() == [1.0] * 4
    assert (log.cog_position.attrs["units"], log.cog_position.attrs["frame"]) == ("m", "W")
    assert (log.tilt.attrs["units"], log.time.attrs["units"]) == ("rad", "s")
    assert log.attrs == {"robot": "two"}
    assert "unrolled" not in log.coords


def test_a_signal_of_ones_own_has_what_its_author_declares() -> None:
    declared = {"my_power": Signal("W", "B", "power of each motor", "estimate")}
    values = {"my_power": np.zeros((4, 2)), "my_place": np.zeros((4, 3)), "my_mode": np.array([0, 1, 1, 0])}
    log = build_log(values, TIMES, ROBOT, declared, {"my_mode": ("in air", "landed")})
    said = {"units": "W", "frame": "B", "long_name": "power of each motor", "kind": "estimate"}
    assert log.my_power.attrs == said
    assert log.my_power.dims == ("time", "my_power_0")
    assert log.my_place.dims == ("time", "axis")
    assert log.my_mode.attrs["flag_meanings"] == "in_air landed"
    np.testing.assert_array_equal(log.my_mode.attrs["flag_values"], [0, 1])
