"""What is asked of a new robot, and what the answers make of it."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

import skylimb
from armed_robots import multirotor_with_arm
from skylimb.apps.cli.main import main
from skylimb.apps.robot_import.checking import RobotReport, check_robot_file
from skylimb.apps.robot_import.interview import QUESTIONS, interview
from skylimb.apps.robot_import.mapping import Mapping as MappingFile
from skylimb.base.errors import ConfigError, UnknownNameError


@pytest.fixture(scope="module", autouse=True)
def _the_same_is_checked_once() -> Iterator[None]:
    """Most tests begin with the same file, and some go on with the same answers."""
    known: dict[tuple[str, str], RobotReport] = {}

    def check(path: Path, packages: None, said: MappingFile, args: object) -> RobotReport:
        assert packages is None
        assert not args
        key = Path(path).read_text(), repr(said)
        if key not in known:
            known[key] = check_robot_file(path, mapping=said)
        return replace(known[key], path=Path(path))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("skylimb.apps.robot_import.interview.check_robot_file", check)
        yield


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
    assert [proposed for _, proposed in heard] == ["1.8", "shoulder_pitch elbow_pitch", "tool0 0 0 0 x", "12"]
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


def test_a_tip_is_said_with_the_axis_that_points_out(urdf: Path) -> None:
    report, _ = asked(urdf, tip="tool0 0 0 0.1 z")
    assert report.flight is not None
    assert (report.flight.tip.forward, report.flight.tip.heading) == ("z", "root")


def test_spins_are_asked_for_where_nothing_says_them(urdf: Path) -> None:
    silent = urdf.with_name("silent.urdf")
    silent.write_text(urdf.read_text().replace("0 0 -1", "0 0 1"))
    report, heard = asked(silent)
    words = "Which rotors turn clockwise, seen against their thrust? Links, or 'none'."
    # Rotors at 45, 135, 225 and 315 degrees: the first to the right of the nose turns counterclockwise.
    assert (words, "propeller_0 propeller_2") in heard
    assert any(doubt.what == "spin of the rotors" for doubt in report.doubts)
    report, heard = asked(silent, spin="propeller_1, propeller_3")
    assert [rotor.spin for rotor in report.description.rotors] == [1, -1, 1, -1]
    assert words not in [question for question, _ in heard]
    assert not any(doubt.what == "spin of the rotors" for doubt in report.doubts)


def test_a_proposal_that_is_taken_keeps_its_doubts(urdf: Path) -> None:
    report, _ = asked(urdf)
    assert {doubt.what for doubt in report.doubts} == {
        doubt.what for doubt in skylimb.check_robot_file(urdf).doubts
    }


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
        ({"spin": "propeller_9"}, "did you mean 'propeller_"),
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
    assert not (tmp_path / "mine.png").exists()  # the next try begins anew
    assert main(["robot", "new", str(urdf), "--out", str(out), "--thrust", "13", "--yes"]) == 0
    assert f"--set robot={out}" in capsys.readouterr().out
    assert (tmp_path / "mine.png").read_bytes().startswith(b"\x89PNG")
    assert {rotor.thrust_max for rotor in skylimb.load_robot(out).description.rotors} == {13.0}
    assert "thrust_max = 13.0" in (out / "mapping.toml").read_text()


def test_a_wrong_answer_is_told_and_asked_again(urdf: Path) -> None:
    """Names and ranges are looked at when the answer is given; those before it are kept."""
    answers = iter(["", "elbow_pitch", "tool9", "tool0 200 0 0", "tool0 0 0 0.1", "many", "14"])
    heard: list[str] = []

    def ask(words: str, proposed: str) -> str:
        heard.append(words)
        return next(answers)

    *_, (report, said) = interview(urdf, {}, ask)
    assert "did you mean 'tool0'" in heard[3]
    assert heard[4].startswith("the answers: tip.position = 200 m")
    assert heard[4].endswith(heard[2])
    assert "thrust = 'many' must be a number" in heard[6]
    assert report.description.shape_joints == ("elbow_pitch",)
    assert [entry.name for entry in said.joints] == ["elbow_pitch", "shoulder_pitch"]
    assert {rotor.thrust_max for rotor in report.description.rotors} == {14.0}


def test_the_end_of_the_answers_is_one_line(urdf: Path, tmp_path: Path, capsys, monkeypatch) -> None:
    def ended(prompt: str) -> str:
        raise EOFError

    monkeypatch.setattr("builtins.input", ended)
    monkeypatch.setattr("sys.stdin.isatty", lambda: True)
    assert main(["robot", "new", str(urdf), "--out", str(tmp_path / "mine")]) == 2
    assert "no answer to 'What does it weigh" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["made.urdf"]


@pytest.mark.usefixtures("no_picture")
def test_what_is_locked_stays_so_when_it_is_imported_again(urdf: Path, tmp_path: Path) -> None:
    """The draft of a mapping says every joint that moves: one that is left out is guessed anew."""
    first, said = tmp_path / "first", interview(urdf, {"arm": "elbow_pitch"}, lambda *_: "")
    *_, (_, answers) = said
    skylimb.import_robot(urdf, first, mapping=answers)
    again = skylimb.check_robot_file(urdf, mapping=first / "mapping.toml")
    assert again.description.shape_joints == ("elbow_pitch",)
    assert again.roles["shoulder_pitch"] == "locked"
    assert again.roles["rotor_0_joint"] == "rotor"
