"""A run with a user's own files is flown again from its folder, bit by bit, or says what has changed."""

import shutil
import tomllib
from pathlib import Path

import numpy as np
import pytest

import skylimb
from skylimb.analysis.recording.origin import changes_since, moved
from skylimb.analysis.report.output import write_comparison, write_run
from skylimb.apps.cli.main import main
from skylimb.base.errors import ConfigError, OutputError
from skylimb.flight.experiments.experiment import experiment_with, load_experiment
from skylimb.robots import SHIPPED

pytestmark = pytest.mark.usefixtures("no_figures")

LAW = '''
"""A spring."""
from dataclasses import dataclass

from helper_of_spring import pull


@dataclass(frozen=True)
class Gains:
    stiffness: float = 4.0


def initial_state(gains, start):
    return ()


def step(gains, state, inputs):
    body, reference = inputs.estimate.body, inputs.reference
    return (), pull(gains, body, reference), {}
'''
HELPER = """
import numpy as np

DAMPING = 3.0
WEIGHT = np.array([0.0, 0.0, 9.80665])


def pull(gains, body, reference):
    error, slip = reference.position - body.position, reference.velocity - body.velocity
    return body.model.mass * (gains.stiffness * error + DAMPING * slip + WEIGHT)
"""
PRESET = """
description = "mine"
[translation]
law = "spring.py"
[attitude]
law = "impedance"
virtual_inertia_ratio = [10.0, 10.0, 5.0]
normalized_stiffness = [40.0, 40.0, 10.0]
damping_ratio = [1.1, 1.1, 0.8]
[shape]
law = "fixed"
"""
EXPERIMENT = """
description = "A short flight"
[surface]
kind = "heightmap"
file = "relief.csv"
relief = 1.0
position = [3.0, 0.0, 1.2]
[trajectory]
shape = "drawing"
file = "mark.svg"
width = 0.2
[approach]
contact = false
[phases]
settle = 0.5
tare = 0.5
"""
SVG = '<svg xmlns="http://www.w3.org/2000/svg"><path d="M0 0 L10 5" stroke="black" fill="none"/></svg>'


def written(folder: Path) -> Path:
    folder.mkdir(parents=True)
    for name, text in {
        "spring.py": LAW, "helper_of_spring.py": HELPER, "mine.toml": PRESET, "short.toml": EXPERIMENT,
        "relief.csv": "0,0,0,0\n" * 4, "mark.svg": SVG,
    }.items():  # fmt: skip
        (folder / name).write_text(text, encoding="utf-8")
    return folder


def same_bits(one: skylimb.Run, two: skylimb.Run) -> bool:
    return set(one.log.data_vars) == set(two.log.data_vars) and all(
        one.log[name].values.tobytes() == two.log[name].values.tobytes()
        for name in one.log.data_vars
        if one.log[name].dtype.kind != "O"
    )


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> tuple[skylimb.Run, Path]:
    """A run and its folder; what it was made from is changed, and the folder is moved."""
    home = tmp_path_factory.mktemp("own")
    mine = written(home / "mine")
    run = skylimb.run(str(mine / "short.toml"), controller=str(mine / "mine.toml"))
    with pytest.MonkeyPatch.context() as patch:  # as for the tests
        patch.setattr("skylimb.analysis.figures.report_figures.write_figures", lambda *_: [])
        write_run(run, home / "first")
    for name in ("spring.py", "helper_of_spring.py"):
        text = (mine / name).read_text().replace("DAMPING = 3.0", "DAMPING = 1.0").replace("= 4.0", "= 9.0")
        (mine / name).write_text(text)
    (mine / "relief.csv").write_text("0,0,0,0\n0,0.2,0.2,0\n" * 2)
    shutil.rmtree(mine / "mine.toml", ignore_errors=True)
    (home / "first").rename(home / "moved")
    return run, home / "moved"


def test_the_folder_holds_everything_that_the_user_wrote(flown: tuple[skylimb.Run, Path]) -> None:
    run, folder = flown
    names = {path.name for path in (folder / "sources").rglob("*") if path.is_file()}
    assert names == {
        "spring.py", "helper_of_spring.py", "mine.toml", "short.toml", "relief.csv", "mark.svg",
    }  # fmt: skip
    config = tomllib.loads((folder / "config.toml").read_text())
    assert config["surface"]["file"].startswith("sources/relief-")
    assert config["trajectory"]["file"].startswith("sources/mark-")
    assert config["controller"]["translation"]["law"].startswith("sources/spring-")
    assert set(config["recorded"]["files"]) == set(run.sources)
    assert {"mujoco", "casadi", "numpy", "skylimb", "skylimb_code", "compiler"} <= set(
        config["recorded"]["versions"]
    )
    assert "not_repeatable" not in config["recorded"]
    assert str(folder.parent) not in run.config


def test_it_is_flown_again_from_there_bit_by_bit(
    flown: tuple[skylimb.Run, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run, folder = flown
    monkeypatch.chdir(tmp_path)
    again = skylimb.run(str(folder / "config.toml"))
    assert again.notes == ()
    assert same_bits(run, again)
    # A run that was read back and written elsewhere can be flown again as well.
    write_run(skylimb.Run.load(folder), tmp_path / "copy")
    assert load_experiment(str(tmp_path / "copy" / "config.toml")).recorded == {}


def test_a_law_for_a_preset_that_ships_is_sought_where_the_user_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mine = written(tmp_path / "mine")
    monkeypatch.chdir(tmp_path)
    own = {"stop_at": 1.0, "controller.translation.law": "mine/spring.py"}
    run = skylimb.run("mine/short.toml", "hybrid", set=own)
    write_run(run, tmp_path / "kept")
    shutil.rmtree(mine)
    assert same_bits(run, skylimb.run(str(tmp_path / "kept" / "config.toml")))
    with pytest.raises(ConfigError, match=r"mine/spring\.py' does not exist"):
        skylimb.load_controller(
            "hybrid",
            skylimb.load_robot("hydrus_xi_quad"),
            {"translation.law": own["controller.translation.law"]},
        )


def test_an_edited_copy_is_told(flown: tuple[skylimb.Run, Path], tmp_path: Path) -> None:
    run, folder = flown
    shutil.copytree(folder, tmp_path / "edited")
    (helper,) = (tmp_path / "edited" / "sources").rglob("helper_of_spring.py")
    helper.write_text(helper.read_text().replace("DAMPING = 3.0", "DAMPING = 2.5"))
    config = tmp_path / "edited" / "config.toml"
    config.write_text(config.read_text().replace("settle = 0.5", "settle = 0.6"))
    again = skylimb.run(str(config))
    assert [note.partition("sources/spring-")[0] for note in again.notes] == [
        "its configuration was edited since it was recorded", "'",
    ]  # fmt: skip
    assert again.notes[1].endswith("/helper_of_spring.py' was edited since it was recorded")
    assert not same_bits(run, again)


def test_another_version_and_a_missing_copy_are_told(flown: tuple[skylimb.Run, Path], tmp_path: Path) -> None:
    run, folder = flown
    tables = tomllib.loads((folder / "config.toml").read_text())
    now = tables["recorded"]["versions"]
    assert changes_since(tables, folder, now) == []
    assert changes_since(tables, folder, {**now, "mujoco": "9.9", "compiler": "other"}) == [
        f"mujoco was {now['mujoco']}, here it is 9.9"
    ]
    missing = changes_since(tables, tmp_path, now)
    assert len(missing) == len(run.sources)
    assert all(line.endswith("is missing") for line in missing)
    assert changes_since({"name": "no run's"}, tmp_path, now) == []


def test_the_command_line_tells_it(
    flown: tuple[skylimb.Run, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(flown[1], tmp_path / "edited")
    (svg,) = (tmp_path / "edited" / "sources").rglob("mark.svg")
    svg.write_text(SVG.replace("10 5", "10 6"))
    main(["run", str(tmp_path / "edited" / "config.toml"), "--no-video", "--out", str(tmp_path / "out")])
    notes = [line for line in capsys.readouterr().out.splitlines() if line.startswith("note: ")]
    assert len(notes) == 1
    assert notes[0].endswith("mark.svg' was edited since it was recorded")


def test_a_comparison_has_one_copy_for_all_of_its_runs(
    flown: tuple[skylimb.Run, Path], tmp_path: Path
) -> None:
    run, _ = flown
    runs = {name: skylimb.Run(name, name, run.log, run.metrics, run.sources) for name in ("one", "two")}
    write_comparison(runs, tmp_path / "both")
    assert not list((tmp_path / "both" / "one").glob("sources"))
    assert len(list((tmp_path / "both" / "sources").rglob("spring.py"))) == 1
    for name in runs:
        config = tmp_path / "both" / name / "config.toml"
        experiment = load_experiment(str(config))
        assert experiment.recorded == {}
        assert Path(experiment.trajectory.file).is_file()
        assert skylimb.Run.load(tmp_path / "both" / name).config == config.read_text()
    assert moved("a = 1\n", "../") == "a = 1\n"


OVERSHOOT = """
import skylimb
from twice_of_mine import twice


@skylimb.metric(unit="s")
def doubled_time(run):
    return twice(float(run.log.time.values[-1]))
"""

CONTROLLER = """
from dataclasses import dataclass

import skylimb
from skylimb.symbolic import vector


@dataclass(frozen=True)
class Gains:
    thrust: float = 10.0


class Falling:
    name = "falling"

    def gains(self):
        return Gains()

    def initial_state(self):
        return ()

    def step(self, gains, state, measurement, reference, dt):
        thrusts = vector(gains.thrust, gains.thrust, gains.thrust, gains.thrust)
        return (), skylimb.Command(thrusts, reference.joint_angles, reference.vectoring_angles), {}


def controller(robot):
    return Falling()
"""


def test_a_controller_and_metrics_of_ones_own_are_flown_again(tmp_path: Path) -> None:
    mine = tmp_path / "mine"
    mine.mkdir()
    for name, text in {
        "falling.py": CONTROLLER, "doubled.py": OVERSHOOT,
        "twice_of_mine.py": "def twice(x):\n    return 2.0 * x\n",
    }.items():  # fmt: skip
        (mine / name).write_text(text)
    changes = {"phases.settle": 0.1, "terminations.height": 0.9, "controller.thrust": 11.0}
    run = skylimb.run("free_flight", str(mine / "falling.py"), set=changes, use=(str(mine / "doubled.py"),))
    write_comparison({"falling": run}, tmp_path / "both")
    shutil.rmtree(mine)
    (tmp_path / "both").rename(tmp_path / "moved")
    config = tmp_path / "moved" / "falling" / "config.toml"
    assert tomllib.loads(config.read_text())["controller"]["thrust"] == 11.0
    again = skylimb.run(str(config))
    assert again.notes == ()
    assert same_bits(run, again)
    assert "doubled_time" in run.metrics
    assert set(again.metrics) == set(run.metrics)
    assert {Path(name).name for name in again.sources} >= {"falling.py", "doubled.py", "twice_of_mine.py"}


class Object:
    """A controller that is handed over."""

    name = "thing"

    def gains(self) -> None:
        return None

    def initial_state(self) -> None:
        return None

    def step(self, gains, state, measurement, reference, dt):
        thrusts = np.full(4, 10.0)
        return None, skylimb.Command(thrusts, reference.joint_angles, reference.vectoring_angles), {}


def test_a_controller_that_was_handed_over_says_why_it_cannot_be_repeated(tmp_path: Path) -> None:
    experiment = load_experiment("free_flight", {"phases.settle": 0.1, "terminations.height": 0.5})
    run = skylimb.run(experiment, controller=Object())  # type: ignore[arg-type]
    (note,) = run.notes
    assert note.startswith("this run cannot be repeated: controller 'thing' was handed over as an object")
    assert "a copy of test_repeating.py is kept" in note
    assert [Path(name).name for name in run.sources] == ["test_repeating.py"]
    assert tomllib.loads(run.config)["recorded"]["not_repeatable"]


class Counting(Object):
    """One that remembers its ticks itself."""

    def __init__(self) -> None:
        self.ticks = 0

    def step(self, gains, state, measurement, reference, dt):
        self.ticks += 1
        return super().step(gains, state, measurement, reference, dt)


def test_a_controller_at_hand_that_remembers_says_that_its_next_flight_is_another_one() -> None:
    experiment = load_experiment("free_flight", {"phases.settle": 0.1, "terminations.height": 0.5})
    (note,) = skylimb.run(experiment, controller=Counting()).notes  # type: ignore[arg-type]
    assert "; it has changed its own 'ticks', with which its next flight begins; a Python file" in note
    (note,) = skylimb.run(experiment, controller=Object()).notes  # type: ignore[arg-type]
    assert "its own" not in note


def test_a_robot_of_ones_own_is_kept_with_its_vectoring_angles(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(SHIPPED / "hydrus_xi_quad", tmp_path / "mine" / "my_robot")
    for table in (tmp_path / "mine" / "my_robot").glob("vectoring*.toml"):
        table.unlink()
    (tmp_path / "mine" / "short.toml").write_text('robot = "my_robot"\n')
    monkeypatch.chdir(tmp_path)
    experiment = load_experiment("mine/short.toml")
    monkeypatch.chdir(tmp_path / "mine")
    flight = skylimb.begin(experiment, set={"phases.settle": 0.1})
    flight.tick()
    run = flight.finish()
    place = tomllib.loads(run.config)["robot"]
    assert place.startswith("sources/my_robot-")
    assert place.endswith("/flight.toml")
    assert {Path(name).name for name in run.sources} == {
        "flight.toml", "hydrus_xi_quad.urdf", "vectoring.toml",
    }  # fmt: skip
    write_run(run, tmp_path / "run")
    shutil.rmtree(tmp_path / "mine")
    again = skylimb.load_robot(load_experiment(str(tmp_path / "run" / "config.toml")).robot)
    assert again.description.digest == flight.takeoff.robot.description.digest


def test_files_that_an_experiment_names_lie_beside_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mine = written(tmp_path / "mine")
    monkeypatch.chdir(tmp_path)
    experiment = load_experiment("mine/short.toml")
    assert experiment.trajectory.file == (mine / "mark.svg").as_posix()
    # From Python and with --set, a path is as it stands.
    assert (
        experiment_with(experiment, {"trajectory.file": "mine/mark.svg"}).trajectory.file == "mine/mark.svg"
    )
    assert load_experiment("paper").robot == "hydrus_xi_quad"


def test_the_logs_of_a_campaign_share_one_copy_and_are_flown_again(tmp_path: Path) -> None:
    pytest.importorskip("pyarrow")
    from skylimb.studies.campaign import run_campaign

    mine = written(tmp_path / "mine")
    short = (mine / "short.toml").read_text().replace("settle = 0.5", "settle = 0.1").replace("0.5", "0.2")
    (mine / "short.toml").write_text(short + "[terminations]\nheight = 0.9\n")
    (mine / "campaign.toml").write_text(
        'experiment = "short.toml"\ncontrollers = ["mine.toml"]\ndraws = 2\nlogs = "all"\n'
        '[vary."plant.thrust_scale"]\nuniform = [0.5, 0.55]\n'
    )
    run_campaign(mine / "campaign.toml", tmp_path / "out", workers=0)
    # Going on with another helper would mix two controllers in one table.
    helper = mine / "helper_of_spring.py"
    helper.write_text(helper.read_text().replace("DAMPING = 3.0", "DAMPING = 2.0"))
    with pytest.raises(
        OutputError,
        match=r"begun with another campaign: .*code\.translation.*helper_of_spring\.py' has changed\)",
    ):
        run_campaign(mine / "campaign.toml", tmp_path / "out", workers=0, resume=True)
    shutil.rmtree(mine)
    (tmp_path / "out").rename(tmp_path / "moved")
    logs = sorted((tmp_path / "moved" / "logs").iterdir())
    assert len(logs) == 2
    assert len(list((tmp_path / "moved").rglob("spring.py"))) == 1
    for log in logs:
        assert {path.name for path in log.iterdir()} == {"log.nc", "config.toml"}
        flown_then, again = skylimb.Run.load(log), skylimb.run(str(log / "config.toml"))
        assert again.notes == ()
        assert same_bits(flown_then, again)
