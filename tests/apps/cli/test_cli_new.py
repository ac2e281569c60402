"""What `skylimb new` writes flies as it is, and what it refuses leaves nothing behind."""

import runpy
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from skylimb.apps.cli.main import main
from skylimb.studies.campaign.fly_campaign import require_flyable
from skylimb.studies.campaign.frozen import freeze
from skylimb.studies.campaign.reading import load_spec

KINDS = (
    "law",
    "controller",
    "metric",
    "experiment",
    "surface",
    "environment",
    pytest.param("robot", marks=pytest.mark.slow),
)


@pytest.mark.parametrize("kind", KINDS)
def test_it_flies_as_it_is(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    sys.modules.pop("my_own", None)  # of the kind before
    assert main(["new", kind, "my_own"]) == 0
    told = capsys.readouterr().out
    for path in tmp_path.iterdir():
        assert path.name.removesuffix(".png").removesuffix("my_own") == "" or f"  {path.name}\n" in told
    for path in tmp_path.glob("*.*"):
        if path.suffix != ".png":
            text = path.read_text(encoding="utf-8")
            assert not {"spring.py", "saddle.py", "hardest", "upright", "quad_arm"} & set(text.split('"')), (
                path
            )
    monkeypatch.syspath_prepend(tmp_path)
    runpy.run_path("test_my_own.py")["test_my_own_flies"]()
    campaign = freeze(load_spec("my_own_campaign.toml"))
    assert "surface.friction" in campaign.spec.vary
    require_flyable(campaign)
    assert main(["new", kind, "my_own"]) == 2
    assert "exists already" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "error"),
    [
        (["law", "1st"], "NAME = '1st' is no name"),
        (["law", "class"], "NAME = 'class' is no name"),
        (["law", "../out"], "NAME = '../out' is no name"),
        (["law", "numpy"], "'numpy' is a module of Python's"),
        (["law", "pid"], "law 'pid' is there already"),
        (["controller", "hybrid"], "controller 'hybrid' is there already"),
        (["metric", "contact_fraction"], "metric 'contact_fraction' is there already"),
        (["experiment", "paper"], "experiment 'paper' is there already"),
        (["surface", "board"], "surface 'board' is there already"),
        (["robot", "dragon"], "robot 'dragon' is there already"),
        (["lwa", "mine"], "did you mean 'law'?"),
        (["law"], "NAME is missing"),
    ],
)
def test_what_nothing_can_be_called_is_refused(
    words: list[str],
    error: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["new", *words]) == 2
    said = capsys.readouterr().err
    assert error in said
    assert said.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_one_file_in_the_way_and_none_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "test_mine.py").touch()
    assert main(["new", "law", "mine"]) == 2
    assert [path.name for path in tmp_path.iterdir()] == ["test_mine.py"]


def test_who_reads_what_is_said_may_go_away(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """`skylimb new robot mine | head -1`: all files are there, whatever is read of what is said."""

    def robot(file: str, out: str, yes: bool) -> int:
        print("what is recognised", file, yes)
        Path(out).mkdir()
        return 0

    def gone(text: str) -> int:
        raise BrokenPipeError

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("skylimb.apps.cli.new.new_robot", robot)
    monkeypatch.setattr(sys.modules[main.__module__], "give_up", lambda stream: None)
    monkeypatch.setattr("sys.stdout", SimpleNamespace(write=gone, flush=lambda: None))
    assert main(["new", "robot", "mine"]) == 0
    names = ["mine", "mine.toml", "mine.urdf", "mine_campaign.toml", "test_mine.py"]
    assert sorted(path.name for path in tmp_path.iterdir()) == names
