"""A package that only an extra installs: without it one line says how to get it, and nothing is written."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from skylimb.base.errors import EXTRAS

ROOT = Path(__file__).parents[1]
CAMPAIGN, TUNE = ROOT / "examples" / "campaign.toml", ROOT / "examples" / "tune.toml"


CASES = {
    "pyarrow": ("campaign", ("campaign", str(CAMPAIGN))),
    "cma": ("tune", ("tune", str(TUNE))),
    "websockets": ("studio", ("studio",)),
    "distributed": ("cluster", ("campaign", str(CAMPAIGN), "--scheduler", "tcp://127.0.0.1:1")),
}
"""Package that cannot be imported -> its extra, and a command that needs it."""

EACH = """
import json, os, sys
from skylimb.apps.cli import main
for package, words in json.load(sys.stdin).items():
    print(f"{package}:", file=sys.stderr, flush=True)
    if os.fork() == 0:
        sys.modules[package] = None
        code = main(words)
        print(f"exit code {code}", file=sys.stderr, flush=True)
        os._exit(0)
    os.wait()
"""
"""One process begins, and each command runs in a copy of it."""


def without(package: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """The command line where that package cannot be imported."""
    code = f"import sys; sys.modules['{package}'] = None; from skylimb.apps.cli import main; sys.exit(main())"
    command = [sys.executable, "-c", code, *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)


def test_a_missing_extra_is_named(tmp_path: Path) -> None:
    commands = {package: [*words, "--out", str(tmp_path / package)] for package, (_, words) in CASES.items()}
    command = [sys.executable, "-c", EACH]
    done = subprocess.run(
        command, input=json.dumps(commands), capture_output=True, text=True, timeout=120, check=True
    )
    error = "skylimb: error: '{}' is not installed: pip install 'skylimb[{}]'\nexit code 2\n"
    told = [f"{package}:\n{error.format(package, extra)}" for package, (extra, _) in CASES.items()]
    assert done.stderr == "".join(told)
    assert not list(tmp_path.iterdir())


def test_every_command_of_the_gallery_runs_after_make_demo() -> None:
    makefile, gallery = (ROOT / name for name in ("Makefile", "docs/gallery.md"))
    found = re.search(r"run\.stamp:.*?--editable '\.\[([\w,]+)\]'", makefile.read_text("utf-8"), re.DOTALL)
    verbs = re.findall(r"^skylimb (\w+)", gallery.read_text("utf-8"), re.MULTILINE)
    needed = {"report", *EXTRAS.keys() & set(verbs)}  # a verb's extra has its name
    assert needed >= {"draw", "studio", "campaign"}
    assert found
    assert needed <= set(found[1].split(","))


@pytest.mark.slow
def test_a_run_without_the_encoder_goes_on_without_video(tmp_path: Path) -> None:
    short = [f"phases.{phase}=0.1" for phase in ("hover", "tare", "settle", "hover_end")]
    said = without("av", "run", "free_flight", "--video", "--set", *short, "--out", str(tmp_path / "out"))
    assert said.returncode == 1, said.stderr  # it was asked for, and is named
    assert "'av' is not installed: pip install 'skylimb[video]'" in said.stdout + said.stderr
    assert (tmp_path / "out" / "report.html").is_file()
