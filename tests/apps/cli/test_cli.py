import json
import logging
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import skylimb
from skylimb import __version__
from skylimb.analysis.recording import Run
from skylimb.apps.cli import main, output
from skylimb.apps.cli.verbs import VERBS
from synthetic_flight import synthetic_log

SHORT = [
    "phases.hover=0.5",
    "phases.tare=1.0",
    "phases.settle=1.0",
    "phases.hover_end=0.5",
    "approach.speed=0.2",
    "approach.retreat_speed=0.4",
    "trajectory.period=4.0",
    "trajectory.radius=0.1",
]


def call(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> tuple[int, str, str]:
    code = main(arguments)
    out, err = capsys.readouterr()
    return code, out, err


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> tuple[int, Path]:
    folder = tmp_path_factory.mktemp("run") / "flight"
    code = main(["run", "--set", *SHORT, "--seed", "5", "--no-video", "--out", str(folder)])
    return code, folder


@pytest.fixture(scope="module")
def compared(tmp_path_factory: pytest.TempPathFactory) -> tuple[int, Path]:
    folder = tmp_path_factory.mktemp("compare") / "both"
    words = ["--controllers", "pid", "hybrid", "--set", *SHORT, "--no-video", "--out", str(folder)]
    with pytest.MonkeyPatch.context() as patch:  # those of `flown` are looked at
        patch.setattr("skylimb.analysis.figures.report_figures.write_figures", lambda *_: [])
        return main(["compare", "paper", *words]), folder


def test_run_leaves_what_it_promises(flown: tuple[int, Path]) -> None:
    code, folder = flown
    assert code == 0
    assert {path.name for path in folder.iterdir()} >= {"log.nc", "metrics.json", "config.toml", "figures"}
    assert any((folder / "figures").iterdir())
    metrics = json.loads((folder / "metrics.json").read_text())
    assert metrics["status"] == "OK"
    config = (folder / "config.toml").read_text()
    assert "seed = 5" in config
    assert "period = 4.0" in config


def test_compare_leaves_what_it_promises(compared: tuple[int, Path]) -> None:
    code, folder = compared
    assert code == 0
    assert {path.name for path in folder.iterdir()} >= {"pid", "hybrid", "metrics.csv", "report.html"}
    for name in ("pid", "hybrid"):
        assert (folder / name / "log.nc").is_file()
    page = (folder / "report.html").read_text()
    assert not re.findall(
        r"""(?:src|href)=["']?https?:|url\(["']?https?:|fetch\(["']http""", page
    )  # self-contained


@pytest.mark.usefixtures("no_figures")
def test_the_summary_shows_both_controllers_and_no_number_of_a_paper_that_flew_longer(
    compared: tuple[int, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, _ = call(["report", str(compared[1])], capsys)
    assert code == 0
    assert "hybrid" in out
    assert "paper's numbers stand only beside flights of its configuration" in out
    assert "pid, hybrid: " in out
    assert "trajectory.period = 4 (paper: 14)" in out
    assert "(0.083)" not in out
    assert "report.html" in out
    page = (compared[1] / "report.html").read_text()
    assert "trajectory.period = 4 (paper: 14)" in page
    assert "0.083" not in page


def test_the_papers_numbers_stand_beside_the_papers_flight(capsys: pytest.CaptureFixture[str]) -> None:
    output.scores({"pid": skylimb.run("paper", "pid", seed=3)})
    out = capsys.readouterr().out
    assert "in brackets the paper's numbers" in out
    assert "(0.134)" in out
    assert "Flown otherwise" not in out


def test_view_without_a_display_writes_a_page_to_open(
    compared: tuple[int, Path], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    code, out, _ = call(["view", str(compared[1]), "--speed", "2"], capsys)
    assert code == 0
    assert "No display" in out
    page = compared[1] / "view.html"
    assert str(page) in out
    assert '"speed":2.0' in page.read_text(encoding="utf-8")


class FakeWindow:
    """Stands in for the viewer's window: counts the pictures, and is closed after some of them."""

    def __init__(self, data: Any) -> None:
        self.data, self.seen = data, []

    def __enter__(self) -> "FakeWindow":
        return self

    def __exit__(self, *reason: object) -> None:
        pass

    def is_running(self) -> bool:
        return len(self.seen) < 5

    def sync(self) -> None:
        self.seen.append(self.data.qpos.copy())


def test_view_with_a_display_plays_the_recorded_configurations(
    flown: tuple[int, Path], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    import mujoco.viewer

    windows: list[FakeWindow] = []

    def launch(model: Any, data: Any, **options: Any) -> FakeWindow:
        windows.append(FakeWindow(data))
        return windows[-1]

    monkeypatch.setattr(mujoco.viewer, "launch_passive", launch)
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setenv("DISPLAY", ":0")
    code, out, _ = call(["view", str(flown[1]), "--speed", "20"], capsys)
    assert code == 0
    assert "20 times the real speed" in out
    recorded = Run.load(flown[1]).log["configuration"].values
    (window,) = windows
    rows = [int(np.flatnonzero((recorded == seen).all(axis=1))[0]) for seen in window.seen]
    assert len(rows) == 5
    assert rows == sorted(rows)
    assert rows[-1] > 0


@pytest.mark.usefixtures("no_figures")
def test_a_lost_flight_is_kept_and_exits_with_1(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "lost"
    falling = ["plant.thrust_scale=0.5", "approach.contact=false"]
    code, out, err = call(["run", "--set", *SHORT, *falling, "--no-video", "--out", str(folder)], capsys)
    assert code == 1
    assert "FAILED" in out
    assert "error" not in err
    metrics = json.loads((folder / "metrics.json").read_text())
    assert metrics["status"] == "FAILED"
    assert metrics["cause"]
    assert metrics["error_u_median"] is None


@pytest.mark.usefixtures("no_figures")
def test_a_warning_is_a_line_without_a_place_in_the_code(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    doubtful = ["controller.translation.force=3", "surface.friction=0.8", "plant.thrust_scale=0.5"]
    words = ["run", "--controller", "following", "--set", *SHORT, *doubtful, "--no-video"]
    code, _, err = call([*words, "--out", str(tmp_path / "doubtful")], capsys)
    assert code == 1
    assert "skylimb: warning: a force of 3 N is doubtful: with a friction of 0.8" in err
    assert "UserWarning" not in err
    assert ".py" not in err


STOPPING = """
import skylimb

class Stopping:
    name = "stopping"
    def __init__(self, robot): self.own, self.left = skylimb.load_controller("pid", robot), TICKS
    def gains(self): return self.own.gains()
    def initial_state(self): return self.own.initial_state()
    def step(self, gains, state, measurement, reference, dt):
        float(measurement.joint_angles[0])  # not to be traced
        self.left -= 1
        if self.left < 0: STOP
        return self.own.step(gains, state, measurement, reference, dt)

def controller(robot): return Stopping(robot)
"""


@pytest.mark.usefixtures("no_figures")
@pytest.mark.parametrize(
    ("stop", "code"), [("raise KeyboardInterrupt", 130), ("signal.raise_signal(signal.SIGTERM)", 143)]
)
def test_an_interrupted_flight_leaves_what_was_flown(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], stop: str, code: int
) -> None:
    file, out = tmp_path / "stopping.py", tmp_path / "out"
    file.write_text(f"import signal{STOPPING}".replace("TICKS", "50").replace("STOP", stop))
    found, _, err = call(["run", "free_flight", "--controller", str(file), "--out", str(out)], capsys)
    kept = tmp_path / "out-interrupted"
    assert found == code
    assert err.endswith(f"skylimb: error: interrupted; what was flown is kept in '{kept}'\n")
    assert not out.exists()
    run = Run.load(kept)
    assert run.cause == f"stopped from outside at t = {run.log.time.values[-1] + 0.005:.3f} s, " + (
        "before the mission's end"
    )
    assert 30 < run.log.sizes["time"] <= 50
    assert run.metrics == {}
    assert call(["score", str(kept)], capsys)[0] == 0
    assert json.loads((kept / "metrics.json").read_text())["status"] == "FAILED"


@pytest.mark.usefixtures("no_figures")
def test_a_report_that_cannot_be_written_exits_with_1(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], flown: tuple[int, Path]
) -> None:
    folder = shutil.copytree(flown[1], tmp_path / "flight")
    (folder / "report.html").unlink()
    (folder / "report.html").mkdir()
    code, out, _ = call(["report", str(folder)], capsys)
    assert code == 1
    assert "report.html failed" in out


@pytest.mark.usefixtures("no_figures")
def test_what_fails_after_a_flight_is_named_and_can_be_scored_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], flown: tuple[int, Path]
) -> None:
    folder, mine = shutil.copytree(flown[1], tmp_path / "flight"), tmp_path / "mine.py"
    text = "import skylimb\n@skylimb.metric\ndef far(run):\n    return run.log.{}\n"
    for name, code in (("nothing", 1), ("time[-1]", 0)):
        mine.write_text(text.format(name))
        found, out, _ = call(["score", str(folder), "--use", str(mine)], capsys)
        assert found == code
        assert ("metric 'far' fails in" in out) == bool(code)
        assert (folder / "failed.txt").is_file() == bool(code)
        _, listed, _ = call(["runs", str(tmp_path)], capsys)
        assert ("metric 'far' fails in" in listed) == bool(code)
    assert Run.load(folder).metrics["far"] > 5.0
    np.testing.assert_array_equal(Run.load(folder).log.time, Run.load(flown[1]).log.time)


def test_runs_clears_away_what_a_killed_process_left(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    flown: tuple[int, Path],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    whole, half = tmp_path / ".whole.0.partial", tmp_path / ".half.0.partial"
    shutil.copytree(flown[1], whole / "whole")
    (half / "half").mkdir(parents=True)
    (half / "half" / "log.nc").write_bytes((flown[1] / "log.nc").read_bytes()[:1000])
    flying = tmp_path / ".flying.0.partial"
    (flying / "flying").mkdir(parents=True)
    (flying / "flying" / "01-flight.mcap").write_bytes(b"as it was flown")
    known = [(whole, "whole"), (half, "half"), (flying, "flying")]
    monkeypatch.setattr(
        "skylimb.base.files.orphans", lambda folder: [one for one in known if one[0].exists()]
    )
    _, out, _ = call(["runs", str(tmp_path)], capsys)
    assert out.count("left by a process that was killed; `skylimb runs --clean` clears it away") == 3
    _, out, _ = call(["runs", str(tmp_path), "--clean"], capsys)
    assert f"kept as '{tmp_path / 'whole-interrupted'}'" in out
    assert f"{half}: left by a process that was killed; removed" in out
    assert f"kept as '{tmp_path / 'flying-interrupted'}'; `skylimb convert FILE.mcap LOG.nc` reads it" in out
    assert sorted(path.name for path in tmp_path.iterdir()) == ["flying-interrupted", "whole-interrupted"]
    assert call(["runs", str(tmp_path / "nowhere")], capsys)[0] == 2


def test_a_flight_interrupted_at_its_first_tick_leaves_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    stopping = tmp_path / "stopping.py"
    stopping.write_text(
        "class Stopping:\n"
        "    name = 'stopping'\n"
        "    def gains(self): return None\n"
        "    def initial_state(self): return None\n"
        "    def step(self, *arguments): raise KeyboardInterrupt\n"
        "def controller(robot): return Stopping()\n"
    )
    code, _, err = call(["run", "--controller", str(stopping), "--out", str(tmp_path / "out")], capsys)
    assert code == 130
    assert err.startswith("skylimb: error: interrupted")
    assert [
        path.name for path in tmp_path.iterdir() if path.suffix != ".py" and path.name != "__pycache__"
    ] == []


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["rum"], "unknown verb 'rum'; did you mean 'run'?"),
        (["--versoin"], "did you mean '--version'?"),
        (["run", "papr"], "did you mean 'paper'?"),
        (["run", "nowhere.toml"], "no such file: 'nowhere.toml'"),
        (["run", "--controller", "hybird"], "did you mean 'hybrid'?"),
        (["run", "--controller", "nowhere.py"], "nowhere.py"),
        (["run", "--sed", "3"], "did you mean '--seed'?"),
        (["run", "--seed"], "--seed"),
        (["run", "--seed", "three"], "--seed = 'three' is not a whole number"),
        (["run", "--seed", "-1"], "seed = -1"),
        (["run", "--set", "surface.frction=1"], "friction'?"),
        (["run", "--set", "surface.friction"], "expected KEY=VALUE"),
        (["run", "--set", "surface.friction=wet"], "friction = 'wet'"),
        (["run", "--set", "surface.slope=20"], "degrees"),
        (["run", "--set", "trajectory.radius=300"], "300 mm = 0.3 m"),
        (["run", "--set", "seed=1", "seed=2"], "twice"),
        (["run", "--set", "friction=0.2"], "did you mean 'surface.friction'"),
        (["run", "--set", "leak.cutoff=3"], "did you mean 'controller.allocation.leak.cutoff'?"),
        (["run", "--set", "frictoin=0.2"], "did you mean 'surface.friction'"),
        (["run", "--video", "no"], "--video takes no value ('no'): write --video, or --no-video"),
        (["run", "--video=no"], "--video takes no value ('no')"),
        (["compare", "--no-video", "true"], "--video takes no value ('true')"),
        (["run", "--set", "surface.slope=20deg"], "20 deg = 0.349066 rad, so write 0.349066"),
        (["run", "--set", "trajectory.radius=30 cm"], "30 cm = 0.3 m"),
        (["run", "--set", "controller.translation.stifness=1"], "controller"),
        (["run", "paper", "free_flight"], "one argument too many"),
        (["compare", "--controllers"], "names no controller"),
        (["compare", "--controllers", "pid", "mine/pid.toml"], "called alike: pid, pid"),
        (["compare", "--controllers", "pid", "pod"], "did you mean 'pid'?"),
        (["show", "papr"], "did you mean 'paper'?"),
        (["report", "nowhere"], "'nowhere' does not exist"),
        (["report", "x" * 500], "needs a longer name of a file than there may be"),
        (["run", "x" * 500 + ".toml"], "File name too long"),
        (["run", "--controller", "x" * 500 + ".py"], "File name too long"),
        (["view", "nowhere"], "'nowhere' does not exist"),
        (["view", "nowhere", "--speed", "0"], "--speed = 0 must be positive"),
        (["view", "nowhere", "--speed", "fast"], "--speed = 'fast' is not a number"),
        (["view"], "DIR is missing; see skylimb view --help"),
        (["convert"], "LOG and OUT are missing; see skylimb convert --help"),
        (["run", "--out"], "--out needs a value; see skylimb run --help"),
        (["run", "--conroller", "pid"], "did you mean '--controller'?"),
        (
            ["draw", "a.svg", "--order", "nearst"],
            "--order = 'nearst' is not one of given, nearest",
        ),
        (["completion", "csh"], "SHELL = 'csh' is not one of bash, zsh, fish"),
    ],
)
def test_a_mistake_is_one_line_and_writes_nothing(
    words: list[str],
    expected: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    code, out, err = call(words, capsys)
    assert code == 2
    assert out == ""
    assert err.startswith("skylimb: error: ")
    assert err.count("\n") == 1
    assert expected in err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("verb", ["run", "compare", "verify-contact"])
def test_nothing_is_overwritten(verb: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mine = tmp_path / "mine.txt"
    mine.write_text("mine")
    for there in (tmp_path, mine, mine / "below"):
        code, _, err = call([verb, "--out", str(there)], capsys)
        assert code == 2
        assert str(there) in err
    assert mine.read_text() == "mine"
    assert list(tmp_path.iterdir()) == [mine]


def test_list_names_everything_with_a_line(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, _ = call(["list"], capsys)
    assert code == 0
    for name in ("paper", "pid", "impedance", "admittance", "hybrid", "hydrus_xi_quad"):
        (line,) = [line for line in out.splitlines() if line.split()[:1] == [name]]
        assert len(line.split()) > 3


def test_each_tolerance_that_a_flight_missed_has_a_line(capsys: pytest.CaptureFixture[str]) -> None:
    missed = {"done": False, "missed": ["the pen touches 88 % of the time", "the line lies 30 mm beside"]}
    output.verdicts({"hybrid": Run("hybrid", "hybrid", synthetic_log(slide=1.0), missed)})
    assert capsys.readouterr().out.splitlines() == [
        "hybrid was not done as commanded:",
        "  - the pen touches 88 % of the time",
        "  - the line lies 30 mm beside",
    ]


@pytest.mark.parametrize("kind", ["controllers", "controller"])
def test_list_takes_one_kind(kind: str, capsys: pytest.CaptureFixture[str]) -> None:
    code, out, _ = call(["list", kind], capsys)
    names = [line.split()[0] for line in out.splitlines() if line.strip()]
    assert code == 0
    assert "hybrid" in names
    assert "paper" not in names


def test_list_names_the_kinds_that_there_are(capsys: pytest.CaptureFixture[str]) -> None:
    code, _, err = call(["list", "controlers"], capsys)
    assert code == 2
    assert "unknown kind of thing 'controlers'; did you mean 'controllers'?" in err


def test_show_prints_an_experiment_that_can_be_flown(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from skylimb import load_experiment

    code, out, _ = call(["show", "paper"], capsys)
    assert code == 0
    (tmp_path / "mine.toml").write_text(out)
    mine, paper = load_experiment(str(tmp_path / "mine.toml")), load_experiment("paper")
    assert mine == paper


@pytest.mark.parametrize(("name", "words"), [("hybrid", "stiffness = 16.0"), ("hydrus_xi_quad", "4.12")])
def test_show_prints_controllers_and_robots(
    name: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, _ = call(["show", name], capsys)
    assert code == 0
    assert words in out


@pytest.mark.parametrize("verb", VERBS)
def test_every_verb_explains_itself(verb: str, capsys: pytest.CaptureFixture[str]) -> None:
    code, out, _ = call([verb, "--help"], capsys)
    assert code == 0
    assert out.startswith(f"usage: skylimb {verb}")
    assert f"Examples\n  skylimb {verb}" in out


@pytest.mark.parametrize("words", [[], ["-h"], ["--help"], ["help"]])
def test_the_overview_names_every_verb(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    code, out, _ = call(words, capsys)
    assert code == 0
    for verb in VERBS:
        assert f"  {verb} " in out


def test_the_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert call(["--version"], capsys) == (0, f"skylimb {__version__}\n", "")


def test_it_runs_as_a_module() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "skylimb", "--version"], capture_output=True, text=True, check=True
    )
    assert done.stdout == f"skylimb {__version__}\n"


def test_the_contact_is_verified_and_a_failed_claim_exits_with_1(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from skylimb.studies.verification import statics, suite
    from skylimb.studies.verification.row import Evidence, Row

    monkeypatch.setattr(suite, "ROWS", (statics.adhesion,))
    code, out, _ = call(["verify-contact", "--out", str(tmp_path / "contact")], capsys)
    assert code == 0
    assert "1 of 1 claims hold" in out
    assert (tmp_path / "contact" / "contact.html").is_file()

    def wrong() -> Evidence:
        return Evidence(Row("wrong", "Two is one.", 2.0, 1.0, 0.5, "-"), lambda axes: None)

    monkeypatch.setattr(suite, "ROWS", (statics.adhesion, wrong))
    code, out, _ = call(["verify-contact"], capsys)
    assert code == 1
    assert "1 of 2 claims hold" in out
    assert "FAILS" in out


def test_what_planning_has_to_say_is_said_at_once_and_what_flights_have_at_their_end(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with output.flights():
        logging.getLogger("skylimb.flight.any").warning("a servo was slow")
        logging.getLogger("skylimb.control.planning.vectoring_files").warning("searching")
        assert capsys.readouterr().err == "searching\n"
    assert capsys.readouterr().err == "a servo was slow\n"
    with output.flights(at_once=True):  # a pilot cannot wait for the end
        logging.getLogger("skylimb.flight.any").warning("COAST -> DESCEND: no pose for long")
        assert capsys.readouterr().err == "COAST -> DESCEND: no pose for long\n"


def test_what_is_said_of_one_flight_of_several_names_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = synthetic_log()
    of_both, of_one = "the battery sags", "joint2 leaned on its stop"
    runs = {
        name: Run(name, name, log.assign_attrs(notes=json.dumps(notes)))
        for name, notes in (("pid", [of_both]), ("hybrid", [of_both, of_one, of_one]))
    }
    folder = tmp_path / "two of them"
    output.hand_over(runs, folder, failed=["a metric fails"])
    out = capsys.readouterr().out
    assert out.startswith(f"note: {of_both}\nnote: hybrid: {of_one}\na metric fails\n")
    assert f"`skylimb score '{folder}'` makes what failed anew" in out
    output.hand_over({"hybrid": runs["hybrid"]}, folder)
    assert capsys.readouterr().out == f"note: {of_both}\nnote: {of_one}\n"


@pytest.mark.parametrize(
    ("words", "told"),
    [("--help", r"Verbs\n  run +\n"), ("list surfaces", r"surface\.board +\n"), ("run --help", "EXPERIMENT")],
)
def test_where_python_leaves_docstrings_out_commands_do_without(words: str, told: str) -> None:
    command = [sys.executable, "-OO", "-m", "skylimb", *words.split()]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert re.search(told, done.stdout)
    assert "Annotated" not in done.stdout
