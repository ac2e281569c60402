"""`skylimb robot wrench`: a table, a folder, and one line for what it cannot do."""

import json
from pathlib import Path

import pytest

from made_robots import multirotor
from skylimb.apps.cli import main


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> str:
    return str(multirotor(tmp_path_factory.mktemp("canted")))


def test_it_prints_and_writes_what_the_robot_can_do(
    robot: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "wrench"
    assert (
        main(["robot", "wrench", robot, "--tilt", "0", "--direction", "1", "-1", "0", "--out", str(out)]) == 0
    )
    shown = capsys.readouterr().out
    assert "all six directions" in shown
    assert "(0.71, -0.71, 0.00)" in shown
    assert {path.name for path in out.iterdir()} == {"wrench.json", "wrench.png"}
    tables = json.loads((out / "wrench.json").read_text())
    assert f"{tables['pushes']['+x']['level']['force']:.1f}" in shown
    assert tables["pushes"]["+x"]["level"]["ends"] in shown
    assert f"{tables['fct_min']:.2f}" in shown
    assert tables["pushes"]["+x"]["level"]["force"] > 1.0
    assert main(["robot", "wrench", robot, "--out", str(out)]) == 2
    assert "exists already" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["hydrus_xi_quat"], "did you mean 'hydrus_xi_quad'"),
        (["hydrus_xi_quad", "--posture", "1", "2"], "--posture = '1 2' must be 3"),
        (["hydrus_xi_quad", "--posture", "1", "two", "3"], "must be 3 numbers"),
        (["hydrus_xi_quad", "--posture", "9", "0", "0"], "limits"),
        (["hydrus_xi_quad", "--direction", "0", "0", "0"], "direction"),
        (["hydrus_xi_quad", "--tilt", "2"], "--tilt = 2 rad"),
        (["hydrus_xi_quad", "--moves", "-1"], "--moves = -1 rad"),
        (["hydrus_xi_quad", "--moves", "nan"], "--moves = nan rad"),
    ],
)
def test_what_it_cannot_do_is_told_in_a_line_and_leaves_nothing(
    words: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["robot", "wrench", *words, "--out", str(tmp_path / "wrench")]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert not any(tmp_path.iterdir())
