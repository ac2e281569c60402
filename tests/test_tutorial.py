"""What a new user does, step by step, in a folder of its own, with the wheel and not the repository.

The time of every step is printed. It stands for the tutorial's promise: each of these is one short command.
"""

from __future__ import annotations

import os
import shutil
import site
import subprocess
import sys
import time
import venv
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PATIENCE = 200.0

SHORT = (
    "trajectory.period=4", "phases.hover=0.5", "phases.tare=1.5", "phases.settle=1", "phases.hover_end=0.5",
)  # fmt: skip
"""A flight of some 13 s in place of 37 s."""

MINE = """description = "A slippery board"

[surface]
position = [1.5, 0.0, 1.2]
slope = 0.2
friction = 0.15

[trajectory]
radius = 0.2
period = 4.0

[phases]
hover = 0.5
tare = 1.5
settle = 1.0
hover_end = 0.5
"""

GAINS = """file = "my_controller.py"
velocity = [3.0, 3.0, 3.5]
"""

METRIC = """import skylimb


@skylimb.metric(unit="N", smaller_is_better=True)
def hardest(run):
    \"\"\"Largest normal force.\"\"\"
    return float(run.log.contact_force_normal.max())
"""

CAMPAIGN = """experiment = "mine.toml"
controllers = ["pid", "hybrid"]
draws = 3
use = ["my_metric.py"]
score = "hardest"
logs = "none"

[vary]
"surface.friction" = { uniform = [0.1, 0.8] }
"""

TUNE = """experiment = "mine.toml"
controllers = ["my_controller.py"]
draws = 2

[vary]
"surface.friction" = { uniform = [0.1, 0.8] }

[tune]
objective = "error_v_median"
trials = 4
held_out = 2

[tune.gains]
"velocity.2" = [1.0, 6.0]
"""

SWEEP = """import skylimb

if __name__ == "__main__":
    scores = skylimb.sweep("mine.toml", over={"surface.friction": [0.1, 0.4]}, seeds=2)
    print(dict(scores.sizes), float(scores.contact_fraction.mean()))
"""

PYTHON = """import skylimb

run = skylimb.run("mine.toml", controller="hybrid", seed=3)
print(run.status, round(float(run.log.contact_force_normal.max()), 2), run.metrics["error_u_median"])
run.plot("contact_force_normal").savefig("force.png")
"""


@dataclass
class User:
    """A folder, an installed skylimb, and what was done with them."""

    folder: Path
    bin: Path
    times: list[tuple[str, float]] = field(default_factory=list)

    def does(self, what: str, *command: str | Path, code: int = 0) -> str:
        """Run a command in the folder; return what it printed."""
        begin = time.perf_counter()
        name, *rest = map(str, command)
        program = self.bin / name
        environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
        ran = subprocess.run(
            [program, *rest], cwd=self.folder, env=environment, capture_output=True, text=True,
            timeout=PATIENCE, check=False,
        )  # fmt: skip
        self.times.append((what, time.perf_counter() - begin))
        assert ran.returncode == code, f"{what}: {ran.stdout}\n{ran.stderr}"
        return ran.stdout

    def writes(self, name: str, text: str) -> None:
        """A file of the user's."""
        (self.folder / name).write_text(text, encoding="utf-8")


@pytest.fixture(scope="module")
def user(tmp_path_factory: pytest.TempPathFactory) -> Iterator[User]:
    """Somebody who has installed the wheel into an environment; its dependencies are those of this one."""
    place = tmp_path_factory.mktemp("user")
    begin = time.perf_counter()
    copy = place / "source"
    kept = shutil.ignore_patterns(".*", "out", "build", "*.egg-info", "__pycache__", "tests", "site")
    shutil.copytree(ROOT, copy, ignore=kept)
    wheel = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation"]
    subprocess.run([*wheel, "--wheel-dir", place, copy], check=True, capture_output=True)
    environment = place / "environment"
    venv.create(environment, symlinks=True, with_pip=False)
    (packages,) = environment.glob("lib/python*/site-packages")
    (packages / "others.pth").write_text("\n".join(site.getsitepackages()), encoding="utf-8")
    (built,) = place.glob("*.whl")
    install = [sys.executable, "-m", "pip", "--python", environment / "bin" / "python", "install"]
    subprocess.run([*install, "--quiet", "--no-deps", built], check=True, capture_output=True)
    folder = place / "work"
    folder.mkdir()
    someone = User(folder, environment / "bin")
    someone.times.append(("build and install the wheel", time.perf_counter() - begin))
    yield someone
    print("\n".join(f"{seconds:6.1f} s  {what}" for what, seconds in someone.times))


def the_installed_package_is_the_wheel(user: User) -> None:
    where = user.does("where it is", "python", "-c", "import skylimb; print(skylimb.__file__)")
    assert str(user.bin.parent) in where


def looking_around(user: User) -> None:
    assert "usage: skylimb VERB" in user.does("skylimb --help", "skylimb", "--help")
    assert "hybrid" in user.does("skylimb list", "skylimb", "list")
    assert "surface.friction" in user.does("skylimb keys friction", "skylimb", "keys", "friction")
    assert "friction = 0.4" in user.does("skylimb show paper", "skylimb", "show", "paper")
    user.does("skylimb examples", "skylimb", "examples", "examples")
    assert (user.folder / "examples" / "user_controller.py").is_file()


def the_first_flight(user: User) -> None:
    user.does("first flight", "skylimb", "run", "paper", "--out", "first", "--set", *SHORT)
    assert {"report.html", "log.nc", "metrics.json", "config.toml"} <= {
        path.name for path in (user.folder / "first").iterdir()
    }


def an_experiment_of_ones_own(user: User) -> None:
    user.writes("mine.toml", MINE)
    said = user.does("own experiment", "skylimb", "compare", "mine.toml", "--controllers", "pid", "hybrid")
    assert "hybrid" in said
    assert "0.15" in user.does("show it", "skylimb", "show", "mine.toml")


def a_controller_of_ones_own(user: User) -> None:
    shutil.copy(user.folder / "examples" / "user_controller.py", user.folder / "my_controller.py")
    user.writes("my_gains.toml", GAINS)
    user.does(
        "own controller", "skylimb", "run", "mine.toml", "--controller", "my_controller.py", "--out", "own",
        "--set", "controller.velocity=[2.6, 2.6, 3.0]",
    )  # fmt: skip
    user.does("own gains", "skylimb", "run", "mine.toml", "--controller", "my_gains.toml", "--out", "gains")
    assert "velocity" in user.does("show the gains", "skylimb", "show", "my_gains.toml")


def a_run_moves_and_repeats_to_the_bit(user: User) -> None:
    (user.folder / "my_controller.py").write_text("broken since\n", encoding="utf-8")
    moved = user.folder / "elsewhere" / "own"
    moved.parent.mkdir()
    shutil.move(user.folder / "own", moved)
    user.does("repeat a moved run", "skylimb", "run", "elsewhere/own/config.toml", "--out", "again")
    code = (
        "import skylimb\n"
        "a, b = (next(iter(skylimb.load_runs(name).values())) for name in ('elsewhere/own', 'again'))\n"
        "print(a.log.configuration.equals(b.log.configuration), a.metrics == b.metrics)"
    )
    assert user.does("compare the bits", "python", "-c", code).split() == ["True", "True"]
    shutil.copy(user.folder / "examples" / "user_controller.py", user.folder / "my_controller.py")


def a_law_of_ones_own(user: User) -> None:
    user.does(
        "own law", "skylimb", "run", "mine.toml", "--controller", "examples/laws/extended_state.toml",
        "--out", "law",
    )  # fmt: skip


def a_metric_and_a_path_of_ones_own(user: User) -> None:
    user.writes("my_metric.py", METRIC)
    said = user.does("own metric", "skylimb", "run", "mine.toml", "--use", "my_metric.py", "--out", "metric")
    assert "hardest" in said or "Largest normal force" in said
    user.does(
        "own path", "skylimb", "run", "paper", "--out", "path", "--set",
        "trajectory.shape=examples/user_path.py:heart", "trajectory.duration=30",
    )  # fmt: skip


def python_and_a_sweep(user: User) -> None:
    user.writes("flight.py", PYTHON)
    assert user.does("from Python", "python", "flight.py").startswith("OK")
    assert (user.folder / "force.png").is_file()
    user.writes("sweep.py", SWEEP)
    said = user.does("sweep of four flights", "python", "sweep.py")
    assert "'surface.friction': 2" in said
    assert "'seed': 2" in said


def a_campaign_and_a_search(user: User) -> None:
    user.writes("campaign.toml", CAMPAIGN)
    user.does("campaign of six flights", "skylimb", "campaign", "campaign.toml", "--out", "campaign")
    assert (user.folder / "campaign" / "report.html").is_file()
    user.writes("tune.toml", TUNE)
    user.does("search of four trials", "skylimb", "tune", "tune.toml", "--out", "tuned")
    user.does(
        "fly what was found", "skylimb", "run", "mine.toml", "--controller", "tuned/my_controller.toml",
        "--out", "best",
    )  # fmt: skip


def a_drawing_and_the_c_code(user: User) -> None:
    user.does(
        "draw a word", "skylimb", "draw", "--text", "hi", "--width", "0.2", "--speed", "0.1", "--out", "word"
    )
    user.does("export to C", "skylimb", "export-c", "c_code")


@pytest.mark.slow
def test_what_a_new_user_does(user: User) -> None:
    """One test, as each step needs the files of those before it."""
    the_installed_package_is_the_wheel(user)
    looking_around(user)
    the_first_flight(user)
    an_experiment_of_ones_own(user)
    a_controller_of_ones_own(user)
    a_run_moves_and_repeats_to_the_bit(user)
    a_law_of_ones_own(user)
    a_metric_and_a_path_of_ones_own(user)
    python_and_a_sweep(user)
    a_campaign_and_a_search(user)
    a_drawing_and_the_c_code(user)
