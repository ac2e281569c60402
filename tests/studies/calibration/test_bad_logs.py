"""Logs that no calibration is made of: one line says why, and nothing is written."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import skylimb
from skylimb.analysis.exchange.convert import write_log
from skylimb.apps.cli.main import main
from skylimb.base.errors import ConfigError, OutputError
from skylimb.robots.model import Robot
from skylimb.studies.calibration.log import free_pieces
from skylimb.studies.calibration.public import calibration_from, flight_of, robot_of


def _nan(name: str) -> Callable[[xr.Dataset], xr.Dataset]:
    def change(log: xr.Dataset) -> xr.Dataset:
        values = log[name].values.copy()
        values[700, 1] = np.nan
        return log.assign({name: (log[name].dims, values, log[name].attrs)})

    return change


def _still(log: xr.Dataset) -> xr.Dataset:
    rng = np.random.default_rng(0)
    changed = {}
    for name in ("root_position_measured", "joint_angles_measured", "vectoring_angles_measured"):
        values = log[name].values
        changed[name] = (
            log[name].dims,
            values[:1] + 1e-3 * rng.standard_normal(values.shape),
            log[name].attrs,
        )
    q = np.tile(log["root_quaternion_measured"].values[:1], (len(log.time), 1))
    changed["root_quaternion_measured"] = (log["root_quaternion_measured"].dims, q, {})
    return log.assign(changed)


def _blind(log: xr.Dataset) -> xr.Dataset:
    values = log["root_position_measured"].values.copy()
    values[600:900] = np.nan
    return log.assign(root_position_measured=(log["root_position_measured"].dims, values, {"units": "m"}))


def _scaled(name: str, factor: float) -> Callable[[xr.Dataset], xr.Dataset]:
    return lambda log: log.assign({name: log[name] * factor})


def _in(name: str, unit: str) -> Callable[[xr.Dataset], xr.Dataset]:
    return lambda log: log.assign({name: log[name].assign_attrs(units=unit)})


def _made(name: str, change: Callable[[np.ndarray], np.ndarray]) -> Callable[[xr.Dataset], xr.Dataset]:
    return lambda log: log.assign({name: (log[name].dims, change(log[name].values), log[name].attrs)})


def _timed(change: Callable[[np.ndarray], np.ndarray]) -> Callable[[xr.Dataset], xr.Dataset]:
    return lambda log: log.assign_coords(time=("time", change(log.time.values.copy())))


def _unknown_at_2_s(times: np.ndarray) -> np.ndarray:
    times[400] = np.nan
    return times


def _touching(log: xr.Dataset) -> xr.Dataset:
    values = log["contact"].values.copy()
    values[900] = 1.0
    return log.assign(contact=(log["contact"].dims, values))


def _happened(
    kind: str, time: float = 4.0, words: str = "", **more: Any
) -> Callable[[xr.Dataset], xr.Dataset]:
    event = {"kind": kind, "time": time, "duration": 4.5, "words": words, **more}
    return lambda log: log.assign_attrs(events=json.dumps([event]))


BAD: dict[str, tuple[Callable[[xr.Dataset], xr.Dataset], str]] = {
    "short": (lambda log: log.isel(time=slice(0, 500)), "lasts 2.5 s"),
    "empty": (lambda log: log.isel(time=slice(0, 0)), "lasts 0 s"),
    "no signal": (lambda log: log.drop_vars("thrusts_command"), "no signal 'thrusts_command'"),
    "nan of a command": (_nan("thrusts_command"), "'thrusts_command' of the log is not finite at 3.500 s"),
    "nan of an encoder": (_nan("joint_angles_measured"), "'joint_angles_measured'"),
    "gap": (lambda log: log.isel(time=np.r_[0:900, 950:2000]), "gap: from 4.495 s to 4.750 s"),
    "blind": (_blind, "without a frame"),
    "still": (_still, "excites nothing"),
    "unit": (_in("thrusts_command", "g"), "is in 'g'"),
    "grams": (_scaled("thrusts_command", 101.97), "another unit"),
    "unsorted": (
        lambda log: log.isel(time=np.r_[0:900, 500:2000]),
        "does not rise: 2.5 s comes after 4.495 s",
    ),
    "backwards": (lambda log: log.isel(time=slice(None, None, -1)), "the time of the log does not rise"),
    "twice": (lambda log: log.isel(time=np.repeat(np.arange(2000), 2)), "0 s comes after 0 s"),
    "unknown time": (_timed(_unknown_at_2_s), "nan s comes after 1.995 s"),
    "milliseconds": (_timed(lambda times: 1e3 * times), "is its time in seconds?"),
    "every other command": (
        lambda log: log.isel(time=slice(0, None, 2)),
        "a row every 0.01 s, and its controller commanded every 0.005 s",
    ),
    "no pose": (_scaled("root_position_measured", np.nan), "without a frame"),
    "millimetres": (_made("root_position_measured", lambda p: 1e3 * p), "millimetres?"),
    "degrees": (_made("joint_angles_measured", np.degrees), "degrees?"),
    "x y z w": (_made("root_quaternion_measured", lambda q: np.roll(q, -1, axis=1)), "x y z w in place of"),
    "quaternion": (_scaled("root_quaternion_measured", 2.0), "no unit quaternion"),
    "other robot": (lambda log: log.assign_attrs(robot="dragon"), "of robot 'dragon'"),
    "lost": (lambda log: log.assign_attrs(status="FAILED", cause="lost height"), "was lost (lost height)"),
    "touching": (_touching, "touched something at 4.500 s"),
    "another rotor": (_happened("rotor", words="rotor2 to 0.85"), "other sensors from 4.000 s on (rotor2 to"),
    "a lost mass": (_happened("body"), "has another robot"),
    "a turned capture": (_happened("sensor", turn=[0.0, 0.1, 0.0]), "has another robot"),
    "an encoder that comes back": (_happened("sensor", time=0.0, joint="joint1"), "from 4.500 s on"),
}


@pytest.mark.parametrize("name", BAD)
def test_it_is_refused_in_one_line(flown: skylimb.Run, robot: Robot, name: str) -> None:
    change, said = BAD[name]
    with pytest.raises(ConfigError) as error:
        calibration_from(dataclasses.replace(flown, log=change(flown.log)), robot)
    assert said in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    "change",
    [
        _happened("sensor", capture="lost", late=0.0, jump=[0.0, 0.0, 0.0], turn=[0.0, 0.0, 0.0], joint=""),
        _happened("push"),
        _happened("rotor", time=100.0),
    ],
)
def test_what_leaves_robot_and_sensors_as_they_are_is_not_refused(
    flown: skylimb.Run, robot: Robot, change: Callable[[xr.Dataset], xr.Dataset]
) -> None:
    run = dataclasses.replace(flown, log=change(flown.log))
    assert free_pieces(run, 0.005, np.ones(len(run.log.time), dtype=bool))


def test_nothing_is_written(flown: skylimb.Run, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    short = dataclasses.replace(flown, log=flown.log.isel(time=slice(0, 500)))
    short.save(tmp_path / "short.nc")
    assert main(["calibrate", str(tmp_path / "short.nc"), "--out", str(tmp_path / "made")]) == 2
    assert "lasts 2.5 s" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["short.nc"]


def test_the_robot_of_a_log_that_describes_itself_in_other_words_is_the_one_that_it_names(
    flown: skylimb.Run,
) -> None:
    foreign = dataclasses.replace(flown, log=flown.log.assign_attrs(config="speed: fast"))
    assert foreign.tables == {}
    assert robot_of(foreign).name == "hydrus_xi_quad"


def test_settings_belong_to_a_flight_that_is_flown(flown: skylimb.Run) -> None:
    with pytest.raises(ConfigError, match="has its seed and its settings already"):
        skylimb.calibrate(flown, seed=3)


def test_a_bag_is_read_as_its_log_is(flown: skylimb.Run, tmp_path: Path) -> None:
    for name in ("flown.nc", "flown.bag", "flown.mcap"):
        write_log(flown, tmp_path / name)
        read = flight_of(tmp_path / name)
        assert read.log.drop_attrs().identical(flown.log.drop_attrs())
        assert robot_of(read).name == "hydrus_xi_quad"
    table = tmp_path / "flown.csv"
    table.write_text("time,thrust\n0.0,1.0\n")
    with pytest.raises(OutputError, match=r"flown\.csv' is not a readable NetCDF-4 file"):
        skylimb.calibrate(table)
    with pytest.raises(OutputError, match=r"'none\.mcap' does not exist"):
        skylimb.calibrate("none.mcap")
    with pytest.raises(OutputError, match="'out/none' does not exist"):
        skylimb.calibrate("out/none")
    with pytest.raises(ConfigError, match="unknown experiment 'none'"):
        skylimb.calibrate("none")
