"""Mistakes that a newcomer makes, and what skylimb says to them.

    python tests/mistakes.py        writes docs/reports/mistakes.md anew

Each is one line on the error stream, exit code 2, and nothing written. `test_mistakes` holds the page to it.
"""

from __future__ import annotations

import contextlib
import functools
import io
import os
import shlex
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

from skylimb.apps.cli import main

PAGE = Path(__file__).parents[1] / "docs" / "reports" / "mistakes.md"


_HEAD = """import math
import numpy as np
class Gains: ...
def initial_state(gains, start): return np.zeros(3)
"""
_PRESET = """[translation]
law = "law.py"
[attitude]
law = "impedance"
virtual_inertia_ratio = [10.0, 10.0, 5.0]
normalized_stiffness = [40.0, 40.0, 10.0]
damping_ratio = [1.1, 1.1, 0.8]
[shape]
law = "fixed"
"""
_FORCE = "inputs.estimate.body.model.mass * inputs.estimate.body.model.gravity"


def _law(*lines: str, before: str = "") -> str:
    """A translation law whose `force` holds the robot; `lines` follow it."""
    step = ["def step(gains, state, inputs):", f"force = {_FORCE}", *lines]
    return _HEAD.replace(
        "class", f"from dataclasses import dataclass\n{before}@dataclass(frozen=True)\nclass"
    ) + ("\n    ".join(step) + "\n")


def _controller(last: str) -> str:
    """A controller whose step ends with this line."""
    return f"""import numpy as np
import skylimb
class C:
    name = "c"
    def gains(self): return None
    def initial_state(self): return 0.0
    def step(self, gains, state, measurement, reference, dt):
        angles = measurement.joint_angles, measurement.vectoring_angles
        {last}
def controller(robot): return C()
"""


LAWS: Mapping[str, str] = {
    "only_force.py": _law("return force"),
    "two_things.py": _law("return state, force"),
    "nothing_back.py": _law("force + state"),
    "short_force.py": _law("return state, force[0:2], {}"),
    "text_force.py": _law('return state, "up", {}'),
    "other_state.py": _law("return state[0:2], force, {}"),
    "lost_state.py": _law("return None, force, {}"),
    "nan_force.py": _law("return state, force / 0.0, {}"),
    "list_signals.py": _law("return state, force, [force]"),
    "text_signal.py": _law('return state, force, {"mode": "soft"}'),
    "misspelt_signal.py": _law(
        'return state, force, {"pul": force}',
        before='from skylimb import Signal\nSIGNALS = {"pull": Signal("N", "W", "of the spring")}\n',
    ),
    "unknown_field.py": _law("return state, force + inputs.estimate.body.speed, {}"),
    "not_given.py": _law("return state, force + inputs.contact.tip.position, {}"),
    "whole_state.py": _law("return state + 1, force, {}").replace("np.zeros(3)", "0"),
    "remembers.py": _law("COUNT.append(1)", "return state, force * len(COUNT), {}", before="COUNT = []\n"),
    "at_random.py": _law("return state, force * np.random.rand(), {}"),
    "unpacks.py": _law("x, y = force", "return state, force, {}"),
    "few_arguments.py": _law("return state, force, {}").replace("state, inputs)", "state)"),
    "prepare_fails.py": _law("return state, force, {}").replace("inputs)", "inputs, K)")
    + "def prepare(gains, robot):\n    return np.linalg.inv(np.zeros((2, 2)))\n",
    "prepare_gives_nothing.py": _law("return state, force, {}").replace("inputs)", "inputs, K)")
    + "def prepare(gains, robot):\n    np.eye(2)\n",
    "writes_inputs.py": _law("inputs.estimate.body.position[2] = 0.0", "return state, force, {}"),
    "complex_force.py": _law("return state, force * 1j, {}"),
    "signal_of_the_loop.py": _law('return state, force, {"contact_force": force}'),
    "signal_of_another.py": _law('return state, force, {"torque_command": force}'),
    "needs_table.py": _law("return state, force, {}") + 'def needs(gains):\n    return {"paced": True}\n',
    "requires_text.py": 'REQUIRES = "estimate.body"\n' + _law("return state, force, {}"),
    "leaves.py": "import sys\n" + _law("sys.exit(3)"),
    "no_gains.py": "def initial_state(gains, start): return ()\ndef step(*given): return given\n",
}
"""Laws in the translation slot, each with one mistake."""

FILES: Mapping[str, str] = {
    **LAWS,
    "law.py": _law("return state, force, {}"),
    "own.toml": _PRESET,
    "path_short.py": "def path(s, keys):\n    return s\n",
    "slope.py": "def height(u, v):\n    return 0.0 * u\n",
    "slope_math.py": "import math\ndef height(u, v, keys):\n    return math.sin(u)\n",
    "three_rotors.py": _controller("return state, skylimb.Command(np.ones(3), *angles), {}"),
    "not_finite.py": _controller("return state, skylimb.Command(np.ones(4) / 0.0, *angles), {}"),
    "text_signals.py": _controller('return state, skylimb.Command(np.ones(4), *angles), {"mode": "up"}'),
    "only_command.py": _controller("return skylimb.Command(np.ones(4), *angles)"),
    "empty.toml": "",
    "broken.toml": "[surface\nfriction = 0.2\n",
    "typo.toml": "[surface]\nfricton = 0.2\n",
    "words.toml": '[surface]\nfriction = "low"\n',
    "base.toml": 'base = "paper"\n',
    "preset.toml": '[translation]\nlaw = "impedence"\n',
    "spec.toml": 'experiment = "paper"\ncontrollers = ["pid", "hybird"]\ndraws = 4\n',
    "nodraws.toml": 'experiment = "paper"\ncontrollers = ["pid"]\ndraws = 0\n',
    "vary.toml": 'experiment = "paper"\ncontrollers = ["pid"]\ndraws = 4\n[vary]\n'
    '"surface.friction" = { unifrom = [0.1, 0.8] }\n',
    "backwards.toml": 'experiment = "paper"\ncontrollers = ["pid"]\ndraws = 4\n[vary]\n'
    '"surface.friction" = { uniform = [0.8, 0.1] }\n',
    "unknown_key.toml": 'experiment = "paper"\ncontrollers = ["pid"]\ndraws = 4\n[vary]\n'
    '"surface.fricton" = { uniform = [0.1, 0.8] }\n',
    "nothing.py": "x = 1\n",
    "syntax.py": "def controller(robot)\n    return None\n",
    "raises.py": "def controller(robot):\n    return robot.masss\n",
    "lacks.py": "class C:\n    name = 'c'\n\n\ndef controller(robot):\n    return C()\n",
    "picture.svg": '<svg xmlns="http://www.w3.org/2000/svg"></svg>',
    "text.svg": "a drawing\n",
    "robot.urdf": "<robot name='r'><link name='a'/></robot>",
    "notes.txt": "notes\n",
}
"""Files that stand in the folder where the commands are run."""

COMMANDS = (
    "rum",
    "--controllers pid",
    "run papr",
    "run paper hybrid",
    "run --controller hybird",
    "run --controller missing.toml",
    "run --controller nothing.py",
    "run --controller syntax.py",
    "run --controller raises.py",
    "run --controller lacks.py",
    "run --controller preset.toml",
    "run --controller notes.txt",
    "run --seed one",
    "run --seed -1",
    "run --seed 1.5",
    "run --video no",
    "run --no-vidio",
    "run --set friction=0.2",
    "run --set surface.fricton=0.2",
    "run --set surface.friction",
    "run --set surface.friction=",
    "run --set surface.friction=-0.1",
    "run --set surface.friction=low",
    "run --set surface.friction=nan",
    "run --set surface.friction=0,2",
    "run --set surface.slope=20deg",
    "run --set surface.slope=20",
    "run --set surface.kind=plane",
    "run --set trajectory.shape=cirle",
    "run --set trajectory.radius=3",
    "run --set trajectory.speed=0",
    "run --set trajectory.direction=left",
    "run --set 'trajectory.center=[0, 0, 0]'",
    "run --set phases.settle=1e308",
    "run --set phases.tare=-1",
    "run --set control_period=1",
    "run --set plant.timestep=0.003",
    "run --set robot=hydrus",
    "run --set robot=robot.urdf",
    "run --set controller.stiffness=4",
    "run --set controller.translation.law=impedence",
    "run --controller task_frame --set controller.contact.law=open",
    "run --set controller.shape.law=recentring",
    "run --controller following --set controller.translation.feed=1",
    "run --set 'controller.translation.normalized_stiffness=[4, 4]'",
    "run --set controller.translation.normalized_stiffness=4",
    "run --set 'controller.translation.normalized_stiffness=[-4, 4, 2]'",
    "run --set sensors.latency=15",
    "run --set sensors.rate=-100",
    "run --set disturbance.force=3",
    "run push --set events.0.force=3",
    "run push --set events.1.time=3",
    "run --set approach.depth=2",
    "run --out notes.txt",
    *(f"run --controller own.toml --set controller.translation.law={name}" for name in LAWS),
    "run --controller three_rotors.py",
    "run --controller only_command.py",
    "run --controller not_finite.py",
    "run --controller text_signals.py",
    "run --set surface.kind=slope.py",
    "run --set surface.kind=slope_math.py",
    "run --set trajectory.shape=own --set trajectory.file=path_short.py --set trajectory.function=path"
    " --set trajectory.duration=5",
    "run empty.toml --set surface.friction=-1",
    "run broken.toml",
    "run typo.toml",
    "run words.toml",
    "run base.toml",
    "run missing.toml",
    "compare --controllers pid pid",
    "compare --controllers",
    "compare --controllers pid hybird",
    "draw",
    "draw missing.svg",
    "draw picture.svg",
    "draw text.svg",
    "draw --text hello --surface push",
    "draw --text hello --set trajectory.shape=circle",
    "draw --text hello --width 0.3 --set trajectory.width=0.2",
    "run own.toml",
    "run --controller spec.toml",
    "draw --text hello --font comic",
    "draw --text hello --width -1",
    "show papr",
    "show missing.toml",
    "view out/missing",
    "report out/missing",
    "campaign missing.toml",
    "campaign spec.toml",
    "campaign nodraws.toml",
    "campaign vary.toml",
    "campaign backwards.toml",
    "campaign unknown_key.toml",
    "campaign report out/missing",
    "export-c",
    "ros bot",
    "ros controller",
    "verify-contact --out notes.txt",
)


@contextlib.contextmanager
def folder_of_files() -> Iterator[Path]:
    """A folder that holds `FILES`, and is the working folder for that long."""
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file, content in FILES.items():
            (folder / file).write_text(content, encoding="utf-8")
        os.chdir(folder)
        try:
            yield folder
        finally:
            os.chdir(before)


class Answer(NamedTuple):
    """Exit code of a command, what it says on the error stream, and the files that are there then."""

    code: int
    said: str
    files: frozenset[str]


@functools.cache
def answer(command: str) -> Answer:
    """What a command comes to in a folder that holds `FILES`; each is run once."""
    errors = io.StringIO()
    with folder_of_files() as folder:
        with contextlib.redirect_stderr(errors), contextlib.redirect_stdout(io.StringIO()):
            code = main(shlex.split(command))
        return Answer(code, errors.getvalue(), frozenset(path.name for path in folder.iterdir()))


def page() -> str:
    """The page, made from what is said now."""
    lines = [
        "# Mistakes, and what is said to them",
        "",
        "A mistake is answered with one line and the exit code 2, before anything is written. This table is",
        "made by running each command (`python tests/mistakes.py`), and a test holds it to what is said.",
        "",
        "| `skylimb` ... | says |",
        "|---|---|",
    ]
    for command in COMMANDS:
        said = answer(command).said.removeprefix("skylimb: error: ").strip()
        lines.append(f"| `{command}` | {_cell(said)} |")
    return "\n".join(lines) + "\n"


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("<", "&lt;").replace("*", "\\*")


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
