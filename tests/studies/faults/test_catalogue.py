"""The catalogue that ships can be flown, and mistakes in another are refused by name."""

from __future__ import annotations

from pathlib import Path

import pytest

from skylimb.apps.cli import main
from skylimb.base.errors import SkylimbError
from skylimb.flight.events import EVENTS
from skylimb.robots.loader import load_robot
from skylimb.studies.campaign.frozen import freeze
from skylimb.studies.faults import load_catalogue

HEAD = 'experiment = "paper"\ncontrollers = ["hybrid"]\n'
FAULT = '[[faults]]\nname = "{}"\nphysics = "It falls."\n{}\n'


def test_every_fault_that_ships_can_be_flown() -> None:
    catalogue, kinds = load_catalogue(), set[str]()
    for fault in catalogue.faults:
        assert fault.physics.strip().endswith("."), fault.name
        campaign = freeze(catalogue.campaign(fault, 4, supervised=False))
        kinds |= {event.kind for event in campaign.experiment_of(campaign.draw(0)).events}
    assert kinds == EVENTS.keys() - {"gain"}


def test_the_rotors_and_joints_that_are_drawn_are_the_robots() -> None:
    robot = load_robot("hydrus_xi_quad").description
    names = {rotor.name for rotor in robot.rotors} | {*robot.shape_joints, *robot.vectoring_joints}
    for fault in load_catalogue().faults:
        for key, drawn in fault.vary.items():
            if key.endswith((".rotor", ".joint")):
                assert set(drawn.listed) <= names, fault.name


def test_a_part_of_it_flies_with_other_controllers() -> None:
    chosen = load_catalogue().only(["rotor at half"], ["hybrid"])
    assert [fault.name for fault in chosen.faults] == ["rotor at half"]
    assert chosen.controllers == ("hybrid",)
    with pytest.raises(SkylimbError, match="unknown fault 'rotor at haf'; did you mean 'rotor at half'"):
        load_catalogue().only(["rotor at haf"], [])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (FAULT.format("a", "bounds.tild = [0.1, 0.2]"), ["bound of fault 'a' 'tild'", "did you mean 'tilt'"]),
        (FAULT.format("a", "bounds.tilt = 0.1"), ["faults.0.bounds = 0.1", "'tilt'"]),
        (FAULT.format("a", "") + FAULT.format("a", ""), ["two faults", "'a'"]),
        (FAULT.format("a", "events = 3"), ["'faults.0.events'"]),
        ("", ["'faults' is missing"]),
    ],
)
def test_mistakes_are_refused_by_name(
    text: str, words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, out = tmp_path / "mine.toml", tmp_path / "out"
    file.write_text(HEAD + text, encoding="utf-8")
    assert main(["faults", "--catalogue", str(file), "--out", str(out)]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    for word in words:
        assert word in said
    assert not out.exists()
