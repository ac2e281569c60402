import hashlib
import json
import os
import resource
import signal
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from types import FrameType
from typing import Any

import pytest
import tomli_w

from skylimb.robots.loader import load_robot
from skylimb.studies.campaign.frozen import Campaign, campaign_from_mapping
from skylimb.studies.campaign.rows import FAILED, OK, make_row
from skylimb.studies.campaign.worker import Flown, Job

SHORTEST = """
"approach.contact" = false
"phases.hover" = 0.1
"phases.tare" = 0.2
"phases.settle" = 0.0
"phases.hover_end" = 0.1
"trajectory.shape" = "hold"
"trajectory.duration" = 0.4
"""
"""A free flight of 0.8 s."""

SpecWriter = Callable[..., Path]


def _write(
    folder: Path,
    draws: int = 4,
    controllers: str = '["pid", "hybrid"]',
    vary: str = '"plant.thrust_scale" = { uniform = [0.9, 1.1] }',
    head: str = "",
    more: str = "",
    name: str = "spec.toml",
) -> Path:
    path = folder / name
    path.write_text(
        f'experiment = "paper"\ncontrollers = {controllers}\ndraws = {draws}\nseed = 7\n{head}\n'
        f"[set]\n{SHORTEST}\n[vary]\n{vary}\n{more}\n"
    )
    return path


@pytest.fixture(scope="session")
def write_spec_to() -> SpecWriter:
    """Writes a spec of tiny flights into a folder: its head, what varies, and more tables."""
    return _write


@pytest.fixture
def write_spec(tmp_path: Path) -> SpecWriter:
    """The same into this test's own folder."""
    return partial(_write, tmp_path)


@pytest.fixture
def write_calibration() -> Callable[[Path], Path]:
    """Writes a calibration.toml of the robot that ships."""

    def write(path: Path) -> Path:
        description = load_robot("hydrus_xi_quad").description
        tables = {
            "format": "skylimb calibration",
            "robot": description.name,
            "robot_digest": description.digest,
            "attitude_misalignment": {"value": [0.01, 0.0, 0.02]},
            "cog_offset": {"value": [0.01, -0.005, 0.01]},
            "rotor_scale": {"value": [0.98, 1.0, 1.02, 1.0]},
            "rotor_lag": {"value": 0.06},
            "latency": {"value": 0.03},
        }
        path.write_text(tomli_w.dumps(tables), "utf-8")
        return path

    return write


def no_flight(text: str, jobs: Sequence[Job]) -> list[Flown]:
    """What `fly_jobs` hands back, made of the job's digest in place of a flight."""
    campaign = campaign_from_mapping(json.loads(text), "the campaign")
    flown = []
    for job in jobs:
        digest = hashlib.sha256(repr(job.key).encode()).digest()
        scores = {key: digest[i % 32] / 7.0 for i, key in enumerate(campaign.spec.keys)}
        lost = digest[0] < 64
        row = make_row(campaign, job.flight, FAILED if lost else OK, "lost" * lost, {} if lost else scores)
        wanted = job.log == "always" or (job.log == "failed" and lost)
        flown.append(Flown(row, digest * 40 if wanted else None))
    return flown


@pytest.fixture
def plain_report(monkeypatch: pytest.MonkeyPatch) -> None:
    """The report takes no time: it names the flights and the logs."""

    def report(
        campaign: Campaign, rows: Mapping[int, Any], summary: Any, kept: set[int], folder: Path
    ) -> str:
        return f"{len(rows)} flights, logs of {sorted(kept)}\n"

    monkeypatch.setattr("skylimb.studies.campaign.report.render_report", report)


@pytest.fixture
def instant_flights(monkeypatch: pytest.MonkeyPatch, plain_report: None) -> None:
    """Flights in this process take no time, nor does the report."""
    monkeypatch.setattr("skylimb.studies.campaign.engines.fly_jobs", no_flight)
    monkeypatch.setattr("skylimb.studies.campaign.fly_campaign.require_flyable", lambda campaign: None)


class Calls:
    """Counts calls and returns, of Python's functions and C's; kills the process at the one with a number."""

    def __init__(self, last: int = 0) -> None:
        self.count, self._last = 0, last

    def __call__(self, frame: FrameType, event: str, argument: Any) -> None:
        self.count += 1
        if self.count == self._last:
            os.kill(os.getpid(), signal.SIGKILL)

    def __enter__(self) -> "Calls":
        sys.setprofile(self)
        return self

    def __exit__(self, *error: object) -> None:
        sys.setprofile(None)


@pytest.fixture
def counted() -> Callable[..., Calls]:
    """A block in which calls are counted."""
    return Calls


def _in_child(work: Callable[[], Any], calls: int = 0, seconds: float = 0.0, most_bytes: int = 0) -> int:
    pid = os.fork()
    if pid == 0:
        code = 1
        try:
            signal.signal(signal.SIGALRM, signal.SIG_DFL)
            if most_bytes:
                resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, most_bytes))
            if seconds:
                signal.setitimer(signal.ITIMER_REAL, seconds)
            with Calls(calls) if calls else nullcontext():  # counting takes most of the time
                work()
            code = 0
        finally:
            os._exit(code)
    return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])


@pytest.fixture
def in_child() -> Callable[..., int]:
    """Runs a function in a copy of this process and gives its exit code, 1 where the function raised.

    The copy dies at a number of calls, or after `seconds`, wherever it is: like SIGKILL, the alarm runs no
    line of Python. It can write no file longer than `most_bytes`.
    """
    return _in_child


def _contents(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


@pytest.fixture
def contents() -> Callable[[Path], dict[str, bytes]]:
    """Every file below a folder."""
    return _contents
