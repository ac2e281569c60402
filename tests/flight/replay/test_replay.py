"""A recorded flight through estimator and controller again: the same bits, or what would have been."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import skylimb
from skylimb.analysis.report.controller_replay import differences, differences_table, only_in
from skylimb.analysis.scores.registry import SCORES, measured
from skylimb.apps.cli.main import main
from skylimb.base.errors import ConfigError, UnknownNameError
from skylimb.control.corrections import Corrections
from skylimb.control.supervisor.table import TABLE
from skylimb.flight.flying import fly
from skylimb.flight.replay.replay import _back
from skylimb.flight.simulated_run import scored_run
from skylimb.flight.takeoff import Takeoff

EXAMPLES = Path(__file__).parents[3] / "examples"
POSE = ("root_position_measured", "root_quaternion_measured")
SENSED = (*POSE, "joint_angles_measured", "vectoring_angles_measured")
Make = Callable[..., Takeoff]


@pytest.fixture(scope="module")
def flown(make_takeoff: Make) -> skylimb.Run:
    takeoff = make_takeoff(controller="hybrid")
    return scored_run(takeoff, fly(takeoff))


def bare(run: skylimb.Run, *names: str, every: int = 1, start: float = 0.0) -> skylimb.Run:
    """What the log of a real robot may hold: a few signals, another clock, no configuration."""
    log = run.log[list(names)].isel(time=slice(None, None, every))
    return skylimb.Run("real", "", log.assign_coords(time=log.time.values + start).assign_attrs(config=""))


def force(run: skylimb.Run) -> np.ndarray:
    return run.log.external_force_estimate.values


def require_same_bits(run: skylimb.Run, replayed: skylimb.Run, least: int) -> None:
    found = differences(run, replayed)
    assert len(found) >= least
    assert [one.signal for one in found if not one.same] == []
    assert only_in(run, replayed) == only_in(replayed, run) == []
    assert replayed.notes == ()


@pytest.mark.parametrize("controller", ["hybrid", str(EXAMPLES / "laws" / "preview.toml")])
def test_what_was_recorded_comes_out_again(make_takeoff: Make, controller: str) -> None:
    takeoff = make_takeoff(controller=controller, set={"surface.friction": 0.4})
    run = scored_run(takeoff, fly(takeoff))
    assert run.status == "OK", run.cause
    require_same_bits(run, skylimb.replay(run), 17)


def test_a_clock_that_was_held_back_is_followed(make_takeoff: Make) -> None:
    takeoff = make_takeoff(controller="following", set={"surface.advance_distance": -0.03})
    run = scored_run(takeoff, fly(takeoff))
    late = run.log.time.values - run.log.mission_time.values
    assert late[-1] > 0.1
    assert np.any(late % takeoff.period > 1e-5)  # between two rows of the mission
    require_same_bits(run, skylimb.replay(run), 27)


def test_gains_that_changed_in_flight_change_again(make_takeoff: Make) -> None:
    change = {"kind": "gain", "time": 0.6, "key": "estimation.observer.force", "value": [9.0, 9.0, 9.0]}
    takeoff = make_takeoff(set={"events": [change]})
    run = scored_run(takeoff, fly(takeoff))
    require_same_bits(run, skylimb.replay(run), 17)
    other = skylimb.replay(run, str(EXAMPLES / "user_controller.py"))
    assert "has no gain 'estimation.observer.force'" in " ".join(other.notes)


def test_a_replay_counts_since_when_poses_are_back_as_the_supervisor_does() -> None:
    # No pose yet, the first ones, a gap of two ticks, and poses again.
    unseen = np.array([1, 1, 0, 0, 1, 1, 0, 0])
    words = unseen * 2.0 ** list(TABLE.bits).index("stale") + 2.0 ** list(TABLE.bits).index("late")
    log = xr.Dataset({"supervisor_bits": ("time", words)})
    far = np.inf
    np.testing.assert_allclose(_back(log, 0.005), [far, far, far, far, 0.0, 0.0, 0.005, 0.01])
    assert (_back(xr.Dataset({"time": np.arange(3.0)}), 0.005) == far).all()


@pytest.mark.parametrize("compiled", [True, False])
def test_a_users_controller_is_replayed(make_takeoff: Make, tmp_path: Path, compiled: bool) -> None:
    text = (EXAMPLES / "user_controller.py").read_text(encoding="utf-8")
    if not compiled:
        first = "        model = self.robot.at(measurement.joint_angles"
        assert first in text
        text = text.replace(first, f"        assert reference.reach < 9.0\n{first}")
    file = tmp_path / "mine.py"
    file.write_text(text, encoding="utf-8")
    short = {"approach.speed": 0.3, "trajectory.shape": "hold", "trajectory.duration": 0.2}
    takeoff = make_takeoff(controller=str(file), set=short)
    assert takeoff.traceable == compiled
    run = scored_run(takeoff, fly(takeoff))
    require_same_bits(run, skylimb.replay(run), 4)


def test_another_observer_sees_the_same_push(make_takeoff: Make, flown: skylimb.Run) -> None:
    """The estimator works with the thrusts that were flown, not those that this controller commands."""
    replayed = skylimb.replay(flown, "following")
    commanded = replayed.log.thrusts_command.values - flown.log.thrusts_command.values
    assert abs(commanded).max() > 3.0  # open loop, nothing follows what it commands
    late = flown.log.time.values > 1.0
    apart = abs(force(replayed) - force(flown))[late]
    assert np.median(apart) < 0.3
    assert apart.max() < 1.5
    assert "pace" in only_in(replayed, flown)


def test_the_mission_is_that_of_the_flight(flown: skylimb.Run) -> None:
    """Also where the replayed controller would take off with other vectoring angles."""
    assert skylimb.replay(flown, "following").notes == ()
    (note,) = skylimb.replay(flown, set={"trajectory.radius": 0.1}).notes
    assert note.startswith("the mission is another than was flown: up to 0.")


def test_a_gain_changes_what_is_estimated(flown: skylimb.Run) -> None:
    slow = skylimb.replay(flown, set={"controller.estimation.observer.force": [0.5, 0.5, 0.5]})
    found = {one.signal: one for one in differences(flown, slow)}
    assert found["external_force_estimate"].rms > 0.02
    assert found["cog_position_estimate"].same
    np.testing.assert_array_equal(slow.log.contact_force, flown.log.contact_force)


def test_a_calibrated_flight_and_a_calibrated_replay(make_takeoff: Make) -> None:
    robot = skylimb.load_robot("hydrus_xi_quad")
    found = Corrections(
        robot=robot.name, robot_digest=robot.description.digest, rotor_scale=(0.95, 1.03, 0.98, 1.01)
    )
    hover = {"trajectory.shape": "hold", "trajectory.duration": 0.2, "approach.contact": False}
    real = {**hover, "plant.rotor_scale": list(found.rotor_scale)}
    knowing = skylimb.run("paper", "hybrid", set=real, calibration=found)
    require_same_bits(knowing, skylimb.replay(knowing), 17)
    plain = skylimb.run("paper", "hybrid", set=real)
    seen = skylimb.replay(plain, calibration=found)
    bias = [abs(run.log.external_force_bias.values[-1]).max() for run in (plain, seen)]
    assert bias[1] < 0.3 * bias[0]


def test_a_log_of_a_real_robot_lacks_things(flown: skylimb.Run) -> None:
    run = bare(flown, *SENSED, "thrusts_command", every=2, start=1.7e9)
    replayed = skylimb.replay(run, "hybrid")
    said = "\n".join(replayed.notes)
    for words in (
        "no configuration: robot hydrus_xi_quad, 200 Hz",
        "rows at 100 Hz: at each 200 Hz tick the last one",
        "no root_velocity_measured: differences of the positions",
        "no root_angular_velocity_measured: differences of the attitudes",
        "no cog_position_reference",
        "no phase: the force estimate is not tared",
    ):
        assert words in said
    assert replayed.log.time.values[0] == 0.0
    np.testing.assert_allclose(np.diff(replayed.log.time), 0.005, atol=1e-9)
    # The untared force still shows the push on the wall, through the noise of the differences.
    tail = force(flown)[: replayed.log.sizes["time"]]
    smooth = np.ones(100) / 100
    seen, was = (np.convolve(values[:, 0], smooth, "valid") for values in (force(replayed), tail))
    assert np.corrcoef(seen, was)[0, 1] > 0.8


def test_without_thrusts_the_wrench_means_nothing_and_that_is_said(flown: skylimb.Run) -> None:
    said = " ".join(skylimb.replay(bare(flown, *POSE), "hybrid").notes)
    assert "no thrusts_command: the estimator gets what the replayed controller commands" in said
    assert "no vectoring_angles_measured: those of the nominal posture" in said


def test_a_configuration_in_other_words_is_none(flown: skylimb.Run) -> None:
    run = bare(flown, *SENSED, "thrusts_command")
    foreign = dataclasses.replace(run, log=run.log.assign_attrs(config="speed: fast"))
    replayed = skylimb.replay(foreign, "hybrid")
    found = differences(skylimb.replay(run, "hybrid"), replayed)
    assert len(found) > 5
    assert all(one.same for one in found)
    assert "no configuration" in " ".join(replayed.notes)


def test_rows_that_are_no_numbers_are_held(flown: skylimb.Run) -> None:
    run = bare(flown, *SENSED, "thrusts_command")
    run.log["root_position_measured"] = run.log.root_position_measured.copy()
    run.log.root_position_measured.values[[0, 7, 8]] = np.nan
    replayed = skylimb.replay(run, "hybrid")
    assert "root_position_measured: 3 of" in " ".join(replayed.notes)
    assert np.isfinite(force(replayed)).all()


def test_a_log_without_a_pose_is_refused(flown: skylimb.Run) -> None:
    with pytest.raises(ConfigError, match="no 'root_quaternion_measured': without a measured pose"):
        skylimb.replay(bare(flown, POSE[0]))
    odd = bare(flown, *POSE)
    odd.log["joint_angles_measured"] = (("time", "two"), odd.log.root_position_measured.values[:, :2])
    with pytest.raises(ConfigError, match=r"'joint_angles_measured' of the log has the shape \(2,\)"):
        skylimb.replay(odd)
    back = bare(flown, *POSE)
    with pytest.raises(ConfigError, match=r"does not rise: 0\.005 s comes after 0\.01 s"):
        skylimb.replay(dataclasses.replace(back, log=back.log.isel(time=[0, 2, 1])))
    with pytest.raises(UnknownNameError, match="hybrid"):
        skylimb.replay(flown, "hybird")


def test_the_command_holds_an_estimate_against_the_truth_where_that_is_known(
    flown: skylimb.Run,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # What is printed is looked at; the figures are in the test below.
    monkeypatch.setattr("skylimb.analysis.report.replay_folder.replayed_figures", lambda *_: {})
    flown.save(tmp_path / "log.nc")
    other = ["--set", "controller.estimation.law=kalman"]
    assert main(["replay", str(tmp_path / "log.nc"), *other, "--out", str(tmp_path / "kalman")]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "Held against the true force" in out
    found = measured(skylimb.replay(flown, set={"controller.estimation.law": "kalman"}), ["estimate"])
    assert SCORES["estimate_noise"].printed(found["estimate_noise"]) in out
    untold = dataclasses.replace(flown, log=flown.log.drop_vars("contact_force"))
    untold.save(tmp_path / "real.nc")
    assert main(["replay", str(tmp_path / "real.nc"), *other, "--out", str(tmp_path / "real")]) == 0
    assert "true force" not in capsys.readouterr().out


def test_the_command_leaves_a_folder(
    flown: skylimb.Run, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "flown").mkdir()
    flown.save(tmp_path / "flown" / "log.nc")
    assert main(["replay", str(tmp_path / "flown"), "--out", str(tmp_path / "same")]) == 0
    assert f"at {flown.log.sizes['time']} ticks: the recorded ones to the bit" in capsys.readouterr().out
    words = ["--controller", "pid", "--out", str(tmp_path / "other")]
    assert main(["replay", str(tmp_path / "flown" / "log.nc"), *words]) == 0
    out = capsys.readouterr().out
    assert "hybrid recorded, pid replayed" in out
    assert "force_command" in out
    names = {path.relative_to(tmp_path / "other").as_posix() for path in (tmp_path / "other").rglob("*.*")}
    assert {"log.nc", "config.toml", "differences.csv", "figures/estimates.png"} <= names
    replayed = skylimb.Run.load(tmp_path / "other")
    assert (replayed.name, replayed.controller) == ("pid, replayed", "pid")
    assert (tmp_path / "other" / "differences.csv").read_text() == differences_table(
        differences(flown, replayed)
    )
    assert main(["report", str(tmp_path / "other")]) == 2
    assert "is a replay and is not scored: nothing flew in it" in capsys.readouterr().err
    assert not (tmp_path / "other" / "report.html").exists()
    assert main(["runs", str(tmp_path)]) == 0
    assert capsys.readouterr().out.count("a replay") == 2
    assert main(["replay", str(tmp_path / "none"), "--out", str(tmp_path / "no")]) == 2
    assert not (tmp_path / "no").exists()
