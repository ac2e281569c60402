"""Doors that are killed in flight: what was flown is on the disk, and can be read and replayed."""

from __future__ import annotations

import subprocess
import sys
import time
import warnings
from pathlib import Path

import numpy as np
import pytest

import skylimb
from skylimb.analysis.exchange.convert import read_log
from skylimb.analysis.recording import Run
from skylimb.analysis.report.controller_replay import differences
from skylimb.apps.cli.main import main
from skylimb.flight.recorded_ticks import CUT_OFF

pytestmark = pytest.mark.slow

ENOUGH, PATIENCE = 200_000, 120.0
"""Bytes on the disk after which a process is killed, and how long they are waited for, s."""


def killed(words: list[str], out: Path, pattern: str) -> list[Path]:
    """Kill a verb as soon as it has written enough to the files of a pattern; what is kept of it."""
    verb = subprocess.Popen(
        [sys.executable, "-m", "skylimb", *words], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    end = time.monotonic() + PATIENCE
    while sum(path.stat().st_size for path in out.rglob(pattern)) < ENOUGH:
        assert verb.poll() is None
        assert time.monotonic() < end
        time.sleep(0.05)
    verb.kill()
    verb.wait()
    assert not list(out.glob("*-interrupted"))
    assert main(["runs", str(out), "--clean"]) in (None, 0)
    return sorted(out.rglob("*-interrupted/**/*.mcap"))


def checked(path: Path) -> Run:
    """The run of a file that was cut off: one row a tick, from take-off on."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # that it was cut off, or by chance was not
        run = read_log(path).run
    assert run.cause == CUT_OFF
    ticks = run.log.sizes["time"]
    assert ticks > 40
    assert np.isfinite(run.log.thrusts_command).all()
    np.testing.assert_allclose(run.log.time, 0.005 * np.arange(ticks), atol=1e-9)
    return run


def test_a_flight_on_the_clock_that_is_killed(tmp_path: Path) -> None:
    words = ["fly", "free_flight", "--realtime", "--controller", "hybrid", "--out", str(tmp_path / "flown")]
    (found,) = killed(words, tmp_path, "*.mcap")
    assert skylimb.replay(checked(found)).log.sizes["time"] > 40


def test_a_studio_that_is_killed(tmp_path: Path) -> None:
    words = ["studio", "free_flight", "--no-browser", "--controller", "hybrid", "pid", "--out", str(tmp_path)]
    found = killed(words, tmp_path, "2/*.mcap")
    runs = [checked(path) for path in found]
    assert [run.controller for run in runs] == ["hybrid", "pid"]
    for run in runs:
        assert [one for one in differences(run, skylimb.replay(run)) if not one.same] == []


def test_a_killed_flight_with_zeros_behind_it_is_salvaged(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A loss of power leaves the length of a file, and zeros for what was not yet on the disk."""
    words = ["fly", "free_flight", "--realtime", "--controller", "hybrid", "--out", str(tmp_path / "flown")]
    (found,) = killed(words, tmp_path, "*.mcap")
    content = found.read_bytes()
    found.write_bytes(content[: len(content) - 3000] + bytes(8192))
    run, anew = checked(found), tmp_path / "anew.mcap"
    assert main(["salvage", str(found), str(anew)]) in (None, 0)
    assert "was cut off: what was recorded up to" in capsys.readouterr().err
    np.testing.assert_array_equal(read_log(anew).run.log.thrusts_command, run.log.thrusts_command)
