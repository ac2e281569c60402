"""What is asked of a new robot, and what the answers make of it."""

from pathlib import Path

import pytest

import skylimb
from armed_robots import multirotor_with_arm
from skylimb.apps.cli.main import main
from skylimb.apps.robot_import.interview import QUESTIONS, interview
from skylimb.base.errors import ConfigError, UnknownNameError


@pytest.fixture
def urdf(tmp_path: Path) -> Path:
    return multirotor_with_arm(tmp_path / "made.urdf")


def asked(urdf: Path, **answers: str):
    """The last report, and the questions with their proposals."""
    heard: list[tuple[str, str]] = []

    def ask(words: str, proposed: str) -> str:
        heard.append((words, proposed))
        return ""

    *_, (report, _) = interview(urdf, answers, ask)
    return report, heard


def test_every_question_has_a_proposal_that_changes_nothing(urdf: Path) -> None:
    report, heard = asked(urdf)
    assert [proposed for _, proposed in heard] == ["1.8", "shoulder_pitch elbow_pitch", "tool0 0 0 0", "12"]
    plain = skylimb.check_robot_file(urdf)
    assert report.flight == plain.flight


def test_answers_are_what_is_imported(urdf: Path) -> None:
    report, heard = asked(urdf, arm="elbow_pitch", tip="tool0 0 0 0.1", thrust="14", mass="1.81")
    assert heard == []
    description = report.description
    assert description.shape_joints == ("elbow_pitch",)
    assert description.tip.link == "tool0"
    assert description.tip.position.tolist() == [0.0, 0.0, 0.1]
    assert {rotor.thrust_max for rotor in description.rotors} == {14.0}


def test_no_arm_is_an_answer(urdf: Path) -> None:
    report, _ = asked(urdf, arm="none")
    assert report.description.shape_joints == ()


@pytest.mark.parametrize(
    ("answers", "words"),
    [
        ({"mass": "2.5"}, "mass = 2.5 kg, but the links of the file weigh 1.8 kg"),
        ({"mass": "heavy"}, "mass = 'heavy' must be a number"),
        ({"mass": "nan"}, "mass = 'nan' must be a number"),
        ({"tip": "tool0 1 2"}, "must be a link, or a link and x y z"),
        ({"tip": "tool9"}, "did you mean 'tool0'"),
        ({"arm": "elbow"}, "did you mean 'elbow_pitch'"),
        ({"thrust": "-3"}, "thrust_max"),
    ],
)
def test_an_answer_that_cannot_be_is_refused(urdf: Path, answers: dict[str, str], words: str) -> None:
    with pytest.raises((ConfigError, UnknownNameError), match=words):
        asked(urdf, **answers)
    assert set(answers) <= set(QUESTIONS)


def test_robot_new_writes_the_robot_with_its_answers(urdf: Path, tmp_path: Path, capsys) -> None:
    out = tmp_path / "mine"
    assert main(["robot", "new", str(urdf), "--out", str(out)]) == 2
    assert "nobody is there to answer" in capsys.readouterr().err
    (tmp_path / "mine.png").unlink()
    assert main(["robot", "new", str(urdf), "--out", str(out), "--thrust", "13", "--yes"]) == 0
    assert f"--set robot={out}" in capsys.readouterr().out
    assert (tmp_path / "mine.png").read_bytes().startswith(b"\x89PNG")
    assert {rotor.thrust_max for rotor in skylimb.load_robot(out).description.rotors} == {13.0}
    assert "thrust_max = 13.0" in (out / "mapping.toml").read_text()
