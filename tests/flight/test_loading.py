"""Which controller flies an experiment: the one that was named, the experiment's, or the default."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

import skylimb
from skylimb.base.errors import ConfigError, UnknownNameError
from skylimb.control.cascade import Cascade
from skylimb.flight.takeoff import take_off


def adapted(folder: Path, table: str) -> str:
    """The shipped push, with a controller of its own."""
    whole = (Path(skylimb.__file__).parent / "flight" / "experiments" / "library" / "push.toml").read_text()
    file = folder / "mine.toml"
    file.write_text(f"{whole}\n[controller]\n{table}\n")
    return str(file)


def flown_by(experiment: str, given: str | None = None, settings: Mapping[str, Any] | None = None) -> Cascade:
    (takeoff,) = take_off(experiment, (given,), None, settings or {})
    assert isinstance(takeoff.controller, Cascade)
    return takeoff.controller


def test_an_experiment_adapts_a_preset_and_the_user_has_the_last_word(tmp_path: Path) -> None:
    file = adapted(tmp_path, "preset = 'impedance'\ntranslation.damping_ratio = [0.9, 0.9, 0.9]")
    own = flown_by(file)
    assert own.name == "impedance"
    assert list(own.gains().translation.damping_ratio) == [0.9, 0.9, 0.9]
    last = flown_by(file, settings={"controller.translation.damping_ratio": [0.5, 0.5, 0.5]})
    assert list(last.gains().translation.damping_ratio) == [0.5, 0.5, 0.5]
    assert flown_by(file, "pid").name == "pid"


def test_a_law_that_the_user_names_takes_the_experiments_gains_that_it_has(tmp_path: Path) -> None:
    table = "preset = 'impedance'\ntranslation.damping_ratio = [0.9, 0.9, 0.9]\nshape.law = 'admittance'"
    file = adapted(tmp_path, f"{table}\nshape.mass = 30.0\nshape.damping = 50.0\nshape.stiffness = 10.0")
    other = flown_by(file, settings={"controller.shape.law": "fixed"})
    assert other.preset.slots.shape.name == "fixed"
    assert list(other.gains().translation.damping_ratio) == [0.9, 0.9, 0.9]
    same = flown_by(file, settings={"controller.shape.law": "admittance"})
    assert same.gains().shape.mass == 30.0
    with pytest.raises(ConfigError, match=r"shape\.mass"):
        flown_by(file, settings={"controller.shape.law": "fixed", "controller.shape.mass": 30.0})


def test_a_foot_lies_flat_on_a_robot_whose_rotors_do_not_turn() -> None:
    """Its experiment sets gains of `level`, which such a robot can't fly."""
    flown = flown_by(
        "face_to_face",
        settings={
            "robot": "tilted_hexarotor",
            "controller.allocation.law": "bounded",
            "controller.allocation.side_force": "rotors",
        },
    )
    assert flown.preset.slots.allocation.name == "bounded"


@pytest.mark.parametrize(
    ("table", "error", "message"),
    [
        ("preset = 'impedence'", UnknownNameError, "did you mean 'impedance'"),
        ("preset = 3", ConfigError, "controller.preset = 3 should be a name"),
        ("preset = 'impedance'\nshape.stifness = 3.0", ConfigError, "shape.stifness"),
    ],
)
def test_a_wrong_preset_of_an_experiment_is_refused(
    tmp_path: Path, table: str, error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        flown_by(adapted(tmp_path, table))


def test_settings_of_the_command_line_are_no_settings_of_a_call() -> None:
    told = r"set = .*surface\.friction=0\.2.* should be a dict of dotted keys, as in set=\{'surface"
    given: Any = ["surface.friction=0.2"]
    with pytest.raises(ConfigError, match=told):
        skylimb.run("paper", set=given)


def test_a_path_is_as_good_as_its_name(tmp_path: Path) -> None:
    file = Path(adapted(tmp_path, "preset = 'impedance'"))
    preset = tmp_path / "firm.toml"
    shipped = Path(skylimb.__file__).parent / "control" / "presets" / "impedance.toml"
    preset.write_text(shipped.read_text())
    (named,), (given,) = (take_off(kind(file), (kind(preset),), None, {}) for kind in (str, Path))
    assert given.controller.name == named.controller.name == "firm"
    assert given.originals == named.originals
    assert [source.path for source in given.originals] == [file, preset]


@pytest.mark.parametrize(
    ("controllers", "words"),
    [
        ("hybrid", r"controllers = 'hybrid' should be a list, as in controllers=\['hybrid'\]"),
        (Path("firm.toml"), r"controllers = 'firm.toml' should be a list"),
        ((), "controllers is empty; `skylimb list` shows the names"),
    ],
)
def test_a_comparison_is_of_a_list_of_controllers(controllers: Any, words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        skylimb.compare("push", controllers)
