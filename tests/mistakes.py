"""Mistakes that a newcomer makes, and what skylimb says to them.

    python tests/mistakes.py        writes docs/mistakes.md anew

Each is one line on the error stream, exit code 2, and nothing written. `test_mistakes` holds the page to it.
"""

from __future__ import annotations

import contextlib
import io
import os
import shlex
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path

from skylimb.apps.cli import main

PAGE = Path(__file__).parents[1] / "docs" / "mistakes.md"


FILES: Mapping[str, str] = {
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


def answer(command: str) -> tuple[int, str]:
    """Exit code of a command, and what it says on the error stream."""
    errors = io.StringIO()
    with contextlib.redirect_stderr(errors), contextlib.redirect_stdout(io.StringIO()):
        code = main(shlex.split(command))
    return code, errors.getvalue()


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
    with folder_of_files():
        for command in COMMANDS:
            said = answer(command)[1].removeprefix("skylimb: error: ").strip()
            lines.append(f"| `{command}` | {_cell(said)} |")
    return "\n".join(lines) + "\n"


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("<", "&lt;").replace("*", "\\*")


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
