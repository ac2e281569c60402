"""A package that only an extra installs: without it one line says how to get it, and nothing is written."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
CAMPAIGN, TUNE = ROOT / "examples" / "campaign.toml", ROOT / "examples" / "tune.toml"


def without(package: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """The command line where that package cannot be imported."""
    code = f"import sys; sys.modules['{package}'] = None; from skylimb.apps.cli import main; sys.exit(main())"
    command = [sys.executable, "-c", code, *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)


@pytest.mark.parametrize(
    ("package", "extra", "arguments"),
    [
        ("pyarrow", "campaign", ("campaign", str(CAMPAIGN))),
        ("cma", "tune", ("tune", str(TUNE))),
        ("websockets", "studio", ("studio",)),
        ("distributed", "cluster", ("campaign", str(CAMPAIGN), "--scheduler", "tcp://127.0.0.1:1")),
    ],
)
def test_a_missing_extra_is_named(
    package: str, extra: str, arguments: tuple[str, ...], tmp_path: Path
) -> None:
    out = tmp_path / "out"
    said = without(package, *arguments, "--out", str(out))
    assert said.returncode == 2
    assert said.stderr == (f"skylimb: error: '{package}' is not installed: pip install 'skylimb[{extra}]'\n")
    assert not out.exists()


@pytest.mark.slow
def test_a_run_without_the_encoder_goes_on_without_video(tmp_path: Path) -> None:
    short = [f"phases.{phase}=0.1" for phase in ("hover", "tare", "settle", "hover_end")]
    said = without("av", "run", "free_flight", "--video", "--set", *short, "--out", str(tmp_path / "out"))
    assert said.returncode == 1, said.stderr  # it was asked for, and is named
    assert "'av' is not installed: pip install 'skylimb[video]'" in said.stdout + said.stderr
    assert (tmp_path / "out" / "report.html").is_file()
