"""A user's own controller: gains like everyone's, compiled where it can be, and told why where it cannot."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import skylimb
from skylimb.base.config import write_toml
from skylimb.base.errors import ConfigError, UnknownNameError, UserCodeError
from skylimb.control.controller import (
    Controller,
    controller_of,
    controller_units,
    is_configurable,
    is_traceable,
    load_controller,
    resolved_tables,
)
from skylimb.control.laws.user_controller import CompiledUserController, UserController
from skylimb.robots.model import Robot

TEXT = '''
from dataclasses import dataclass
from typing import Annotated
import math, random
import numpy as np
from skylimb import Command
from skylimb.base.keys import Key, configuration
from skylimb.symbolic import vector, where

@configuration
class Gains:
    """Of the test."""
    pull: Annotated[float, Key("N/m", "pull", low=0.0, high=10.0)] = 2.0
    push: Annotated[tuple[float, float], Key("N", "push", low=0.0, high=10.0)] = (1.0, 3.0)

CALLS = []

class Kept:
    calls = 0
    seen = 0

class Own:
    name = "own"
    def __init__(self, robot):
        self.robot, self.count, self.seen, self.kept = robot, 0, [], Kept()
    def gains(self): return Gains()
    def initial_state(self): return {"sum": 0.0}
    def step(self, gains, state, measurement, reference, dt):
        total = state["sum"] + gains.pull * measurement.position[2] * dt
        x = measurement.position[0]
        STEP
        thrusts = vector(total, x, gains.push[0], gains.push[1])
        return {"sum": total}, Command(thrusts, reference.joint_angles, reference.vectoring_angles), {"x": x}

def controller(robot):
    return Own(robot)
'''


COMMAND = "Command(vector(x, x, x, x), reference.joint_angles, reference.vectoring_angles)"


def made(folder: Path, robot: Robot, step: str = "", gains: dict[str, Any] | None = None) -> Any:
    (folder / "own.py").write_text(TEXT.replace("STEP", step), encoding="utf-8")
    return load_controller(str(folder / "own.py"), robot, gains)


def test_a_step_of_plain_operators_is_compiled(tmp_path: Path, robot: Robot) -> None:
    own = made(tmp_path, robot)
    assert is_traceable(own)
    assert isinstance(own, CompiledUserController)
    assert own.gains().pull == 2.0
    assert own.gains().push.tolist() == [1.0, 3.0]


@pytest.mark.parametrize(
    ("step", "why"),
    [
        ("x = x if x > 0 else 0.0", r"own\.py, line \d+, `x = x if .*`.*skylimb\.symbolic\.where"),
        ("self.count += 1; x = x + self.count", "its step changes its own 'count'"),
        ("self.seen.append(1); x = x + len(self.seen)", "its step changes its own 'seen'"),
        (
            "Kept.calls += 1; x = x if Kept.calls < 600 else 0.0 * x",
            r"changes its own 'Kept\.calls'",
        ),
        ("CALLS.append(1); x = x if len(CALLS) < 600 else 0.0 * x", "its step changes its own 'CALLS'"),
        (
            "self.kept.seen += 1; x = x if self.kept.seen < 600 else 0.0 * x",
            r"its step changes its own 'kept\.seen'",
        ),
        ("x = x + random.random()", "on symbols its step gives another 'thrusts' than on numbers"),
        ("x = math.sin(x)", r"`x = math\.sin\(x\)`: float\(\), the functions of math"),
        ("state = 3", r"^$"),
        (
            f"return {{'sum': vector(x, x)}}, {COMMAND}, {{}}",
            r"the new state of .* has the shapes .*\(2,\).*initial",
        ),
        # A state that is a number: what is returned is no vector of symbols.
        (f"return {{'sum': total}}, {COMMAND}, {{'up': 1}}", r"^$"),
    ],
)
def test_a_step_that_cannot_be_compiled_says_why(tmp_path: Path, robot: Robot, step: str, why: str) -> None:
    own = made(tmp_path, robot, step)
    assert re.search(why, own.untraceable), own.untraceable
    assert is_traceable(own) == (why == "^$")
    assert isinstance(own, UserController)
    assert own.made.count == 0, "the trial spoils the object that will fly"
    assert own.made.seen == []


def test_its_gains_are_keys_like_everyones(tmp_path: Path, robot: Robot) -> None:
    own = made(tmp_path, robot, gains={"pull": 3, "push.1": 4.0})
    assert own.gains().pull == 3.0
    assert own.gains().push.tolist() == [1.0, 4.0]
    assert resolved_tables(own) == {
        "name": "own",
        "file": (tmp_path / "own.py").as_posix(),
        "pull": 3.0,
        "push": [1.0, 4.0],
    }
    assert controller_units(own) == {"pull": "N/m", "push": "N"}
    assert own.sources[0].path == (tmp_path / "own.py").resolve()
    own.check_gain("pull", 4.0, "here", 0.005)
    for key, value, message in (
        ("pull", 11.0, r"^controller 'own': pull = 11 N/m is outside"),
        ("pul", 1.0, r"unknown key 'pul'; did you mean 'pull'"),
        ("push", [1.0], r"push = \[1.0\] has 1 entries, it needs 2"),
    ):
        with pytest.raises(ConfigError, match=message):
            made(tmp_path, robot, gains={key: value})
    with pytest.raises(ConfigError, match=r"^here: pull"):
        own.check_gain("pull", 11.0, "here", 0.005)


def test_a_gain_changes_without_a_new_trace(tmp_path: Path, robot: Robot) -> None:
    one, other = made(tmp_path, robot), made(tmp_path, robot, gains={"pull": 3.0})
    assert one.made is not other.made
    assert one.structure() == other.structure()
    assert made(tmp_path, robot, "x = 2 * x").structure() != one.structure()


def test_gains_that_are_no_dataclass_cannot_be_set(tmp_path: Path, robot: Robot) -> None:
    text = TEXT.replace("return Gains()", "return {'pull': 1.0, 'push': [1.0, 3.0]}")
    text = (
        text.replace("STEP", "").replace("gains.pull", "gains['pull']").replace("gains.push", "gains['push']")
    )
    (tmp_path / "own.py").write_text(text, encoding="utf-8")
    own = load_controller(str(tmp_path / "own.py"), robot)
    assert resolved_tables(own).keys() == {"name", "file"}
    with pytest.raises(
        ConfigError, match=r"where `gains\(\)` returns a frozen dataclass; here it returns dict"
    ):
        load_controller(str(tmp_path / "own.py"), robot, {"pull": 2.0})


def test_a_gain_cannot_be_called_like_the_controller(tmp_path: Path, robot: Robot) -> None:
    (tmp_path / "own.py").write_text(TEXT.replace("    pull:", "    file:"), encoding="utf-8")
    with pytest.raises(ConfigError, match="a gain cannot be called 'file'"):
        load_controller(str(tmp_path / "own.py"), robot)


def test_a_toml_file_names_a_python_file_and_its_gains(tmp_path: Path, robot: Robot) -> None:
    made(tmp_path, robot)
    (tmp_path / "firm.toml").write_text(
        'description = "firm"\nfile = "own.py"\npull = 7.0\n', encoding="utf-8"
    )
    own = load_controller(str(tmp_path / "firm.toml"), robot, {"push": [0.0, 0.0]})
    assert own.gains().pull == 7.0
    assert own.gains().push.tolist() == [0.0, 0.0]
    again = load_controller(_written(tmp_path / "again.toml", resolved_tables(own)), robot)
    assert resolved_tables(again)["pull"] == 7.0


def _written(path: Path, tables: dict[str, Any]) -> str:
    path.write_text(write_toml(tables), encoding="utf-8")
    return str(path)


@dataclass(frozen=True)
class Gains:
    """A plain dataclass does as well."""

    scale: float = 1.0


class AtHand:
    """An object of a notebook's."""

    name = "at_hand"

    def __init__(self, robot: Robot) -> None:
        self.robot = robot

    def gains(self) -> Gains:
        return Gains()

    def initial_state(self) -> tuple[()]:
        return ()

    def step(self, gains: Gains, state: Any, measurement: Any, reference: Any, dt: float) -> Any:
        thrusts = (
            gains.scale * self.robot.at(measurement.joint_angles, measurement.vectoring_angles).hover_thrusts
        )
        return state, skylimb.Command(thrusts, reference.joint_angles, reference.vectoring_angles), {}


def test_an_object_at_hand_is_compiled_and_takes_gains(robot: Robot) -> None:
    given: Controller = AtHand(robot)
    own = controller_of(given, robot, {"scale": 2.0})
    assert isinstance(own, CompiledUserController)
    assert own.gains().scale == 2.0
    assert controller_of(own, robot) is own
    assert controller_of(given, robot).structure() != controller_of(AtHand(robot), robot).structure()  # type: ignore[attr-defined]
    hybrid = load_controller("hybrid", robot)
    assert is_configurable(hybrid)
    softer = controller_of(hybrid, robot, {"shape.stiffness": 3.0})
    assert resolved_tables(softer)["shape"]["stiffness"] == 3.0
    for key in ("shape.stifness", "legs.x", "shape", "shape.law"):
        with pytest.raises(UnknownNameError):
            controller_of(hybrid, robot, {key: 3.0})


@pytest.mark.parametrize(
    ("step", "told"),
    [
        ("return state, None, {}", "step returns nothing as its output, expected a Command"),
        (f"return state, {COMMAND}", "step returns 2 things, expected three things: state, a Command"),
        ("reference = reference._replace(joint_angles=np.ones(2))",
         "step: output: joint_angles: got shape (2,), expected a Command: shape (3,)"),
        ("x = 0.0 / 0.0 if x > 5.0 else math.nan", "step: output: thrusts: got [0.0"),
        (f"return state, {COMMAND}, {{'mode': 'up'}}", "step: signals: mode: got str, expected a number"),
        (f"return state, {COMMAND}, {{'thrusts': x}}", "step records 'thrusts', a name that the loop"),
        (f"return state, {COMMAND}, {{'a/b': x}}", "step records 'a/b'; the name of a signal is at most 100"),
        (f"return state, {COMMAND}, {{'force_command': x}}", "with the shape (); that is the name of 'wan"),
        ("measurement.velocity[0] = 0.0", "destination is read-only; what is given cannot be written to"),
        ("reference.position[0] = 0.0", "destination is read-only; what is given cannot be written to"),
        ("raise SystemExit(3)", "`raise SystemExit(3)`: SystemExit: 3"),
    ],
)  # fmt: skip
def test_what_its_step_returns_is_checked_when_it_is_read(
    tmp_path: Path, robot: Robot, step: str, told: str
) -> None:
    with pytest.raises(UserCodeError, match=rf"^controller 'own' .*own\.py, line \d+, .*{re.escape(told)}"):
        made(tmp_path, robot, step)


def test_an_object_that_cannot_be_copied_flies_untried(robot: Robot) -> None:
    class Connected(AtHand):
        def __deepcopy__(self, known: Any) -> Any:
            raise TypeError("a socket")

        def step(self, gains: Any, state: Any, measurement: Any, reference: Any, dt: float) -> Any:
            raise AssertionError

    assert not is_traceable(controller_of(Connected(robot), robot))


def test_what_is_no_controller_is_refused(robot: Robot) -> None:
    with pytest.raises(
        ConfigError, match="the controller is an object without name, gains, initial_state, step"
    ):
        controller_of(3, robot)  # type: ignore[arg-type]
    broken = AtHand(robot)
    broken.gains = lambda: 1 / 0  # type: ignore[assignment]
    with pytest.raises(UserCodeError, match=r"controller 'at_hand' fails in .*ZeroDivisionError"):
        controller_of(broken, robot)


def test_the_model_takes_symbols(robot: Robot) -> None:
    import casadi as ca

    q, psi = ca.SX.sym("q", robot.n_joints), ca.SX.sym("psi", robot.n_vectoring)
    traced = ca.Function("model", [q, psi], [robot.at(q, psi).inertia_C])
    here = np.full(robot.n_joints, 0.5), np.zeros(robot.n_vectoring)
    np.testing.assert_allclose(traced(*here).full(), robot.at(*here).inertia_C)
