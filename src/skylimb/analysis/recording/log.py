"""The log of a flight: every signal under its name, with dimensions, unit, frame and meaning.

Every log is put together here: of simulated flights, of robots behind a link or on ROS, of replays and of
other tools' files.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from skylimb.base.signal_table import SIGNALS, SignalInfo
from skylimb.base.signals import Signal

if TYPE_CHECKING:
    import xarray as xr

    from skylimb.robots.description import RobotDescription


def build_log(
    values: Mapping[str, np.ndarray],
    times: np.ndarray,
    robot: RobotDescription,
    declared: Mapping[str, Signal] | None = None,
    flags: Mapping[str, Sequence[str]] | None = None,
    attributes: Mapping[str, Any] | None = None,
) -> xr.Dataset:
    """The log of a flight.

    Args:
        values: signals by name, the ticks first.
        times: of the ticks, s since take-off.
        robot: names rotors and joints.
        declared: what their authors say of signals that not everybody knows.
        flags: names that are counted by a signal's values.
        attributes: of the whole log.
    """
    import xarray

    declared, flags = declared or {}, flags or {}
    coordinates: dict[str, Any] = {
        "time": ("time", times, {"units": "s", "long_name": "time"}),
        "axis": ["x", "y", "z"],
        "quaternion": ["w", "x", "y", "z"],
        "rotor": [rotor.name for rotor in robot.rotors],
        "joint": list(robot.shape_joints),
        "vectoring": list(robot.vectoring_joints),
    }
    variables = {
        name: log_variable(name, array, declared.get(name, Signal()), flags.get(name, ()))
        for name, array in values.items()
    }
    if any("unrolled" in variable.dims for variable in variables.values()):
        coordinates["unrolled"] = ["u", "v"]
    return xarray.Dataset(variables, coordinates, attributes)


def log_variable(name: str, array: np.ndarray, own: Signal, flags: Sequence[str] = ()) -> xr.Variable:
    """A signal as a variable of the log, with dimensions, unit, frame and meaning.

    Args:
        name: of the signal.
        array: its values, the ticks first.
        own: what its author declares; a signal that everybody knows needs nothing.
        flags: the names that its values count.
    """
    import xarray

    info = SIGNALS.get(name, SignalInfo(_plain_dims(array, name), own.unit, own.frame, own.meaning, own.kind))
    attrs: dict[str, Any] = {
        "units": info.units,
        "frame": info.frame,
        "long_name": info.long_name,
        "kind": info.kind,
    }
    if flags:
        names = [word.replace(" ", "_") for word in flags]
        attrs |= {"flag_values": np.arange(len(names), dtype=np.int8), "flag_meanings": " ".join(names)}
    # What has an entry for each joint is a plain number in a trace where there is one.
    entries = array if array.ndim > len(info.dims) else array.reshape(len(array), *(1 for _ in info.dims))
    return xarray.Variable(("time", *info.dims), entries, attrs)


def _plain_dims(array: np.ndarray, name: str) -> tuple[str, ...]:
    if array.ndim == 1:
        return ()
    return ("axis",) if array.shape[1:] == (3,) else tuple(f"{name}_{i}" for i in range(array.ndim - 1))
