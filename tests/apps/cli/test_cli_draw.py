import json
from pathlib import Path

import numpy as np
import pytest

from skylimb.analysis.recording import Run
from skylimb.analysis.scores.pen_line import reference_line
from skylimb.apps.cli import main

SHORT = [
    "phases.hover=0.5",
    "phases.tare=1.0",
    "phases.settle=1.0",
    "phases.hover_end=0.5",
    "approach.speed=0.2",
    "approach.retreat_speed=0.4",
    "trajectory.lift_time=2.0",
    "controller.allocation.leak.compensate=true",
]


def call(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> tuple[int, str, str]:
    code = main(arguments)
    out, err = capsys.readouterr()
    return code, out, err


def test_words_are_drawn_and_shown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "drawn"
    words = ["draw", "--text", "L1", "--width", "0.2", "--speed", "0.1", "--surface", "cylinder_convex"]
    words += ["--controller", "hybrid", "--seed", "3", "--no-video", "--out", str(folder), "--set", *SHORT]
    code, out, _ = call(words, capsys)
    assert code == 0
    assert "L1 on cylinder_convex" in out
    assert "root mean square" in out
    assert "mm" in out
    assert (folder / "figures" / "drawing.png").is_file()
    page = (folder / "report.html").read_text()
    assert "The drawing" in page
    assert "config.toml" in page
    assert json.loads((folder / "metrics.json").read_text())["status"] == "OK"
    run = Run.load(folder)
    lines = reference_line(run.log)
    assert len(lines) >= 2
    low, high = np.vstack(lines).min(axis=0), np.vstack(lines).max(axis=0)
    np.testing.assert_allclose([low[0], high[0]], [-0.1, 0.1])
    root, largest = (run.metrics[f"pen_line_{which}"] for which in ("rms", "max"))
    assert 0.0 < root < largest < 0.2


@pytest.mark.usefixtures("no_figures")
def test_a_folder_of_a_drawing_flies_again(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    svg = tmp_path / "stroke.svg"
    svg.write_text('<svg xmlns="http://www.w3.org/2000/svg"><path d="M0 0 L9 3" stroke="red"/></svg>')
    common = ["--no-video", "--out"]
    first = ["draw", str(svg), "--width", "0.1", "--controller", "pid", "--set", *SHORT, *common]
    assert call([*first, str(tmp_path / "a")], capsys)[0] == 0
    again = ["run", str(tmp_path / "a" / "config.toml"), *common, str(tmp_path / "b")]
    assert call(again, capsys)[0] == 0
    a, b = Run.load(tmp_path / "a").log, Run.load(tmp_path / "b").log
    np.testing.assert_array_equal(a.tip_position.values, b.tip_position.values)
    np.testing.assert_array_equal(a.reference_line.values, b.reference_line.values)


@pytest.mark.usefixtures("no_figures")
def test_a_drawing_that_begins_where_the_surface_stands_out_starts_farther_off(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    svg = tmp_path / "stroke.svg"
    svg.write_text('<svg xmlns="http://www.w3.org/2000/svg"><path d="M90 50 H10" stroke="#000"/></svg>')
    words = ["draw", str(svg), "--out", str(tmp_path / "a"), "--set", *SHORT, "stop_at=0.1"]
    code, _, err = call(words, capsys)
    assert code == 0
    assert "approach.standoff = 0.231 m in place of 0.1 m" in err
    assert "standoff = 0.231" in (tmp_path / "a" / "config.toml").read_text()
    # A standoff that is asked for stays; the message names what is needed, and that is enough.
    words[3] = str(tmp_path / "b")
    code, _, err = call([*words, "approach.standoff=0.1"], capsys)
    assert code == 2
    assert "approach.standoff is too small: with 0.042 m more" in err
    assert call([*words, "approach.standoff=0.142"], capsys)[0] == 0


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([], "either an SVG file or --text"),
        (["a.svg", "--text", "b"], "not both"),
        (["nowhere.svg"], "no such file: 'nowhere.svg'"),
        (["--text", "hi", "--surface", "papper"], "did you mean 'paper'"),
        (["--text", "hi", "--font", "futural1"], "did you mean 'futural'"),
        (["--text", "hi", "--width", "30"], "millimetres"),
        (["--text", "hi", "--width", "wide"], "--width"),
        (
            ["--text", "hi", "--controller", "hybird", "--set", "trajectory.speed=0.1"],
            "did you mean 'hybrid'",
        ),
        (["--text", "hi", "--width", "3"], "leaves surface"),
        (["--text", "hi", "--set", "trajectory.shape=circle"], "trajectory.shape = 'circle' is no drawing"),
        (
            ["--text", "hi", "--width", "0.3", "--set", "trajectory.width=0.2"],
            "width = 0.3 and trajectory.width = 0.2 both say it",
        ),
        (["--text", "hi", "--set", "trajectory.text=ho"], "text = 'hi' and trajectory.text = 'ho'"),
        (["--text", "hi", "--surface", "push"], "push touches nothing (approach.contact)"),
        (["--text", "hi", "--surface", "free_flight"], "free_flight touches nothing (approach.contact)"),
        (["--text", "hi", "--set", "trajectory.colour=3"], "unknown key"),
    ],
)
def test_mistakes_are_one_line_and_leave_nothing(
    words: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "never"
    code, _, err = call(["draw", *words, "--out", str(folder)], capsys)
    assert code == 2
    assert message in err
    assert err.count("\n") == 1
    assert not folder.exists()
