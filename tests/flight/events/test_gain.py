"""Gains change in flight, and no command jumps."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import skylimb
from skylimb.apps.cli import main
from skylimb.base.errors import ConfigError, UnknownNameError
from skylimb.flight.events import GainChange, event_tables, events_from_mapping
from skylimb.flight.events.gain import gain_rows

CONTROLLER = SimpleNamespace(gains=lambda: {"a": 1.0, "b": np.array([10.0, 20.0])})
TIMES = np.arange(101) * 0.05
SHORT = {
    "phases.hover": 1.0,
    "phases.tare": 1.0,
    "phases.settle": 2.0,
    "phases.hover_end": 0.2,
    "approach.speed": 0.1,
    "trajectory.shape": "hold",
    "trajectory.duration": 9.0,
    "surface.slope": 0.0,
}


def change(time: float, key: str, value: object, **more: object) -> dict[str, object]:
    return {"kind": "gain", "time": time, "key": key, "value": value, **more}


def test_a_change_is_a_straight_line_to_the_new_value() -> None:
    rows = gain_rows([GainChange(1.0, "b", (10.0, 40.0), duration=0.5)], CONTROLLER, TIMES)
    np.testing.assert_array_equal(rows.columns, [1, 2])
    np.testing.assert_allclose(rows.values[:, 1], np.interp(TIMES, [1.0, 1.5], [20.0, 40.0]), atol=1e-12)
    np.testing.assert_array_equal(rows.values[TIMES >= 1.5 + 1e-9], [[10.0, 40.0]] * 70)


def test_changes_of_one_gain_follow_one_another_without_a_jump() -> None:
    changes = [
        GainChange(1.25, "a", 0.0, duration=1.0),
        GainChange(1.0, "a", 2.0, duration=0.5),
        GainChange(4.0, "b", (0.0, 0.0), duration=0.0),
    ]
    rows = gain_rows(changes, CONTROLLER, TIMES)
    np.testing.assert_allclose(
        rows.values[:, 0], np.interp(TIMES, [1.0, 1.25, 2.25], [1.0, 1.5, 0.0]), atol=1e-12
    )
    np.testing.assert_array_equal(rows.values[79:81, 1:], [[10.0, 20.0], [0.0, 0.0]])


def test_an_experiment_keeps_its_changes_and_mentions_none_otherwise() -> None:
    changes = [
        change(5, "translation.force", 2),
        change(6.0, "estimation.observer.force", [3, 3, 3], duration=1.0),
    ]
    experiment = skylimb.load_experiment("paper", set={"events": changes})
    assert experiment.events == (
        GainChange(5.0, "translation.force", 2.0),
        GainChange(6.0, "estimation.observer.force", (3.0, 3.0, 3.0), duration=1.0),
    )
    assert events_from_mapping(event_tables(experiment.events), "a table") == experiment.events
    assert "events" not in skylimb.load_experiment("paper").to_mapping()


FORCE, TOUCH = "translation.force", "contact.machine.touch_force"


@pytest.mark.parametrize(
    ("controller", "wrong", "error", "message"),
    [
        ("following", change(5.0, "translation.forse", 2.0), UnknownNameError, f"did you mean '{FORCE}'"),
        ("pid", change(5.0, FORCE, 2.0), UnknownNameError, "controller pid"),
        ("following", change(5.0, "estimation.calibration.feed", 1.0), UnknownNameError, "calibration.feed"),
        ("following", change(5.0, FORCE, 99.0), ConfigError, r"outside of 0 .. 20 N"),
        ("following", change(5.0, FORCE, [1.0, 2.0]), ConfigError, "wrong type"),
        ("following", change(-1.0, FORCE, 2.0), ConfigError, r"events\.0\.time = -1 s"),
        (
            "following",
            change(5.0, TOUCH, -1.0),
            ConfigError,
            "above 0 and at most 100 N",
        ),
        (
            "following",
            change(5.0, "estimation.delay.latency", 0.19),
            ConfigError,
            r"^gain at 5 s, controller following: estimation\.delay\.latency = 0\.19 s .* at most 0\.125 s",
        ),
        ("following", change(500.0, FORCE, 2.0), ConfigError, "after the flight's end"),
        ("following", {"kind": "gain", "time": 5.0, "key": FORCE}, ConfigError, "value' is missing"),
        ("following", change(5.0, FORCE, 2.0, duraton=1.0), UnknownNameError, "duration"),
    ],
)
def test_a_change_that_does_not_fit_is_refused_before_take_off(
    controller: str, wrong: dict[str, object], error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        skylimb.run("paper", controller=controller, set={**SHORT, "events": [wrong]})


def test_a_controller_of_ones_own_cannot_be_changed(tmp_path: Path) -> None:
    file = tmp_path / "own.py"
    file.write_text(
        "import skylimb\n\nclass Own:\n    name = 'own'\n    def gains(self): ...\n"
        "    def initial_state(self): ...\n"
        "    def step(self, gains, state, measurement, reference, dt):\n"
        "        angles = measurement.joint_angles, measurement.vectoring_angles\n"
        "        return state, skylimb.Command([float(reference.reach)] * 4, *angles), {}\n\n"
        "def controller(robot):\n    return Own()\n"
    )
    with pytest.raises(ConfigError, match="'own' flies in Python"):
        skylimb.run("paper", controller=str(file), set={"events": [change(5.0, "k", 1.0)]})


def test_the_command_line_says_what_is_wrong(capsys: pytest.CaptureFixture[str]) -> None:
    setting = 'events=[{kind = "gain", time = 5.0, key = "translation.stifness", value = [5.0, 5.0, 5.0]}]'
    assert main(["run", "paper", "--controller", "following", "--no-video", "--set", setting]) == 2
    assert "did you mean 'translation.stiffness'" in capsys.readouterr().err


def largest_jump(run: skylimb.Run, begin: float, end: float) -> float:
    within = (run.log.time.values >= begin) & (run.log.time.values < end)
    return float(np.linalg.norm(np.diff(run.log.force_command.values[within], axis=0), axis=1).max())


def test_the_new_force_is_pressed_with_and_the_command_does_not_jump() -> None:
    begin = 9.5
    changes = [change(begin, FORCE, 2.0), change(begin, "translation.press_damping", 4.0)]
    before = skylimb.run("paper", controller="following", set=SHORT)
    after = skylimb.run("paper", controller="following", set={**SHORT, "events": changes})
    assert before.status == after.status == "OK"
    same = before.log.time.values < begin
    forces = [run.log.force_command.values[same[: run.log.sizes["time"]]] for run in (before, after)]
    np.testing.assert_array_equal(*forces)
    usual = largest_jump(before, begin - 2.0, begin + 1.0)
    assert largest_jump(after, begin - 0.02, begin + 0.7) < 1.5 * usual
    settled = (after.log.time.values > begin + 3.5) & (after.log.time.values < begin + 5.0)
    force = after.log.normal_force_estimate.values[settled].mean()
    assert force == pytest.approx(2.0, abs=0.4)
    abrupt = [change(begin, FORCE, 4.0, duration=0.0)]
    jump = skylimb.run("paper", controller="following", set={**SHORT, "events": abrupt})
    assert largest_jump(jump, begin - 0.02, begin + 0.02) > 2.0 * usual
