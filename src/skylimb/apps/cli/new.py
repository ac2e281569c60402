"""The verb that writes something new to begin with: an example under a name of the user's own."""

from __future__ import annotations

import importlib.util
import io
import keyword
import tempfile
from collections.abc import Iterable, Mapping
from contextlib import redirect_stdout
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Literal

from skylimb.apps.cli.arguments import arg
from skylimb.apps.cli.robots import new_robot
from skylimb.base.errors import ConfigError


@dataclass(frozen=True)
class _Start:
    """What is written for one kind; {name} stands for the user's name.

    Attributes:
        copies: file to write -> the example that it is a copy of.
        words: of the examples, and what is written for each.
        run: arguments of `skylimb.run` with which it flies.
        command: the same on the command line.
        campaign: its lines in a campaign's file.
        more: a line more of the test.
        test: what it is, where it is no flight of `skylimb.run`.
        gains: what the campaign varies besides, as lines of its file.
    """

    copies: Mapping[str, str]
    run: str
    command: str
    campaign: str
    words: Mapping[str, str] = field(default_factory=dict)
    more: str = ""
    test: str = ""
    gains: str = ""


_CHECKED = '''"""Holds it to Gymnasium's rules: python -m pytest test_{name}.py"""

import {name}
from gymnasium.utils.env_checker import check_env


def test_{name}_flies() -> None:
    check_env({name}.make(duration=2.0), skip_render_check=True)
'''

_STARTS = {
    "law": _Start(
        {"{name}.py": "laws/spring.py", "{name}.toml": "laws/spring.toml"},
        '"paper", controller=str(HERE / "{name}.toml")',
        "skylimb run --controller {name}.toml",
        'experiment = "paper"\ncontrollers = ["hybrid", "{name}.toml"]',
        {"spring.py": "{name}.py", "spring_force": "{name}_force"},
    ),
    "controller": _Start(
        {"{name}.py": "user_controller.py"},
        '"paper", controller=str(HERE / "{name}.py")',
        "skylimb run --controller {name}.py",
        'experiment = "paper"\ncontrollers = ["hybrid", "{name}.py"]',
        {"examples/user_controller.py": "{name}.py", '"upright"': '"{name}"'},
    ),
    "metric": _Start(
        {"{name}.py": "metrics/hardest.py"},
        '"paper", use=[HERE / "{name}.py"]',
        "skylimb run --use {name}.py",
        'experiment = "paper"\ncontrollers = ["pid", "hybrid"]\nuse = ["{name}.py"]\nscore = "{name}"',
        {"def hardest": "def {name}"},
        '    assert run.metrics["{name}"] > 0.0\n',
    ),
    "experiment": _Start(
        {"{name}.toml": "experiments/slow_line.toml"},
        'str(HERE / "{name}.toml")',
        "skylimb run {name}.toml",
        'experiment = "{name}.toml"\ncontrollers = ["pid", "hybrid"]',
    ),
    "surface": _Start(
        {"{name}.py": "surfaces/saddle.py", "{name}.toml": "surfaces/saddle.toml"},
        'str(HERE / "{name}.toml")',
        "skylimb run {name}.toml",
        'experiment = "{name}.toml"\ncontrollers = ["following"]',
        {"saddle.py": "{name}.py"},
    ),
    "robot": _Start(
        {"{name}.urdf": "robots/quad_arm.urdf", "{name}.toml": "robots/quad_arm.toml"},
        'str(HERE / "{name}.toml")',
        "skylimb run {name}.toml",
        'experiment = "{name}.toml"\ncontrollers = ["following"]',
        {"quad_arm": "{name}"},
        gains='"controller.translation.force" = { choice = [0.7] }  # N: its yaw holds no more\n',
    ),
    "environment": _Start(
        {"{name}.py": "environments/gentle.py"},
        "",
        "python {name}.py",
        'experiment = "paper"\ncontrollers = ["following"]',
        {
            "examples/environments/gentle.py": "{name}.py",
            "def gentle": "def {name}",
            '"gentle"': '"{name}"',
            "reward_gentle": "reward_{name}",
            "; gentle is": "; {name} is",
        },
        test=_CHECKED,
    ),
}

_TEST = '''"""Flies it: python -m pytest test_{name}.py"""

from pathlib import Path

import skylimb

HERE = Path(__file__).parent


def test_{name}_flies() -> None:
    run = skylimb.run({run})
    assert run.status == "OK", run.cause
'''

_CAMPAIGN = """# skylimb campaign {name}_campaign.toml
{campaign}
draws = 4
seed = 1

[vary]
"surface.friction" = {{ uniform = [0.1, 0.4] }}
"""


def new(
    kind: Annotated[
        Literal["law", "controller", "metric", "experiment", "surface", "robot", "environment"],
        arg("What to begin."),
    ],
    name: Annotated[str, arg("What it is called: a name as Python takes it.", "NAME")],
) -> None:
    """Begin a law, a controller, a metric, an experiment, ...: its file, a test that flies it, a campaign.

    The files are written into the folder that one is in, and fly as they are. Of a robot that is a URDF to
    change, and what `skylimb robot new NAME.urdf --out NAME --yes` makes of it.

    Examples:
        skylimb new law mine
        skylimb new experiment first_task
        skylimb new robot my_robot
    """
    from skylimb.base.files import new_file, require_new

    _require_name(kind, name)
    start = _STARTS[kind]
    files = _files(start, name)
    for file in (*files, *([name, f"{name}.png"] if kind == "robot" else ())):
        require_new(file)
    said = io.StringIO()  # until all is written: who reads it may go away (`skylimb new robot mine | head`)
    if kind == "robot":
        with tempfile.TemporaryDirectory() as folder, redirect_stdout(said):  # what fails leaves no file
            urdf = Path(folder) / f"{name}.urdf"
            urdf.write_text(files[urdf.name], encoding="utf-8")
            new_robot(str(urdf), out=name, yes=True)
    for file, text in files.items():
        with new_file(file) as path:
            path.write_text(text, encoding="utf-8")
    print(said.getvalue() + "\n".join(f"  {file}" for file in files))
    print(f"Fly it: {start.command.format(name=name)}")


def _files(start: _Start, name: str) -> dict[str, str]:
    """Content of each file."""
    from skylimb.apps.cli.examples import examples_folder

    found = {}
    for file, example in start.copies.items():
        text = (examples_folder() / example).read_text("utf-8")
        for word, mine in start.words.items():
            text = text.replace(word, mine.format(name=name))
        found[file.format(name=name)] = text
    told = {"name": name, "run": start.run.format(name=name), "campaign": start.campaign.format(name=name)}
    found[f"test_{name}.py"] = (start.test or _TEST + start.more).format(**told)
    found[f"{name}_campaign.toml"] = _CAMPAIGN.format(**told) + start.gains
    return found


def _require_name(kind: str, name: str) -> None:
    """Refuse a name that nothing could be called by."""
    if not (name.isascii() and name.isidentifier()) or keyword.iskeyword(name):
        raise ConfigError(f"NAME = '{name}' is no name: letters, digits and _, and no digit first")
    if name in _taken(kind):
        raise ConfigError(f"{kind} '{name}' is there already; choose another name")
    here = Path(name).exists() or Path(f"{name}.py").exists()  # what is in the way is named as such
    if not here and importlib.util.find_spec(name):
        raise ConfigError(f"'{name}' is a module of Python's or a package's, which {name}.py would hide")


def _taken(kind: str) -> Iterable[str]:
    """Names of what ships, and of what installed packages add."""
    from skylimb.analysis.scores.user_scores import TAKEN
    from skylimb.apps.catalogue.added import shipped_names
    from skylimb.base.plugins import added_names
    from skylimb.control.laws.preset import preset_names

    # The preset of a law is called as it is.
    further: dict[str, Iterable[str]] = {"law": preset_names(), "metric": TAKEN}
    group = f"{kind}s"
    names = (one.rpartition(".")[2] for one in (*shipped_names(group), *added_names(group)))
    return {*names, *further.get(kind, ())}
