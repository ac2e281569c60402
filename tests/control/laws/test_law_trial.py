"""What the trial of a user's law finds besides the mistakes of docs/reports/mistakes.md."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from skylimb.base.config import write_toml
from skylimb.base.errors import ConfigError, UserCodeError
from skylimb.control.controller import load_controller
from skylimb.control.laws.preset import preset_mapping
from skylimb.flight.export import export_c
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


def test_a_list_of_the_file_that_grows_is_not_compiled_away(tmp_path: Path, robot: Robot) -> None:
    grown = LAW.replace(
        "    return", "    ONES.append(1)\n    if len(ONES) > 500: state = 2.0 * state\n    return"
    )
    (why,) = read(tmp_path, robot, grown).in_python.values()
    assert why == "step changes 'ONES' of its file at every call; memory belongs into its state"
    filled = LAW.replace("    return", "    if not ONES: ONES.append(1)\n    return")
    assert not read(tmp_path, robot, filled).in_python
