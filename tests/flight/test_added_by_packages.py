"""What an installed package adds is found by name, flown and recorded as a user's own file is."""

import shutil
from pathlib import Path

import numpy as np
import pytest

import skylimb
from skylimb.analysis.report.output import write_run
from skylimb.apps.cli.main import main
from skylimb.base.errors import ConfigError, UnknownNameError
from skylimb.control.laws.preset import PRESETS, preset_file
from skylimb.control.laws.slots import SLOTS, law_file
from skylimb.robots import SHIPPED
from skylimb.simulation.surfaces import SURFACES, surface_from_mapping
from skylimb.studies.campaign.frozen import freeze
from skylimb.studies.campaign.spec import CampaignSpec

EXAMPLES = Path(__file__).parents[2] / "examples"

TASK = """description = "A short task of theirs"
robot = "their_quad"
stop_at = 1.0

[surface]
kind = "their_saddle"
position = [1.5, 0.0, 1.2]
bend = 0.2
"""

ENTRIES = {
    "laws": {"translation.their_spring": "their_lab.spring"},
    "controllers": {"their_springy": "their_lab.presets.springy", "their_upright": "their_lab.upright"},
    "robots": {"their_quad": "their_lab.quad"},
    "surfaces": {"their_saddle": "their_lab.saddle"},
    "experiments": {"their_task": "their_lab.task"},
    "metrics": {"their_hardest": "their_lab.hardest"},
}


def install(place: Path, package: str, entries: dict[str, dict[str, str]]) -> None:
    """What pip leaves of a package: what it says of itself."""
    info = place / f"{package}-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: 1.0\n")
    groups = (
        f"[skylimb.{group}]\n" + "".join(f"{name} = {value}\n" for name, value in named.items())
        for group, named in entries.items()
    )
    (info / "entry_points.txt").write_text("\n".join(groups))


@pytest.fixture
def lab(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A package with one of everything, on Python's path."""
    place = tmp_path / "site"
    folder = place / "their_lab"
    install(place, "their_lab", ENTRIES)
    (folder / "presets").mkdir(parents=True)
    (folder / "__init__.py").write_text("raise RuntimeError('nobody needs to import me')\n")
    preset = (EXAMPLES / "laws" / "spring.toml").read_text().replace("spring.py", "their_spring")
    (folder / "presets" / "springy.toml").write_text(preset)
    shutil.copy(EXAMPLES / "laws" / "spring.py", folder / "spring.py")
    shutil.copy(EXAMPLES / "user_controller.py", folder / "upright.py")
    shutil.copy(EXAMPLES / "surfaces" / "saddle.py", folder / "saddle.py")
    shutil.copy(EXAMPLES / "metrics" / "hardest.py", folder / "hardest.py")
    shutil.copytree(SHIPPED / "hydrus_xi_quad", folder / "quad")
    (folder / "task.toml").write_text(TASK)
    monkeypatch.syspath_prepend(place)
    return folder


@pytest.mark.usefixtures("no_figures")
def test_it_flies_and_its_record_needs_the_package_no_more(
    lab: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = skylimb.run("their_task", "their_springy", use=["their_hardest"])
    assert "stopped" in run.cause
    assert "spring_force" in run.log
    assert "hardest" in run.metrics
    write_run(run, tmp_path / "out")
    shutil.rmtree(lab)
    monkeypatch.undo()
    again = skylimb.run(str(tmp_path / "out" / "config.toml"))
    assert np.array_equal(again.log.configuration, run.log.configuration)
    assert "hardest" in again.metrics


def test_a_controller_in_python_is_found_by_its_name(lab: Path) -> None:
    robot = skylimb.load_robot("their_quad")
    assert robot.description.folder == lab / "quad"
    assert skylimb.load_controller("their_upright", robot).name == "upright"


def test_a_campaign_knows_when_their_code_has_changed(lab: Path) -> None:
    spec = CampaignSpec("their_task", ("their_springy", "their_upright"), draws=1, use=("their_hardest",))
    before = freeze(spec)
    (lab / "spring.py").write_text((lab / "spring.py").read_text() + "\n# another one\n")
    after = freeze(spec)
    assert before.controllers["their_springy"]["code"] != after.controllers["their_springy"]["code"]
    assert before.use == after.use


@pytest.mark.usefixtures("lab")
def test_they_are_listed_and_shown(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list"]) == 0
    told = capsys.readouterr().out
    for group, named in ENTRIES.items():
        for name in named:
            (line,) = (line for line in told.splitlines() if f"{group[:-1]} {name} " in line)
            assert "their_lab 1.0" in line
    for name in ("their_task", "their_springy", "their_upright", "their_quad"):
        assert main(["show", name]) == 0
    assert "stiffness" in capsys.readouterr().out
    assert main(["new", "law", "their_spring"]) == 2
    assert "'their_spring' is there already" in capsys.readouterr().err


@pytest.mark.usefixtures("lab")
def test_a_misspelt_name_of_theirs_is_guessed() -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'their_task'"):
        skylimb.run("their_tusk")
    with pytest.raises(UnknownNameError, match="did you mean 'their_spring'"):
        skylimb.run("paper", set={"controller.translation.law": "their_sprig"})
    with pytest.raises(UnknownNameError, match="did you mean 'their_saddle'"):
        skylimb.run("paper", set={"surface.kind": "their_sadle"})
    with pytest.raises(UnknownNameError, match="did you mean 'their_quad'"):
        skylimb.load_robot("their_quat")


def test_a_broken_package_costs_its_own_names(lab: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (lab / "spring.py").write_text("import nothing_like_it\n")
    (lab / "task.toml").unlink()
    assert main(["run", "paper", "--controller", "their_springy"]) == 2
    said = capsys.readouterr().err
    assert "spring.py" in said
    assert "nothing_like_it" in said
    assert said.count("\n") == 1
    with pytest.raises(ConfigError, match=r"'their_task' of package their_lab 1\.0 should name a file"):
        skylimb.load_experiment("their_task")
    assert main(["list"]) == 0
    (line,) = (line for line in capsys.readouterr().out.splitlines() if "experiment their_task" in line)
    assert "not usable" in line
    assert skylimb.load_experiment("paper").name == "paper"


@pytest.mark.usefixtures("lab")
def test_a_name_belongs_to_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    laws = dict.fromkeys(("translation.pid", "translaton.soft", "no_slot"), "their_lab.spring")
    ours = {"controllers": {"pid": "their_lab.upright"}, "surfaces": {"board": "their_lab.saddle"}}
    more = {"laws": laws, **ours, "robots": {"their_quad": "their_lab.quad"}}
    install(tmp_path / "others", "other_lab", more)
    monkeypatch.syspath_prepend(tmp_path / "others")
    assert preset_file("pid").parent == PRESETS
    assert law_file("translation", "pid", tmp_path) is None
    assert isinstance(surface_from_mapping({"kind": "board"}), SURFACES["board"])
    with pytest.raises(UnknownNameError, match=r"known: following, impedance, mpc, pid, task_frame, their_"):
        law_file("translation", "nothing_like_it", tmp_path)
    assert main(["list"]) == 0
    told = " ".join(capsys.readouterr().out.split())
    for name in ("translation.pid", "pid", "board"):
        assert f"not usable: skylimb itself has '{name}', other_lab 1.0 has to call it otherwise" in told
    for name, hint in (("translaton.soft", "; did you mean 'translation'?"), ("no_slot", "")):
        said = f"not usable: '{name}' of other_lab 1.0 should begin with its slot's name, one of "
        assert f"{said}{', '.join(SLOTS)}{hint}" in told
    assert "'their_quad' is added by other_lab 1.0 and by their_lab 1.0" in told
    with pytest.raises(ConfigError, match=r"'their_quad' is added by other_lab 1.0 and by their_lab 1.0"):
        skylimb.load_robot("their_quad")
