"""Completion of the command line: bash really completes, the others have every verb and option."""

import shutil
import subprocess
from pathlib import Path

import pytest

from skylimb.apps.cli.arguments import flags
from skylimb.apps.cli.completion import script as script_of
from skylimb.apps.cli.main import main
from skylimb.apps.cli.verbs import VERBS


@pytest.fixture(scope="module")
def script(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("bash") / "skylimb"
    path.write_text(script_of("bash", VERBS), encoding="utf-8")
    return path


@pytest.mark.skipif(shutil.which("bash") is None, reason="no bash here")
@pytest.mark.parametrize(
    ("typed", "wanted", "unwanted"),
    [
        ("ver", {"verify-contact"}, {"run"}),
        ("run pa", {"paper"}, {"pid"}),
        ("run --con", {"--controller"}, {"--controllers"}),
        ("run --controller hy", {"hybrid"}, {"paper"}),
        ("run --set surface.fr", {"surface.friction="}, {"surface.slope="}),
        ("run --set surface.friction=0.2 controller.shape.st", {"controller.shape.stiffness="}, {"draws="}),
        ("run --set draw", set(), {"draws="}),
        ("completion f", {"fish"}, {"bash"}),
        ("keys fric", {"friction"}, {"slope"}),
        ("show surface.cyl", {"surface.cylinder"}, {"surface.board"}),
    ],
)
def test_bash_completes(script: Path, typed: str, wanted: set, unwanted: set, tmp_path: Path) -> None:
    words = ["skylimb", *typed.split(" ")]
    array = " ".join(f"'{word}'" for word in words)
    code = (
        f"source '{script}'; COMP_WORDS=({array}); COMP_CWORD={len(words) - 1}; _skylimb; "
        "printf '%s\\n' \"${COMPREPLY[@]}\""
    )
    ran = subprocess.run(
        ["bash", "--norc", "-c", code], capture_output=True, text=True, check=True, cwd=tmp_path
    )
    found = set(ran.stdout.split())
    assert wanted <= found
    assert not unwanted & found


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_every_verb_and_option_is_there(shell, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["completion", shell]) == 0
    text = capsys.readouterr().out
    for name, kind in VERBS.items():
        if " " not in name:
            assert name in text
            for option in flags(kind):
                assert (f"-l {option.removeprefix('--')}" if shell == "fish" else option) in text
