"""A TOML file is known by its keys, and refused by name where a file of another kind is wanted."""

from pathlib import Path

import pytest

from skylimb import robots
from skylimb.apps.cli import main
from skylimb.base.config import read_toml
from skylimb.control.laws.file_kinds import kind_of_tables
from skylimb.control.laws.preset import PRESETS
from skylimb.flight.experiments.experiment import EXPERIMENTS

ROBOTS = Path(robots.__file__).parent

SHIPPED = {
    "controller": PRESETS.glob("*.toml"),
    "experiment": EXPERIMENTS.glob("*.toml"),
    "robot": ROBOTS.glob("*/flight.toml"),
}


def test_every_file_that_ships_is_known() -> None:
    for kind, files in SHIPPED.items():
        found = {file.name: kind_of_tables(read_toml(file)) for file in files}
        assert found
        assert set(found.values()) == {kind}, found


def test_what_a_file_does_not_say_is_left_open() -> None:
    assert kind_of_tables({"name": "mine", "robot": "hydrus_quad"}) == ""
    assert kind_of_tables({"trajectory": {}, "translation": {}}) == ""
    assert kind_of_tables({"file": "mine.py", "surface": 1.0}) == "controller"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            "run {preset}",
            "and not of an experiment: it goes behind --controller",
        ),
        ("draw --text hi --surface {preset}", "is the file of a controller, and not of an experiment"),
        ("run --controller {paper}", "is the file of an experiment, and not of a controller: `skylimb run "),
        ("run {robot}", "is the file of a robot, and not of an experiment"),
    ],
)
def test_a_file_of_another_kind_is_refused(
    words: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    robot = next(ROBOTS.glob("*/flight.toml"))
    files = {"preset": PRESETS / "pid.toml", "paper": EXPERIMENTS / "paper.toml", "robot": robot}
    assert main([*words.format(**files).split(), "--out", str(tmp_path / "never")]) == 2
    err = capsys.readouterr().err
    assert message in err
    assert err.count("\n") == 1
    assert not (tmp_path / "never").exists()
