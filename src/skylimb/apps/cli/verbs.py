"""Every verb by its name. A verb of two words stands beside the one that its first word names."""

from __future__ import annotations

from typing import Annotated, Literal

from skylimb.apps.cli.arguments import Verb, arg
from skylimb.apps.cli.calibrating import calibrate
from skylimb.apps.cli.campaigns import campaign, campaign_report, tune
from skylimb.apps.cli.converting import convert, salvage
from skylimb.apps.cli.ensembles import faults, reproduce
from skylimb.apps.cli.examples import examples
from skylimb.apps.cli.exporting import export_c
from skylimb.apps.cli.flying import compare, draw, run
from skylimb.apps.cli.keys import keys
from skylimb.apps.cli.looking import list_all, report, score, show, verify_contact, verify_rotors, view
from skylimb.apps.cli.new import new
from skylimb.apps.cli.planning import plan
from skylimb.apps.cli.realtime import fly
from skylimb.apps.cli.replaying import replay
from skylimb.apps.cli.robots import check_robot, import_robot, new_robot
from skylimb.apps.cli.ros import ros, ros2
from skylimb.apps.cli.runs import runs
from skylimb.apps.cli.studio import studio
from skylimb.apps.cli.wrench import robot_wrench


def completion(shell: Annotated[Literal["bash", "zsh", "fish"], arg("Which shell.")]) -> None:
    """Print what a shell needs to complete verbs, options, names and keys.

    Examples:
        skylimb completion bash > ~/.local/share/bash-completion/completions/skylimb
        skylimb completion zsh > ~/.zfunc/_skylimb
        skylimb completion fish > ~/.config/fish/completions/skylimb.fish
    """
    from skylimb.apps.cli.completion import script

    print(script(shell, VERBS), end="")


VERBS: dict[str, Verb] = {
    "run": run,
    "compare": compare,
    "draw": draw,
    "calibrate": calibrate,
    "studio": studio,
    "list": list_all,
    "show": show,
    "score": score,
    "report": report,
    "runs": runs,
    "view": view,
    "verify-contact": verify_contact,
    "verify-rotors": verify_rotors,
    "fly": fly,
    "ros": ros,
    "ros2": ros2,
    "replay": replay,
    "convert": convert,
    "salvage": salvage,
    "export-c": export_c,
    "keys": keys,
    "completion": completion,
    "examples": examples,
    "new": new,
    "robot check": check_robot,
    "robot import": import_robot,
    "robot new": new_robot,
    "plan": plan,
    "robot wrench": robot_wrench,
    "campaign": campaign,
    "campaign report": campaign_report,
    "tune": tune,
    "reproduce": reproduce,
    "faults": faults,
}
