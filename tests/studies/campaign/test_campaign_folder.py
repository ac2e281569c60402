import json
import os
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable, Mapping
from pathlib import Path

import pyarrow.parquet as pq
import pytest

import skylimb
from skylimb.analysis.recording import Run
from skylimb.analysis.recording.versions import code_digest
from skylimb.analysis.scores.registry import NUMERIC_KEYS
from skylimb.apps.cli import main
from skylimb.base.errors import CompileError, ConfigError, OutputError
from skylimb.studies.campaign import report_campaign, run_campaign
from skylimb.studies.campaign.folder import SPEC_FILE, TABLE_FILE, load_campaign
from skylimb.studies.campaign.report import command
from skylimb.studies.campaign.store import load_rows
from skylimb.studies.campaign.table import write_table

SpecWriter = Callable[..., Path]
Contents = Callable[[Path], dict[str, bytes]]

AT_REST = {"spec.toml", "flights.parquet", "summary.json", "report.html", "logs"}


@pytest.fixture(scope="module")
def once(tmp_path_factory: pytest.TempPathFactory, write_spec_to: Callable[..., Path]) -> Path:
    home = tmp_path_factory.mktemp("campaign")
    run_campaign(write_spec_to(home), home / "out", workers=0)
    return home


@pytest.fixture
def flown(once: Path, tmp_path: Path) -> tuple[Path, Path]:
    """A spec and its finished folder, a copy to be spoilt: two controllers, four draws."""
    shutil.copytree(once, tmp_path, dirs_exist_ok=True)
    return tmp_path / "spec.toml", tmp_path / "out"


def test_a_finished_folder_holds_what_it_promises(flown: tuple[Path, Path]) -> None:
    _, folder = flown
    assert {path.name for path in folder.iterdir()} == AT_REST
    table = pq.read_table(folder / TABLE_FILE).to_pylist()
    assert [row["flight"] for row in table] == list(range(8))
    assert [row["controller"] for row in table[:4]] == ["pid", "hybrid"] * 2
    assert len({row["plant.thrust_scale"] for row in table}) == 4
    assert {*NUMERIC_KEYS, "seed", "status", "cause", "versions"} <= set(table[0])
    assert "driver" not in table[0]["versions"]
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["flights"] == 8
    page = (folder / "report.html").read_text()
    assert "http" not in page.replace("http-equiv", "")
    assert "Worst flights" in page


def test_a_report_of_one_draw_speaks_of_one(write_spec: SpecWriter, tmp_path: Path) -> None:
    run_campaign(write_spec(draws=1), tmp_path / "out", workers=0)
    page = (tmp_path / "out" / "report.html").read_text()
    assert "2 controllers, 1 draw<" in page
    assert "2 flights over 1 paired draw<" in page


@pytest.mark.usefixtures("plain_report")
def test_a_folder_of_before_a_score_was_there_has_its_report(flown: tuple[Path, Path]) -> None:
    folder = flown[1]
    campaign = load_campaign(folder)
    rows, _ = load_rows(folder, campaign)
    older = [{key: value for key, value in row.items() if key != "tilt_max"} for row in rows.values()]
    write_table(folder / TABLE_FILE, older, campaign)
    summary = report_campaign(folder).summary
    assert summary is not None
    assert "error_u_median" in summary.medians
    assert "tilt_max" not in summary.medians


@pytest.mark.usefixtures("plain_report", "no_figures")
def test_the_command_of_a_worst_flight_flies_the_same_bits(tmp_path: Path, write_spec: SpecWriter) -> None:
    vary = """
    "surface.friction" = { uniform = [0.1, 0.8] }
    "plant.cog_offset.0" = { normal = [0.0, 0.001] }
    "plant.rotor_scale" = { normal = [1.0, 0.01], size = 4 }
    "controller.attitude.damping_ratio.2" = { choice = [0.7, 0.9] }
    "events.0.rotor" = { grid = ["rotor1", "rotor2"] }
    """
    spec = write_spec(draws=2, vary=vary)
    event = (
        '{ kind = "rotor", time = 0.3, duration = 0.0, latest = 0.6, effectiveness = 0.9, rotor = "rotor1" }'
    )
    spec.write_text(spec.read_text().replace("[set]", f"[set]\nevents = [{event}]"))
    outcome = run_campaign(spec, tmp_path / "out", workers=0)
    text = command(outcome.campaign, outcome.rows[3])
    assert text.startswith("skylimb run paper --controller hybrid --seed ")
    assert _flown_again(text, tmp_path) == _numbers(outcome.rows[3])


@pytest.mark.usefixtures("plain_report", "no_figures")
def test_the_command_of_a_calibrated_flight_flies_the_same_bits(
    tmp_path: Path, write_spec: SpecWriter, write_calibration: Callable[[Path], Path]
) -> None:
    calibration = write_calibration(tmp_path / "my calibration.toml")
    spec, out = write_spec(draws=1), tmp_path / "out"
    outcome = skylimb.campaign(spec, out, calibration=calibration, workers=0)
    plain = skylimb.campaign(spec, tmp_path / "plain", workers=0)
    again = _flown_again(command(outcome.campaign, outcome.rows[1]), tmp_path)
    assert again == _numbers(outcome.rows[1]) != _numbers(plain.rows[1])


def _numbers(scores: Mapping[str, float]) -> dict[str, float]:
    return {key: scores[key] for key in NUMERIC_KEYS}


def _flown_again(text: str, home: Path) -> dict[str, float]:
    """The scores of the flight of a command line."""
    assert main([*shlex.split(text)[1:], "--out", str(home / "again")]) == 0
    return _numbers(Run.load(home / "again").metrics)


@pytest.mark.usefixtures("plain_report")
def test_flights_that_the_experiment_stops_have_come_to_their_end(
    tmp_path: Path, write_spec: SpecWriter
) -> None:
    spec = write_spec(draws=2, head='logs = "all"')
    spec.write_text(spec.read_text().replace("[set]", "[set]\nstop_at = 0.6"))
    outcome = run_campaign(spec, tmp_path / "stopped", workers=0)
    assert [row["status"] for row in outcome.rows.values()] == ["STOPPED"] * 4
    assert outcome.summary is not None
    assert outcome.summary.scores.finished.all()
    assert outcome.summary.scores.success.all()
    assert not outcome.summary.lost
    assert {row["tilt_max"] is not None for row in outcome.rows.values()} == {True}
    assert len(list((tmp_path / "stopped" / "logs").iterdir())) == 4


def test_a_finished_campaign_resumes_to_itself(flown: tuple[Path, Path], contents: Contents) -> None:
    spec, folder = flown
    before = contents(folder)
    assert run_campaign(spec, folder, workers=0, resume=True).complete
    assert contents(folder) == before
    report_campaign(folder)
    assert contents(folder) == before


def test_without_resume_nothing_is_touched(flown: tuple[Path, Path], contents: Contents) -> None:
    spec, folder = flown
    before = contents(folder)
    with pytest.raises(OutputError, match="--resume"):
        run_campaign(spec, folder, workers=0)
    assert contents(folder) == before


def test_a_changed_spec_is_refused_with_the_difference(
    flown: tuple[Path, Path], capsys: pytest.CaptureFixture[str], contents: Contents
) -> None:
    spec, folder = flown
    before = contents(folder)
    spec.write_text(spec.read_text().replace("seed = 7", "seed = 8").replace("[0.9, 1.1]", "[0.9, 1.2]"))
    assert main(["campaign", str(spec), "--out", str(folder), "--resume"]) == 2
    message = capsys.readouterr().err
    assert "seed: 7 -> 8" in message
    assert "[0.9, 1.1] -> [0.9, 1.2]" in message
    assert contents(folder) == before


def test_another_version_is_refused_with_the_difference(flown: tuple[Path, Path], contents: Contents) -> None:
    spec, folder = flown
    path = folder / SPEC_FILE
    path.write_text(path.read_text().replace('mujoco = "4', 'mujoco = "3'))
    before = contents(folder)
    with pytest.raises(OutputError, match=r"frozen\.versions\.mujoco: '3.*' -> '4"):
        run_campaign(spec, folder, workers=0, resume=True)
    path.write_text(path.read_text().replace('mujoco = "3', 'mujoco = "4'))
    code = code_digest()
    path.write_text(path.read_text().replace(code, "0123456789ab"))
    with pytest.raises(OutputError, match=rf"frozen\.versions\.skylimb_code: '0123456789ab' -> '{code}'"):
        run_campaign(spec, folder, workers=0, resume=True)
    path.write_text(path.read_text().replace("format = 4", "format = 3"))  # as an earlier skylimb wrote it
    for use in (lambda: run_campaign(spec, folder, workers=0, resume=True), lambda: report_campaign(folder)):
        with pytest.raises(OutputError, match=r"spec\.toml' has folder format 3, .* fly anew") as caught:
            use()
        assert len(str(caught.value).splitlines()) == 1
    assert contents(folder) != before
    assert {k: v for k, v in contents(folder).items() if k != SPEC_FILE} == {
        k: v for k, v in before.items() if k != SPEC_FILE
    }


@pytest.mark.usefixtures("plain_report")
def test_changed_code_of_a_users_controller_is_refused(write_spec: SpecWriter, tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(HOVER)
    spec = write_spec(draws=1, controllers='["mine.py"]')
    run_campaign(spec, tmp_path / "out", workers=0)
    (tmp_path / "mine.py").write_text(HOVER + "\n# another one\n")
    with pytest.raises(OutputError, match=r"frozen\.controllers\.mine\.code"):
        run_campaign(spec, tmp_path / "out", workers=0, resume=True)


def test_another_folder_is_no_campaign(write_spec: SpecWriter, tmp_path: Path) -> None:
    (tmp_path / "other").mkdir()
    with pytest.raises(OutputError, match="holds no campaign"):
        run_campaign(write_spec(), tmp_path / "other", workers=0, resume=True)
    with pytest.raises(OutputError, match="does not exist"):
        report_campaign(tmp_path / "nowhere")
    assert not list((tmp_path / "other").iterdir())


def test_a_mistake_leaves_no_folder(write_spec: SpecWriter, tmp_path: Path) -> None:
    spec = write_spec(vary='"surface.fricton" = { uniform = [0.1, 0.8] }')
    assert main(["campaign", str(spec), "--out", str(tmp_path / "out"), "--workers", "0"]) == 2
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(("policy", "count"), [("none", 0), ("worst 3", 3), ("all", 4)])
def test_logs_are_kept_by_policy(
    policy: str, count: int, write_spec: SpecWriter, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("skylimb.studies.campaign.report.report_figures", lambda *_: [])
    spec = write_spec(draws=2, head=f'logs = "{policy}"\nscore = "tilt_max"')
    outcome = run_campaign(spec, tmp_path / "out", workers=0)
    kept = sorted((tmp_path / "out" / "logs").iterdir())
    assert len(kept) == count
    for folder in kept:
        run, row = Run.load(folder), outcome.rows[int(folder.name[:6])]
        assert run.metrics["tilt_max"] == row["tilt_max"]
        assert run.controller == row["controller"]
    page = (tmp_path / "out" / "report.html").read_text()
    assert ("Watch the worst" in page) == ('id="replay-data"' in page) == (count > 0)
    assert [f"flight {int(folder.name[:6])}" in page for folder in kept] == [True] * count


@pytest.mark.usefixtures("plain_report")
def test_losses_keep_their_logs_and_count(write_spec: SpecWriter, tmp_path: Path) -> None:
    vary = '"plant.thrust_scale" = { grid = [1.0, 0.5] }'
    more = '"trajectory.duration" = 3.0'
    spec = write_spec(draws=2, vary=vary)
    spec.write_text(spec.read_text().replace('"trajectory.duration" = 0.4', more))
    outcome = run_campaign(spec, tmp_path / "out", workers=0)
    lost = [row["flight"] for row in outcome.rows.values() if row["status"] == "FAILED"]
    assert lost == [2, 3]
    assert {path.name for path in (tmp_path / "out" / "logs").iterdir()} == {"000002-pid", "000003-hybrid"}
    assert outcome.summary is not None
    assert outcome.summary.rates["pid"][:2] == (1, 2)
    assert outcome.rows[2]["cause"]
    assert outcome.rows[2]["tilt_max"] is None


@pytest.mark.usefixtures("plain_report")
def test_a_draw_that_nobody_can_fly_is_named_and_charged_to_nobody(
    write_spec: SpecWriter, tmp_path: Path
) -> None:
    spec = write_spec(draws=2, vary='"approach.standoff" = { grid = [0.3, 0.0] }')
    spec.write_text(spec.read_text().replace('"approach.contact" = false', ""))
    outcome = run_campaign(spec, tmp_path / "out", workers=0)
    assert outcome.summary is not None
    assert [row["status"] for row in outcome.rows.values()] == ["OK", "OK", "REFUSED", "REFUSED"]
    assert "starts clear" in outcome.rows[2]["cause"]
    scores = outcome.summary.scores
    assert list(scores.draws) == [0]
    assert scores.refused == {1: outcome.rows[2]["cause"]}


@pytest.mark.usefixtures("plain_report")
def test_a_draw_that_one_controller_cannot_fly_names_it(write_spec: SpecWriter, tmp_path: Path) -> None:
    needy = HOVER.replace('    name = "hover"', '    name = "hover"\n    needs = Needs(imu=True)')
    (tmp_path / "needy.py").write_text(f"from skylimb.control.needs import Needs\n{needy}")
    vary = '"sensors.imu.on" = { grid = [true, false] }'
    spec = write_spec(draws=2, controllers='["pid", "needy.py"]', vary=vary)
    outcome = run_campaign(spec, tmp_path / "out", workers=0)
    assert [row["status"] for row in outcome.rows.values()] == ["OK", "OK", "OK", "REFUSED"]
    assert outcome.summary is not None
    (cause,) = outcome.summary.scores.refused.values()
    assert cause.startswith("needy: ")
    without = write_spec(draws=2, controllers='["pid", "needy.py"]', name="without.toml")
    with pytest.raises(ConfigError, match=r"controller 'needy' can fly none of 2 draws; draw 0: .*imu"):
        run_campaign(without, tmp_path / "no", workers=0)
    assert not (tmp_path / "no").exists()


@pytest.mark.usefixtures("plain_report")
def test_a_users_mistake_in_flight_is_a_loss_of_that_controller(
    write_spec: SpecWriter, tmp_path: Path
) -> None:
    counted = HOVER.replace("(self):\n        return None", "(self):\n        return 0.0")
    text = counted.replace("return state,", "1 / (0 if state > 20.0 else 1)\n        return state + 1.0,")
    (tmp_path / "faulty.py").write_text(text)
    outcome = run_campaign(
        write_spec(draws=1, controllers='["pid", "faulty.py"]'), tmp_path / "out", workers=0
    )
    assert [row["status"] for row in outcome.rows.values()] == ["OK", "FAILED"]
    assert "ZeroDivisionError" in outcome.rows[1]["cause"]


@pytest.mark.usefixtures("plain_report")
def test_a_flight_that_cannot_be_repeated_says_so_in_its_row(write_spec: SpecWriter, tmp_path: Path) -> None:
    drawn = HOVER.replace("model.hover_thrusts,", "model.hover_thrusts + 1e-3 * np.random.rand(),")
    assert drawn != HOVER
    (tmp_path / "odd.py").write_text(drawn)
    outcome = run_campaign(write_spec(draws=1, controllers='["pid", "odd.py"]'), tmp_path / "out", workers=0)
    known, other = (row["cause"] for row in outcome.rows.values())
    assert "repeated" not in known
    assert other.startswith("this run cannot be repeated: controller ")


@pytest.mark.usefixtures("plain_report")
def test_the_stopping_rule_ends_a_campaign_early(write_spec: SpecWriter, tmp_path: Path) -> None:
    more = '[stop]\nuntil = "tilt_max"\nwidth = 1.0\nevery = 2\nat_least = 4'
    outcome = run_campaign(write_spec(draws=12, more=more), tmp_path / "out", workers=0)
    assert len(outcome.rows) == 8
    narrow = more.replace("width = 1.0", "width = 1e-12")
    outcome = run_campaign(write_spec(draws=6, more=narrow, name="n.toml"), tmp_path / "all", workers=0)
    assert len(outcome.rows) == 12


@pytest.mark.slow
def test_a_full_disk_stops_cleanly_and_goes_on(
    write_spec: SpecWriter, tmp_path: Path, contents: Contents
) -> None:
    """On a disk that is full from the start, also the cache of compiled code cannot be written.

    The campaign then flies with the Python driver. It goes on with the native one where that is possible: the
    driver is no part of what a campaign is.
    """
    spec, folder = write_spec(draws=12), tmp_path / "out"
    script = (
        "import resource, sys; from skylimb.apps.cli import main; "
        "resource.setrlimit(resource.RLIMIT_FSIZE, (24576, 24576)); sys.exit(main(sys.argv[1:]))"
    )
    words = ["campaign", str(spec), "--out", str(folder), "--workers", "0"]
    done = subprocess.run(
        [sys.executable, "-c", script, *words],
        capture_output=True, text=True, check=False, timeout=120,
        env={**os.environ, "XDG_CACHE_HOME": str(tmp_path / "cache")},
    )  # fmt: skip
    assert done.returncode == 2, done.stderr
    assert f"cannot write to '{folder}'" in done.stderr
    assert "--resume" in done.stderr
    assert len(done.stderr.splitlines()) == 1
    kept, _ = load_rows(folder, load_campaign(folder))
    assert 0 < len(kept) < 24
    assert run_campaign(spec, folder, workers=0, resume=True).complete
    run_campaign(spec, tmp_path / "undisturbed", workers=0)
    assert contents(folder) == contents(tmp_path / "undisturbed")


@pytest.mark.usefixtures("plain_report")
@pytest.mark.parametrize("reason", ["", "no C compiler"])
def test_a_cache_that_cannot_be_written_decides_nothing(
    reason: str, write_spec: SpecWriter, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, contents: Contents
) -> None:
    """Neither a driver that cannot be used at all nor a tick that cannot be compiled changes a bit."""
    from skylimb.studies.campaign import worker

    def refuse(jobs: object) -> None:
        raise CompileError("compiled code cannot be kept in the cache")

    spec = write_spec(draws=3, name="spec.toml")
    with monkeypatch.context() as patch:
        patch.setattr(worker, "unavailable", lambda: reason)
        patch.setattr(worker, "fly_native", refuse)
        run_campaign(spec, tmp_path / "python", workers=0)
    run_campaign(spec, tmp_path / "best", workers=0)
    assert contents(tmp_path / "python") == contents(tmp_path / "best")


HOVER = """
import numpy as np
from skylimb import Command


class Hover:
    name = "hover"

    def __init__(self, robot):
        self.robot = robot

    def gains(self):
        return None

    def initial_state(self):
        return None

    def step(self, gains, state, measurement, reference, dt):
        model = self.robot.at(measurement.joint_angles, measurement.vectoring_angles)
        command = Command(model.hover_thrusts, reference.joint_angles, reference.vectoring_angles)
        return state, command, {}


def controller(robot):
    return Hover(robot)
"""


def test_the_verbs_print_a_table_and_where_the_report_is(
    flown: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    _, folder = flown
    assert main(["campaign", "report", str(folder)]) == 0
    out = capsys.readouterr().out
    assert "Flown to the end" in out  # no bound says what a success is
    assert str(folder / "report.html") in out
    for words in (["campaign", "--help"], ["campaign", "report", "--help"], ["tune", "--help"]):
        assert main(words) == 0
        assert "Examples" in capsys.readouterr().out
    assert main(["campaign", "spec.toml", "--workers", "many"]) == 2
    assert "--workers = 'many'" in capsys.readouterr().err
