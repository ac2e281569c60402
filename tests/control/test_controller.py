"""How a controller, a preset and a law are found, and what is said where they cannot be."""

from pathlib import Path

import pytest

from skylimb.base.errors import ConfigError, UnknownNameError
from skylimb.base.keys import rows_of
from skylimb.base.user_modules import load_module
from skylimb.control.cascade import Cascade
from skylimb.control.controller import (
    controller_from_tables,
    controller_units,
    load_controller,
    resolved_tables,
)
from skylimb.control.laws.preset import preset_from_mapping, preset_mapping, preset_names
from skylimb.control.laws.preset_keys import preset_tables
from skylimb.control.laws.slots import SLOTS, find_law, keys_of_law, law_names, right_key
from skylimb.robots.model import Robot

OWN = """
from skylimb import Command

class Own:
    name = "own"
    def gains(self): return 3
    def initial_state(self): return 4
    def step(self, gains, state, measurement, reference, dt):
        hover = self.robot.at(measurement.joint_angles, measurement.vectoring_angles).hover_thrusts
        return state, Command(hover, reference.joint_angles, reference.vectoring_angles), {}
"""


def written(folder: Path, text: str, name: str = "own.py") -> str:
    (folder / name).write_text(text, encoding="utf-8")
    return str(folder / name)


def test_a_python_file_makes_a_controller_for_the_robot(tmp_path: Path, robot: Robot) -> None:
    file = written(
        tmp_path, OWN + "def controller(robot):\n    made = Own()\n    made.robot = robot\n    return made\n"
    )
    made = load_controller(file, robot)
    assert (made.name, made.gains(), made.initial_state()) == ("own", 3, 4)
    assert vars(made)["made"].robot is robot
    assert controller_units(made) == {}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x = 1\n", r"own.py' does not define controller \(needed: controller\)"),
        (
            "raise ValueError('so')\n",
            r"import of 'own\.py' fails in .*own\.py, line 1, .*ValueError: so",
        ),
        (
            "def controller(robot):\n    raise KeyError('k')\n",
            r"controller\(robot\) of 'own\.py' fails in .*own\.py, line 2, .*`: KeyError: 'k'$",
        ),
        ("def controller(robot):\n    return 3\n", "an object without name, gains, initial_state, step"),
    ],
)
def test_a_python_file_that_makes_none_says_why(
    tmp_path: Path, robot: Robot, text: str, message: str
) -> None:
    with pytest.raises(ConfigError, match=message):
        load_controller(written(tmp_path, text), robot)


def test_files_that_are_not_there(tmp_path: Path, robot: Robot) -> None:
    with pytest.raises(ConfigError, match=r"gone\.py' does not exist"):
        load_controller(str(tmp_path / "gone.py"), robot)
    with pytest.raises(ConfigError, match=r"gone\.toml"):
        load_controller(str(tmp_path / "gone.toml"), robot)
    with pytest.raises(ConfigError, match="is not a Python module"):
        load_module(Path(written(tmp_path, "", "law.txt")), ())


def test_laws_are_the_files_of_their_folder() -> None:
    assert {slot: list(law_names(slot)) for slot in SLOTS} == {
        "estimation": ["kalman", "momentum", "moving_horizon", "predictive"],
        "contact": ["drawing", "following", "open", "task_frame"],
        "shape": ["admittance", "fixed", "recentring"],
        "translation": ["following", "impedance", "mpc", "pid", "task_frame"],
        "attitude": ["firm", "impedance", "task_frame"],
        "allocation": ["bounded", "level", "planned", "pointed", "pseudoinverse", "vectored"],
    }
    assert find_law("shape", "fixed", Path()).__name__ == "skylimb.control.shape.laws.fixed"
    assert find_law("estimation", "momentum", Path()).__name__ == "skylimb.control.estimation.laws.momentum"
    with pytest.raises(UnknownNameError, match="unknown shape law 'fixd'; did you mean 'fixed'"):
        find_law("shape", "fixd", Path())


LAW = """from dataclasses import dataclass
@dataclass(frozen=True)
class Gains: ...
def initial_state(gains, start): ...
def step(*given): ...
"""


@pytest.mark.parametrize(
    ("slot", "more"),
    [("estimation", "commanded"), ("allocation", "aim"), ("translation", None), ("attitude", None)],
)
def test_a_law_in_a_file_has_what_its_slot_needs(tmp_path: Path, slot: str, more: str | None) -> None:
    written(tmp_path, LAW, "mine.py")
    if more is None:
        assert find_law(slot, "mine.py", tmp_path).Gains.__name__ == "Gains"
        return
    with pytest.raises(ConfigError, match=f"does not define {more}"):
        find_law(slot, "mine.py", tmp_path)
    written(tmp_path, LAW + f"def {more}(*given): ...\n", "whole.py")
    assert find_law(slot, "whole.py", tmp_path).Gains.__name__ == "Gains"
    with pytest.raises(ConfigError, match="does not define initial_state, "):
        find_law(slot, str(written(tmp_path, "Gains = dict\n", "half.py")), tmp_path)


def test_keys_without_their_slot_are_found_again() -> None:
    assert right_key("leak.cutoff") == "allocation.leak.cutoff"
    assert right_key("surface.drift") == "contact.surface.drift"
    assert right_key("leak.cuttoff") == "allocation.leak"
    assert right_key("tare") == "estimation.tare"
    assert right_key("shpae.law") is None
    assert "vectoring.purpose" in keys_of_law(find_law("allocation", "vectored", Path()))


MINIMAL = {
    "translation": {"law": "pid", **{name: [1.0, 1.0, 1.0] for name in (
        "proportional", "integral", "derivative", "proportional_limit", "integral_limit", "derivative_limit",
        "sum_limit",
    )}},
    "attitude": {"law": "impedance", "virtual_inertia_ratio": [1.0] * 3, "normalized_stiffness": [1.0] * 3,
                 "damping_ratio": [1.0] * 3},
    "shape": {"law": "fixed"},
}  # fmt: skip


def test_slots_that_are_left_out_have_the_papers_laws() -> None:
    preset = preset_from_mapping(MINIMAL, Path("folder/mine.toml"))
    assert (preset.name, preset.description) == ("mine", "")
    assert [slot.name for slot in preset.slots] == [
        "momentum", "open", "fixed", "pid", "impedance", "pseudoinverse"
    ]  # fmt: skip
    named = preset_from_mapping({**MINIMAL, "name": "firm", "description": "so"}, Path("mine.toml"))
    assert (named.name, named.description) == ("firm", "so")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"shape": {}},
            r'controller mine needs a table \[shape\] with law = "..." \(known: admittance, fixed',
        ),
        ({"shape": 3}, r"needs a table \[shape\]"),
        ({"name": 3}, "controller mine: name = 3 should be a text"),
        ({"description": []}, r"controller mine: description = \[\] should be a text"),
        ({"shape": {"law": "fixed", "x": 1}}, r"controller mine: unknown key 'shape\.x'"),
        ({"wings": 3}, "unknown key of controller mine 'wings'"),
        ({"leak": {}}, r"did you mean 'controller\.allocation\.leak'"),
    ],
)
def test_a_preset_that_cannot_be_is_refused(change: dict[str, object], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        preset_from_mapping({**MINIMAL, **change}, Path("mine.toml"))


def test_presets_are_found_by_name_and_by_file(tmp_path: Path) -> None:
    assert preset_names() == [
        "admittance",
        "drawing",
        "following",
        "hybrid",
        "impedance",
        "mpc",
        "pid",
        "task_frame",
    ]
    tables, path = preset_mapping("hybrid")
    assert path.name == "hybrid.toml"
    copy = written(tmp_path, path.read_text(encoding="utf-8"), "copy.toml")
    assert preset_mapping(copy) == (tables, Path(copy))


def test_the_tables_given_are_left_as_they_are(robot: Robot) -> None:
    tables, path = preset_mapping("hybrid")
    controller_from_tables(tables, path, robot, {"shape.stiffness": 20.0, "estimation.law": "predictive"})
    assert tables == preset_mapping("hybrid")[0]


def test_every_key_of_a_preset_is_listed_with_its_value(robot: Robot) -> None:
    made = load_controller("following", robot)
    assert isinstance(made, Cascade)
    listed = {name: value for name, value, _ in rows_of(preset_tables(made.preset))}
    assert listed["allocation.law"] == "vectored"
    assert listed["translation.force"] == 1.0
    assert listed["name"] == "following"
    tables = resolved_tables(made)
    assert listed["contact.machine.touch_force"] == tables["contact"]["machine"]["touch_force"]
    units = controller_units(made)
    assert units["translation.force"] == "N"
    assert units["estimation.delay.latency"] == "s"
    laws = {name: info for name, _, info in rows_of(made.key_tables()) if name.endswith(".law")}
    assert laws["shape.law"].choices == ("admittance", "fixed", "recentring")
    meanings = {table.path: table.meaning for table in preset_tables(made.preset)}
    assert meanings["shape",].startswith("The arm makes up the surface's motion")


def test_a_name_without_the_ending_of_a_file_that_is_there_names_the_file(
    tmp_path: Path, robot: Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    written(tmp_path, OWN, "mine.py")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UnknownNameError, match=r"unknown controller 'mine'; did you mean 'mine\.py'\?"):
        load_controller("mine", robot)
    with pytest.raises(UnknownNameError, match=r"unknown controller 'yours' \(known"):
        load_controller("yours", robot)
