"""Laws in plain Python in their slots: every way to fly gives the bits of the same law compiled."""

import json
import logging
import re
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import skylimb
from short_flights import HOLD
from skylimb.analysis.report.output import write_records, write_scores
from skylimb.base.errors import ConfigError, UserCodeError
from skylimb.control.controller import load_controller
from skylimb.flight.drivers.compiled import CompiledDriver
from skylimb.flight.drivers.native import fly_native
from skylimb.flight.drivers.native.lockstep import LockStep
from skylimb.flight.drivers.world import world
from skylimb.flight.export import export_c
from skylimb.flight.flying import fly
from skylimb.flight.takeoff import Takeoff, take_off
from skylimb.studies.verification.stability.point import operating_point

LAWS = Path(__file__).parents[2] / "examples" / "laws"
LAW = (LAWS / "lqr.py").read_text(encoding="utf-8")
PRESET = (LAWS / "lqr.toml").read_text(encoding="utf-8")
PLAIN = {
    "plain": ("    acceleration =", "    float(K[0])\n    acceleration ="),
    # What prepare returns is no numbers: a function.
    "object": ("    return (B.T @ P)", "    return lambda: (B.T @ P)"),
}  # fmt: skip
CHANGE = {"kind": "gain", "time": 1.0, "key": "translation.position", "value": 4.0, "duration": 0.1}
SHORT = {**HOLD, "events": [CHANGE], "stop_at": 2.0}


@pytest.fixture
def presets(tmp_path: Path) -> dict[str, str]:
    """The LQR that ships, compiled, and the same with a line that needs numbers, by name."""
    texts = {"traced": LAW, **{name: LAW.replace(*change) for name, change in PLAIN.items()}}
    texts["object"] = texts["object"].replace("inputs, K):\n", "inputs, prepared):\n    K = prepared()\n")
    for name, text in texts.items():
        assert name == "traced" or text != LAW
        (tmp_path / f"{name}.py").write_text(text, encoding="utf-8")
        (tmp_path / f"{name}.toml").write_text(PRESET.replace("lqr.py", f"{name}.py"), encoding="utf-8")
    return {name: str(tmp_path / f"{name}.toml") for name in texts}


def flown(takeoff: Takeoff) -> np.ndarray:
    """The log of a whole flight by the driver that a run takes."""
    flight = fly(takeoff)
    assert flight.cause.startswith("stopped from outside at t = 2.000 s"), flight.cause
    return flight.signals[: flight.ticks]


def test_it_flies_the_bits_of_the_same_law_compiled(presets: dict[str, str]) -> None:
    traced, plain, prepared = (take_off("paper", (presets[name],), set=SHORT)[0] for name in presets)
    assert [one.compiled for one in (traced, plain, prepared)] == [True, False, False]
    expected = flown(traced)
    feedback = expected[:, traced.tick.signals.slices["lqr_feedback"]]
    # The gain of the event is live: K = [4, ...] becomes [2, ...].
    np.testing.assert_allclose(feedback[[0, -1], 0], [4.0, 2.0])
    np.testing.assert_array_equal(flown(plain), expected)
    np.testing.assert_array_equal(flown(prepared), expected)
    for flight in fly_native([plain, traced]):
        np.testing.assert_array_equal(flight.signals[: flight.ticks], expected)


def test_it_is_rewound_and_flown_again(presets: dict[str, str]) -> None:
    (takeoff,) = take_off("paper", (presets["plain"],), set=SHORT)
    here = world(takeoff)
    driver = CompiledDriver(takeoff.tick, here.plant, here.data, takeoff.rows, here.hooks, here.events.gains)
    for k in range(100):
        driver.tick(k)
    saved = driver.saved()
    for k in range(100, 300):
        driver.tick(k)
    before = driver.log[100:300].copy()
    driver.put_back(saved)
    for k in range(100, 300):
        driver.tick(k)
    np.testing.assert_array_equal(driver.log[100:300], before)


def test_a_replay_gives_its_commands_again(presets: dict[str, str]) -> None:
    run = skylimb.run("paper", presets["plain"], set=SHORT)
    again = skylimb.replay(run)
    for name in ("thrusts_command", "cog_position_estimate", "lqr_feedback"):
        np.testing.assert_array_equal(again.log[name].values, run.log[name].values)


def test_it_is_said_once_with_its_cost_and_its_reason(
    presets: dict[str, str], caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.WARNING, "skylimb"):
        skylimb.run("paper", presets["plain"], set=SHORT)
        skylimb.run("paper", presets["traced"], set=SHORT)
    (said,) = caplog.messages
    assert said.startswith("translation law 'plain.py' flies in Python, ")
    assert re.search(
        r" us a tick \(0\.\d+ control periods(, at worst \d[\d.]*)?\): "
        r".*plain\.py, line \d+, `float\(K\[0\]\)`: "
        r"float\(\), the functions",
        said,
    )


def test_what_several_take_is_said_of_them_together(
    presets: dict[str, str], tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "still.py").write_text(
        "class Gains: ...\ndef initial_state(gains, start): return ()\n"
        "def step(gains, state, inputs, R_target): return state, [float(0 * x) for x in R_target[0]], {}\n"
    )
    still = tmp_path / "still.py"
    still.write_text(f"from dataclasses import dataclass\n@dataclass(frozen=True)\n{still.read_text()}")
    with caplog.at_level(logging.WARNING, "skylimb"):
        skylimb.run("paper", presets["plain"], set={**SHORT, "controller.attitude.law": str(still)})
    (said,) = caplog.messages
    assert re.match(
        r"translation law 'plain\.py' and attitude law '.*still\.py' fly in Python, \d+ us a tick \(.*\) "
        r"together: .*plain\.py, line .*; .*still\.py, line ",
        said,
    )


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("SOLVER.integral += 1e-3 * (float(K[0]) < 2.5)", r"at t = 1\.\d+ s \(by 0\.001\)"),
        ("K = K * (1 + 0.001 * np.random.rand() * (float(K[0]) < 2.5))", r"at t = 1\.\d+ s \(by "),
        ("float(K[0])", ""),
    ],
)
def test_a_law_that_remembers_or_draws_in_flight_is_a_note_of_the_run(
    presets: dict[str, str], tmp_path: Path, line: str, told: str
) -> None:
    solver = "\n\nclass Solver:\n    integral = 0.0\n\n\nSOLVER = Solver()\n\n\ndef initial_state"
    text = LAW.replace("\n\ndef initial_state", solver, 1).replace(
        "    acceleration =", f"    {line}\n    acceleration ="
    )
    text = text.replace('"lqr_feedback": K', '"lqr_feedback": K + SOLVER.integral')
    (tmp_path / "plain.py").write_text(text, encoding="utf-8")
    run = skylimb.run("paper", presets["plain"], set=SHORT)
    if not told:
        assert run.notes == ()
        return
    (note,) = run.notes
    assert re.match(
        f"this run cannot be repeated: translation law 'plain.py': step gives another result .* {told}", note
    )
    write_records({run.name: run}, tmp_path / "out")
    write_scores({run.name: run}, tmp_path / "out")
    assert json.loads((tmp_path / "out" / "metrics.json").read_text("utf-8"))["notes"] == [note]
    assert skylimb.Run.load(tmp_path / "out" / "log.nc").notes == (note,)


@pytest.mark.parametrize("whole", [False, True])
def test_a_law_that_takes_longer_than_its_period_is_a_note_of_the_run(
    presets: dict[str, str], tmp_path: Path, whole: bool
) -> None:
    set: dict[str, Any] = {**HOLD, "stop_at": 0.3}
    controller: Any = presets["plain"]
    if whole:
        controller = Slow(load_controller("hybrid", skylimb.load_robot("hydrus_xi_quad")))
    else:
        late = PLAIN["plain"][1].replace("    float(K[0])", "    time.sleep(0.012 + 0.0 * float(K[0]))")
        text = "import time\n" + LAW.replace(PLAIN["plain"][0], late)
        (tmp_path / "plain.py").write_text(text, encoding="utf-8")
    run = skylimb.run("paper", controller, set=set)
    note = run.notes[0]
    who = "controller 'slow'" if whole else "what flies in Python"
    assert re.match(
        rf"{who} takes ([2-9]|\d\d)(\.\d)? times the control period of 5 ms: a robot does not wait", note
    )


class Slow:
    """A controller that takes more than two control periods."""

    name = "slow"

    def __init__(self, inner: Any) -> None:
        self.inner = inner
        self.gains, self.initial_state = inner.gains, inner.initial_state

    def step(self, *given: Any) -> Any:
        time.sleep(0.012)
        return self.inner.step(*given)


def test_what_cannot_be_done_with_it_is_refused_by_name(presets: dict[str, str], tmp_path: Path) -> None:
    cascade = load_controller(presets["plain"], skylimb.load_robot("hydrus_xi_quad"))
    with pytest.raises(ConfigError, match=r"^translation law 'plain\.py' flies in Python and cannot be wri"):
        export_c(cascade, tmp_path / "c")
    with pytest.raises(ConfigError, match=r"^translation law 'plain\.py' flies in Python and cannot be lin"):
        operating_point(skylimb.load_experiment("paper"), cascade)  # type: ignore[arg-type]


def test_lock_step_refuses_it_with_the_line(presets: dict[str, str]) -> None:
    (takeoff,) = take_off("paper", (presets["plain"],), set=SHORT)
    told = (
        r"flies in Python, not in lock-step, .*\(translation law 'plain\.py': .*line \d+, `float\(K\[0\]\)`"
    )
    with pytest.raises(ConfigError, match=told):
        LockStep([takeoff], 1)


def test_an_error_in_flight_ends_it_with_its_log(presets: dict[str, str], tmp_path: Path) -> None:
    text = (tmp_path / "plain.py").read_text(encoding="utf-8")
    late = "    if float(K[0]) < 2.5:\n        {}\n    acceleration ="
    for what, told in (
        ("raise ValueError('too soft')", r"translation law 'plain\.py' fails in .*, line \d+, .*too soft"),
        ("return state, body.position[0:2], {'lqr_feedback': K}",
         r"law 'plain\.py' in .*, line \d+, `return state, body.*: step returns other things than at load: "
         r"output: got shape \(2,\), expected "),
        ("return state, body.position, {}", "signals: got no entries, expected the entries lqr_feedback"),
        ("return state, np.nan * body.position, {'lqr_feedback': K}",
         r"law 'plain\.py' in .*, line \d+, `return state, np\.nan .*: step returns output: \[nan, "),
    ):  # fmt: skip
        changed = text.replace("    acceleration =", late.format(what))
        (tmp_path / "plain.py").write_text(changed, encoding="utf-8")
        run = skylimb.run("paper", presets["plain"], set=SHORT)
        assert run.failed
        assert re.search(rf"^broken off at t = 1\.0[0-9]5 s: .*{told}", run.cause)
        assert 1.0 < run.log.time.values[-1] < 1.1


def test_prepare_that_fails_names_its_line(presets: dict[str, str], tmp_path: Path) -> None:
    text = LAW.replace("    cost =", "    assert gains.position > 5.0, 'too cheap'\n    cost =")
    (tmp_path / "traced.py").write_text(text, encoding="utf-8")
    with pytest.raises(UserCodeError, match=r"'traced\.py' fails in .*line 29.*too cheap"):
        skylimb.run("paper", presets["traced"], set=SHORT)
