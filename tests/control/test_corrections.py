"""What a calibration found, in the model of a controller."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w

import skylimb
from skylimb.apps.cli.main import main
from skylimb.base.errors import ConfigError
from skylimb.base.rotations import quaternion_product
from skylimb.control.calibrated import calibrated
from skylimb.control.controller import controller_from_tables, load_controller
from skylimb.control.corrections import (
    CALIBRATION,
    Corrections,
    believed_robot,
    read_corrections,
    turned_back,
)
from skylimb.control.estimation.records import Measurement
from skylimb.control.laws.preset import preset_mapping
from skylimb.flight.drivers.native import fly_native
from skylimb.flight.experiments.experiment import load_experiment
from skylimb.flight.export.step import controller_step
from skylimb.flight.flying import fly_here
from skylimb.flight.takeoff import prepare
from skylimb.robots.loader import load_robot
from skylimb.simulation.plant import plant_description
from skylimb.simulation.plant_config import PlantConfig

ROBOT = load_robot("hydrus_xi_quad")
FOUND = Corrections(
    robot=ROBOT.name,
    robot_digest=ROBOT.description.digest,
    attitude_misalignment=(0.03, -0.02, 0.035),
    cog_offset=(0.02, -0.01, 0.015),
    rotor_scale=(0.95, 1.03, 0.98, 1.01),
    rotor_lag=0.06,
    latency=0.03,
)
REAL = {
    "plant.rotor_scale": list(FOUND.rotor_scale),
    "plant.cog_offset": list(FOUND.cog_offset),
    "plant.rotor_lag": FOUND.rotor_lag,
    "sensors.attitude_misalignment": list(FOUND.attitude_misalignment),
    "sensors.latency": FOUND.latency,
}
HOVER = {"phases.hover": 4.0, "phases.tare": 1.0, "posture.waypoints": [], "trajectory.duration": 1.0}
HOVER |= {"phases.hover_end": 0.5}


def file_of(corrections: Corrections, folder: Path, **changes: Any) -> Path:
    """A calibration.toml with these corrections."""
    tables: dict[str, Any] = {"format": "skylimb calibration"}
    for one in dataclasses.fields(Corrections):
        value = getattr(corrections, one.name)
        tables[one.name] = (
            value if one.name.startswith("robot") and one.name != "rotor_scale" else {"value": value}
        )
    path = folder / "calibration.toml"
    path.write_text(tomli_w.dumps({**tables, **changes}), "utf-8")
    return path


def test_the_believed_robot_is_the_one_that_flies() -> None:
    real = skylimb.Robot(plant_description(ROBOT.description, PlantConfig(cog_offset=FOUND.cog_offset)))
    believed = believed_robot(ROBOT, FOUND)
    q, psi = [0.5, 1.0, -0.5], [0.1, 0.2, -0.1, 0.3]
    for one, other in zip(real.at(q, psi), believed.at(q, psi), strict=True):
        assert np.allclose(one, other)
    assert believed.description.rotors[0].thrust_max == pytest.approx(
        0.95 * ROBOT.description.rotors[0].thrust_max
    )
    assert believed_robot(ROBOT, dataclasses.replace(FOUND)) is believed


def test_a_measured_attitude_is_turned_back() -> None:
    true = np.array([0.9, 0.1, -0.3, 0.2])
    true = true / np.linalg.norm(true)
    e = np.asarray(FOUND.attitude_misalignment)
    seen = quaternion_product(true, np.concatenate([[1.0], 0.5 * e])) / np.sqrt(1.0 + 0.25 * (e @ e))
    z3 = np.zeros(3)
    measured = Measurement(z3, seen, z3, z3, z3, np.zeros(4))
    assert np.allclose(turned_back(FOUND, measured).quaternion, true, atol=1e-14)


def test_a_calibrated_robot_hovers_as_if_it_were_the_described_one() -> None:
    worst = {}
    for name, changes, calibration in (
        ("described", {}, None),
        ("unknown", REAL, None),
        ("calibrated", REAL, FOUND),
    ):
        run = skylimb.run("calibration", "impedance", set={**HOVER, **changes}, calibration=calibration)
        # The hover, before the robot is shaken: there, its longer lag and latency cost lift.
        error = (run.log.cog_position - run.log.cog_position_reference).values[-600:-300]
        worst[name] = float(np.abs(error).max())
    assert worst["unknown"] > 100.0 * worst["calibrated"], worst
    assert worst["calibrated"] < worst["described"] + 0.001, worst


def test_both_drivers_fly_it_to_the_same_bits() -> None:
    controller = calibrated(load_controller("following", ROBOT), ROBOT, FOUND)
    experiment = load_experiment("calibration", {**HOVER, **REAL})
    takeoff = prepare(experiment, ROBOT, controller)
    here, (native,) = fly_here(takeoff), fly_native([takeoff])
    assert np.array_equal(here.signal("configuration"), native.signal("configuration"))


def test_gains_that_laws_have_are_set_unless_the_user_gives_them() -> None:
    following = calibrated(load_controller("following", ROBOT), ROBOT, FOUND)
    tables = following.tables()
    assert tables["estimation"]["delay"]["latency"] == 0.03
    assert tables["allocation"]["rotor_lag"]["time_constant"] == 0.06
    given = calibrated(
        load_controller("following", ROBOT), ROBOT, FOUND, ("estimation.delay.latency",)
    ).tables()
    assert given["estimation"]["delay"]["latency"] == 0.02
    assert calibrated(load_controller("pid", ROBOT), ROBOT, FOUND).name == "pid"


def test_its_tables_make_it_again() -> None:
    first: Any = calibrated(load_controller("following", ROBOT), ROBOT, FOUND)
    again: Any = controller_from_tables(first.tables(), Path("config.toml"), ROBOT)
    assert again.tables() == first.tables()
    assert again.structure() == first.structure()
    assert first.structure() != load_controller("following", ROBOT).structure()  # type: ignore[attr-defined]


def test_a_run_is_flown_again_from_its_configuration(tmp_path: Path) -> None:
    run = skylimb.run("calibration", "pid", set={**HOVER, **REAL}, calibration=file_of(FOUND, tmp_path))
    (tmp_path / "config.toml").write_text(run.config, "utf-8")
    again = skylimb.run(str(tmp_path / "config.toml"))
    assert np.array_equal(run.log.configuration, again.log.configuration)
    assert CALIBRATION in run.config


def test_what_is_written_as_c_has_it() -> None:
    plain: Any = load_controller("pid", ROBOT)
    steps = [controller_step(one, 0.005) for one in (plain, calibrated(plain, ROBOT, FOUND))]
    given = [np.linspace(0.1, 1.0, steps[0].function.size1_in(i)) for i in range(steps[0].function.n_in())]
    results = [step.function(*given)[1].full() for step in steps]
    assert results[0].shape == results[1].shape
    assert not np.array_equal(*results)


BAD: dict[str, tuple[dict[str, Any], str]] = {
    "another robot": ({"robot": "dragon"}, "was made for robot 'dragon'"),
    "another description": ({"robot_digest": "0"}, "another description"),
    "another number of rotors": ({"rotor_scale": {"value": [1.0, 1.0]}}, "2 rotor scales"),
    "no calibration": ({"format": "recipe"}, "is no calibration"),
    "no value": ({"cog_offset": {"low": 0.0}}, r"no table \[cog_offset\]"),
    "degrees": ({"attitude_misalignment": {"value": [3.0, 0.0, 0.0]}}, "attitude_misalignment"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_file_that_cannot_be_used_is_refused(name: str, tmp_path: Path) -> None:
    changes, said = BAD[name]
    with pytest.raises(ConfigError, match=said):
        skylimb.run("calibration", "pid", calibration=file_of(FOUND, tmp_path, **changes))


def test_the_command_line_refuses_it_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = file_of(FOUND, tmp_path, robot="dragon")
    for words in (
        ["run", "--calibration", str(path), "--out", str(tmp_path / "out")],
        ["export-c", "--calibration", str(path), str(tmp_path / "out")],
        ["campaign", "examples/campaign.toml", "--calibration", str(path), "--out", str(tmp_path / "out")],
    ):
        assert main(words) == 2
        assert "was made for robot 'dragon'" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_preset_in_a_file_may_hold_it(tmp_path: Path) -> None:
    mapping, _ = preset_mapping("pid")
    path = tmp_path / "mine.toml"
    path.write_text(tomli_w.dumps({**mapping, CALIBRATION: dataclasses.asdict(FOUND)}), "utf-8")
    made: Any = load_controller(str(path), ROBOT)
    assert made.corrections.cog_offset == FOUND.cog_offset
    assert read_corrections(file_of(FOUND, tmp_path)) == FOUND
