"""Robots of two and three rotors whose joints turn them: they hover, touch and draw through every door."""

from __future__ import annotations

import subprocess
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import skylimb
from armed_robots import multirotor_with_arm
from skylimb.analysis.report.controller_replay import differences
from skylimb.control.controller import is_traceable
from skylimb.control.supervisor.limits import Limits
from skylimb.control.supervisor.supervised import SHARES
from skylimb.flight.export import export_c
from strict_c import StrictC

STICK: dict[str, Any] = {"joints": (), "stick": 0.45, "turning": 1.5}
ROBOTS: dict[str, dict[str, Any]] = {
    "tricopter": {**STICK, "rotors": 3, "mass": 1.2},
    "tail": {**STICK, "rotors": 3, "mass": 1.2, "fixed": (0, 2)},
    "bicopter": {**STICK, "rotors": 2, "mass": 0.8, "layers": (0.15,), "mount": "0.1 0 0"},
}
"""Each arm turns; only the tail does; rotors above the stick, for a lever about the axis through both."""

BOARD, FREE = "board_tilted_hexarotor", {"posture.waypoints": [], "stop_at": 4.0}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A robot of each kind, imported from its URDF."""
    made = tmp_path_factory.mktemp("few")
    with pytest.MonkeyPatch.context() as patch:  # nobody looks at their pictures
        patch.setattr("skylimb.apps.robot_import.writing.draw_robot", lambda *_: None)
        for name, given in ROBOTS.items():
            report = skylimb.import_robot(multirotor_with_arm(made / f"{name}.urdf", **given), made / name)
            assert report.can_hover, report.reasons
            assert report.can_touch, report.reasons
    return made


def flown(robot: Path, experiment: str, controller: str, **changes: Any) -> skylimb.Run:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return skylimb.run(experiment, controller, set={"robot": str(robot), **changes})


@pytest.mark.parametrize("controller", ["hybrid", "following", "drawing"])
@pytest.mark.parametrize("name", ROBOTS)
def test_it_hovers(folder: Path, name: str, controller: str) -> None:
    run = flown(folder / name, "free_flight", controller, **FREE)
    assert run.status == "STOPPED", run.cause
    log = run.log
    off = (log.cog_position - log.cog_position_reference).values[log.time.values > 3.0]
    assert np.abs(off).max() < 0.03
    # What a log holds is what the robot has: thrusts and angles.
    assert log.thrusts_command.shape[1] == ROBOTS[name]["rotors"]
    assert log.vectoring_angles_command.shape[1] == len(log.vectoring)
    if SHARES in log:
        np.testing.assert_allclose(log[SHARES].values[-1], 1.0)


@pytest.mark.slow
@pytest.mark.parametrize("controller", ["following", "drawing"])
@pytest.mark.parametrize(("name", "force"), [("tricopter", 1.0), ("tail", 0.5), ("bicopter", 0.5)])
def test_it_draws_on_a_board(folder: Path, name: str, force: float, controller: str) -> None:
    run = flown(folder / name, BOARD, controller, **{"controller.translation.force": force})
    assert run.metrics["done"], run.metrics["missed"]
    assert run.metrics["pen_line_rms"] < 0.008


@pytest.mark.parametrize("known", [True, False])
def test_laws_have_to_know_the_momentum_of_what_servos_turn(folder: Path, known: bool) -> None:
    """A servo that turns a rotor turns the robot too: with poses 28 ms old it falls by that."""
    changes = {"controller.allocation.rotor_lag.reaction": known, "sensors.latency": 0.028}
    run = flown(folder / "tail", "free_flight", "following", **{**FREE, "stop_at": 12.0}, **changes)
    assert run.status == ("STOPPED" if known else "FAILED"), run.cause


@pytest.mark.parametrize(("controller", "least"), [("hybrid", 0.0), ("following", 1e-12)])
def test_a_replay_says_what_was_flown(folder: Path, controller: str, least: float) -> None:
    """To the bit; where a flight's expressions are others than a replay's, to rounding."""
    run = flown(folder / "bicopter", "free_flight", controller, **FREE)
    found = differences(run, skylimb.replay(run))
    assert len(found) > 10
    assert max(one.largest for one in found) <= least


@pytest.mark.parametrize("losses", [False, True])
def test_exported_c_commands_thrusts_and_angles(
    folder: Path, tmp_path: Path, losses: bool, strict_c: StrictC
) -> None:
    controller = skylimb.load_controller("following", skylimb.load_robot(str(folder / "tail")))
    assert is_traceable(controller)
    made = tmp_path / "c"
    export_c(controller, made, limits=Limits(losses=losses))
    sources = [made / name for name in ("main.c", "controller.c", "controller_function.c")]
    strict_c.link(sources, tmp_path / "example", "-lm")
    said = subprocess.run([tmp_path / "example"], capture_output=True, text=True, check=True).stdout
    assert "largest difference" in said


def test_a_rotor_that_is_lost_is_cut(folder: Path) -> None:
    """Nobody flies on without one of two rotors; the supervisor says so, and no command is no number."""
    lost = [{"kind": "rotor", "time": 2.0, "rotor": "rotor1", "effectiveness": 0.0}]
    run = flown(folder / "bicopter", "free_flight", "following", **{"posture.waypoints": [], "events": lost})
    assert run.status == "FAILED"
    assert np.all(np.isfinite(run.log.thrusts_command.values))
    assert run.log.thrusts_command.values[-1].max() < 1.0
