"""What the trial of a user's law finds besides the mistakes of docs/reports/mistakes.md."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from made_robots import chain
from skylimb.base.config import write_toml
from skylimb.base.errors import ConfigError, UserCodeError
from skylimb.control.controller import load_controller
from skylimb.control.laws.preset import preset_mapping
from skylimb.flight.export import export_c
from skylimb.robots.loader import read_description
from skylimb.robots.model import Robot

LAW = """from dataclasses import dataclass
import numpy as np
@dataclass(frozen=True)
class Gains: ...
ONES = []
def initial_state(gains, start): return np.ones(1)
def step(gains, state, inputs):
    return state, inputs.estimate.body.model.mass * inputs.estimate.body.model.gravity, {}
"""


def read(folder: Path, robot: Robot, text: str) -> Any:
    assert text != LAW
    (folder / "law.py").write_text(text, encoding="utf-8")
    tables, _ = preset_mapping("hybrid")
    tables["translation"] = {"law": "law.py"}
    (folder / "own.toml").write_text(write_toml(tables), encoding="utf-8")
    return load_controller(str(folder / "own.toml"), robot)


@pytest.mark.parametrize("step", ["state[0] + state[0]", "float(state[0]) + state[0]"])
def test_a_vector_of_one_entry_is_a_vector(tmp_path: Path, robot: Robot, step: str) -> None:
    cascade = read(tmp_path, robot, LAW.replace("{}", f"{{'sum': {step}}}"))
    assert bool(cascade.in_python) == ("float" in step)
    np.testing.assert_array_equal(cascade.initial_state().translation, [1.0])


@pytest.mark.parametrize("plain", [True, False])
def test_the_one_joint_of_a_robot_is_a_vector(tmp_path: Path, plain: bool) -> None:
    """A law sees what it sees of any robot: vectors by joint, and a Jacobian with a column."""
    flight_file = chain(tmp_path / "one", links=2, turns=("1 0 0", "0 1 0"))
    asked = "float(inputs.reference.joint_angles[0])" if plain else "inputs.reference.joint_angles[0]"
    jacobian = "inputs.estimate.body.model.tip_jacobian"
    told = f"'angle': {asked}, 'by_joint': {jacobian}.T @ np.ones(3)"
    text = LAW.replace("np.ones(1)", "np.zeros(start.robot.n_joints)").replace("{}", f"{{{told}}}")
    cascade = read(tmp_path, Robot(read_description(flight_file)), text)
    assert cascade.robot.n_joints == 1
    assert bool(cascade.in_python) == plain


@pytest.mark.parametrize("made", ["np.random.rand()", "np.zeros(len(ONES + [ONES.append(1)]))"])
def test_what_is_prepared_is_the_same_every_time(tmp_path: Path, robot: Robot, made: str) -> None:
    text = LAW.replace("inputs)", "inputs, K)") + f"def prepare(gains, robot):\n    return {made}\n"
    told = "translation law 'law.py': prepare gives another result when it is called again"
    with pytest.raises(UserCodeError, match=re.escape(told)):
        read(tmp_path, robot, text)


def test_signals_are_those_of_every_call(tmp_path: Path, robot: Robot) -> None:
    text = LAW.replace("{}", "{'a': 1.0} if inputs.reference.position[2] > 1.0 else {}")
    with pytest.raises(UserCodeError, match=r"line \d+, .*step does not always return signals a; what"):
        read(tmp_path, robot, text)


@pytest.mark.parametrize(
    ("gains", "told"),
    [
        ("class Gains: k = 1.0", "a class Gains without it"),
        ("Gains = dict(k=1.0)", "dict"),
        ("Gains = None", "NoneType"),
        ("def Gains(): ...", "function"),
        ("@dataclass(frozen=True)\nclass G: ...\nGains = G()", "G"),
    ],
)
def test_gains_that_are_no_dataclass_are_named(tmp_path: Path, robot: Robot, gains: str, told: str) -> None:
    told = (
        "translation law 'law.py': Gains should be a class with @configuration or @dataclass(frozen=True); "
        f"it is {told}"
    )
    with pytest.raises(UserCodeError, match=f"{re.escape(told)}$"):
        read(tmp_path, robot, LAW.replace("@dataclass(frozen=True)\nclass Gains: ...", gains))


@pytest.mark.parametrize(
    ("field", "told"),
    [
        ("k: tuple = (1.0, 2.0)", "Gains.k is a tuple of what? Write tuple[float, float, float], or"),
        ("k: dict = None", "Gains.k is a dict of what? Write dict[str, float]"),
        ("k: np.ndarray = None", "Gains.k is of type ndarray, which no TOML file can say; write float,"),
        ("k: tuple[complex, ...] = ()", "Gains.k is of type complex, which no TOML file can say"),
        ("k: 'float | np.float64' = 1.0", "Gains.k is of type float64, which no TOML file can say"),
        ("k: 'Nobodys' = 1.0", "a type in Gains cannot be read: NameError: name 'Nobodys' is not defined"),
        ("law: float = 1.0", "a gain cannot be called 'law', which names the law in a preset"),
    ],
)
def test_gains_are_of_types_that_a_file_can_say(tmp_path: Path, robot: Robot, field: str, told: str) -> None:
    # Such a run could not be flown again from its config.toml.
    with pytest.raises(UserCodeError, match=re.escape(f"translation law 'law.py': {told}")):
        read(tmp_path, robot, LAW.replace("class Gains: ...", f"class Gains:\n    {field}"))


def test_gains_of_every_type_that_a_file_can_say_are_read_back(tmp_path: Path, robot: Robot) -> None:
    fields = (
        "a: float = 1", "b: int = 2", "c: bool = True", "d: str = 'x'", "e: tuple[float, ...] = (1.0, 2.0)",
        "f: typing.Sequence[float] = (1.0,)", "g: typing.Any = 2.0", "h: float | None = None",
        "i: typing.Literal['x', 'y'] = 'y'", "j: typing.Optional[tuple[tuple[float, float], ...]] = None",
    )  # fmt: skip
    text = "import typing\n" + LAW.replace("class Gains: ...", "\n    ".join(("class Gains:", *fields)))
    cascade = read(tmp_path, robot, text)
    tables = cascade.tables()
    (tmp_path / "again.toml").write_text(write_toml(tables), encoding="utf-8")
    again: Any = load_controller(str(tmp_path / "again.toml"), robot)
    assert again.tables()["translation"] == tables["translation"]


@pytest.mark.parametrize(
    ("function", "told"),
    [
        ("def step(state, inputs): ...", "step(state, inputs) is called as step(gains, state, inputs)"),
        ("def initial_state(gains): ...", "initial_state(gains) is called as initial_state(gains, start)"),
        ("def prepare(gains): ...", "prepare(gains) is called as prepare(gains, robot)"),
        ("def needs(): ...", "needs() is called as needs(gains)"),
        (
            "def prepare(gains, robot): ...",
            "step(gains, state, inputs) is called as step(gains, state, inputs, prepared)",
        ),
    ],
)
def test_a_function_with_other_arguments_is_told_how_it_is_called(
    tmp_path: Path, robot: Robot, function: str, told: str
) -> None:
    with pytest.raises(UserCodeError, match=rf"^translation law 'law\.py' in .*: {re.escape(told)}$"):
        read(tmp_path, robot, LAW + function)


def test_a_law_is_called_as_its_slot_calls_it(tmp_path: Path, robot: Robot) -> None:
    (tmp_path / "law.py").write_text(LAW, encoding="utf-8")
    told = "step(gains, state, inputs) is called as step(gains, state, inputs, R_target)"
    with pytest.raises(UserCodeError, match=re.escape(told)):
        load_controller("hybrid", robot, {"attitude.law": str(tmp_path / "law.py")})


def test_what_is_written_into_is_told_with_the_way_out(tmp_path: Path, robot: Robot) -> None:
    text = LAW.replace("    return", "    state += 1.0\n    return")
    told = r"line 8, `state \+= 1\.0`: ValueError: .*read-only; what is given cannot be written to: work on a"
    with pytest.raises(UserCodeError, match=told):
        read(tmp_path, robot, text)


def test_the_line_is_that_of_the_file_as_it_is_now(tmp_path: Path, robot: Robot) -> None:
    # As in a notebook, where one process reads the file again and again.
    for result in ("1, 2", "state, 1.0, {}"):
        with pytest.raises(UserCodeError, match=re.escape(f"line 8, `return {result}`")):
            read(tmp_path, robot, LAW.partition("    return")[0] + f"    return {result}")


def test_a_function_that_is_none_is_named(tmp_path: Path, robot: Robot) -> None:
    with pytest.raises(UserCodeError, match=r"^translation law 'law\.py': prepare is no function"):
        read(tmp_path, robot, LAW + "prepare = 3\n")


@pytest.mark.parametrize(
    ("state", "told"),
    [
        ("0", "returns 0, expected floats"),
        ("[0.0, 'a']", "returns [0.0, 'a'], expected floats"),
        ("(0.0, {'on': True})", "returns True as 1.on, expected floats"),
    ],
)
def test_a_first_state_is_made_of_floats(tmp_path: Path, robot: Robot, state: str, told: str) -> None:
    with pytest.raises(UserCodeError, match=re.escape(f"translation law 'law.py': initial_state {told}")):
        read(tmp_path, robot, LAW.replace("np.ones(1)", state))


GUARDED = """    gain = 1.0
    try:
        {asked}
    except Exception:
        pass
    return"""


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        ("if inputs.estimate.contact_force < -0.5: gain = 2.0", "skylimb.symbolic.where"),
        ("gain += max(float(inputs.estimate.contact_force) - 100.0, 0.0)", "need numbers"),
        ("gain += 0.0 * np.array(inputs.reference.position)[0]", "NumPy arrays take no symbols"),
        ("gain += 0.0 * len(np.isfinite(inputs.reference.position))", "isfinite"),
    ],
)
def test_a_guarded_branch_is_not_compiled_away(tmp_path: Path, robot: Robot, asked: str, told: str) -> None:
    text = LAW.replace("    return", GUARDED.format(asked=asked)).replace(
        "state, inputs.", "state, gain * inputs."
    )
    cascade = read(tmp_path, robot, text)
    (why,) = cascade.in_python.values()
    assert f"law.py, line {text[: text.index(asked)].count(chr(10)) + 1}, `{asked}`: " in why
    assert told in why
    with pytest.raises(ConfigError, match=r"law\.py"):
        export_c(cascade, tmp_path / "c")
    taken = "where(inputs.estimate.contact_force < -0.5, 2.0, 1.0) * "
    text = LAW.replace("import numpy as np", "import numpy as np\nfrom skylimb.symbolic import where")
    assert not read(tmp_path, robot, text.replace("state, inputs.", f"state, {taken}inputs.")).in_python


def test_what_a_file_counts_outside_of_its_state_is_not_compiled_away(tmp_path: Path, robot: Robot) -> None:
    grown = LAW.replace(
        "    return", "    ONES.append(1)\n    if len(ONES) > 500: state = 2.0 * state\n    return"
    )
    (why,) = read(tmp_path, robot, grown).in_python.values()
    assert why == "step changes 'ONES' of its file at every call; memory belongs into its state"
    for kept in ("Kept.calls", "step.calls"):
        counted = LAW.replace("import numpy", "class Kept: calls = 0\nimport numpy") + "step.calls = 0\n"
        counted = counted.replace(
            "    return", f"    {kept} += 1\n    if {kept} > 500: state = 2.0 * state\n    return"
        )
        (why,) = read(tmp_path, robot, counted).in_python.values()
        assert why == f"step changes '{kept}' of its file at every call; memory belongs into its state"
    filled = LAW.replace("    return", "    if not ONES: ONES.append(1)\n    return")
    assert not read(tmp_path, robot, filled).in_python


def test_the_ending_of_a_laws_file_is_missed(tmp_path: Path, robot: Robot) -> None:
    (tmp_path / "mine.py").write_text(LAW, encoding="utf-8")
    tables, _ = preset_mapping("hybrid")
    tables["translation"] = {"law": "mine"}
    (tmp_path / "own.toml").write_text(write_toml(tables), encoding="utf-8")
    with pytest.raises(ConfigError, match=r"unknown translation law 'mine'; did you mean 'mine\.py'\?"):
        load_controller(str(tmp_path / "own.toml"), robot)
