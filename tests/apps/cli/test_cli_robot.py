"""`skylimb robot check` and `robot import` as they are typed."""

import shlex

import pytest

from lab_style import lab_urdf
from skylimb.apps.cli.main import main


@pytest.fixture
def quad(tmp_path):
    path = tmp_path / "quad.urdf"
    path.write_text(lab_urdf(gimbal="fixed"))
    return path


def test_exit_codes(quad, capsys):
    assert main(["robot", "check", str(quad)]) == 0
    assert "lab quad can hover and can touch." in capsys.readouterr().out
    quad.write_text(quad.read_text().replace("rotor4", "spare").replace("thrust4", "spare_end"))
    assert main(["robot", "check", str(quad)]) == 1
    assert "loads and cannot hover: the rotors" in capsys.readouterr().out
    quad.write_text("<robot")
    assert main(["robot", "check", str(quad)]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_a_broken_robot_is_drawn(quad, tmp_path, capsys):
    quad.write_text(quad.read_text().replace('ixx="0.010000000000000002"', 'ixx="-0.01"'))
    picture = tmp_path / "quad.png"
    assert main(["robot", "check", str(quad), "--picture", str(picture)]) == 1
    assert "FAULT     inertia of link 'main'" in capsys.readouterr().out
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.usefixtures("no_picture")
def test_import_tells_how_to_fly(quad, tmp_path, capsys):
    assert main(["robot", "import", str(quad)]) == 2
    assert "--out is missing" in capsys.readouterr().err
    assert main(["robot", "import", str(quad), "--out", str(tmp_path / "mine")]) == 0
    told = capsys.readouterr().out
    assert "flown     a hover of 5 s with hybrid\n" in told
    assert f"skylimb run free_flight --set robot={tmp_path / 'mine'}" in told
    assert main(["robot", "import", str(quad), "--out", str(tmp_path / "mine")]) == 2
    assert "exists already" in capsys.readouterr().err
    assert main(["robot", "check", str(tmp_path / "mine")]) == 0


@pytest.mark.parametrize(
    ("hovers", "code", "told"),
    [
        (
            ["following"],
            0,
            ["doubt     a hover of 5 s with hybrid does not last: it fell", "--controller following"],
        ),
        (
            ["hybrid"],  # the first touch is by the other one
            0,
            ["flown     a hover of 5 s with hybrid", "doubt     a hover of 5 s with following does not last"],
        ),
        (
            [],
            1,
            ["FAULT     a hover of 5 s with hybrid does not last", "FAULT     a hover of 5 s with following"],
        ),
    ],
)
@pytest.mark.usefixtures("no_picture")
def test_import_says_who_hovers(quad, tmp_path, capsys, monkeypatch, hovers, code, told):
    monkeypatch.setattr(
        "skylimb.apps.robot_import.hover_flight.hover_lost",
        lambda robot, controller: "" if controller in hovers else "it fell",
    )
    assert main(["robot", "import", str(quad), "--out", str(tmp_path / "mine")]) == code
    found = capsys.readouterr().out
    assert all(part in found for part in told)


@pytest.mark.usefixtures("no_picture")
def test_a_command_can_be_pasted_whatever_the_folder_is_called(quad, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("skylimb.apps.robot_import.hover_flight.hover_lost", lambda robot, controller: "")
    out = tmp_path / "my robot"
    assert main(["robot", "import", str(quad), "--out", str(out)]) == 0
    command = capsys.readouterr().out.partition("Written to ")[2].partition(": ")[2]
    assert f"robot={out}" in shlex.split(command)


def test_a_name_that_is_nothing(capsys):
    assert main(["robot", "check", "nothing.urdf"]) == 2
    assert "no such file" in capsys.readouterr().err
