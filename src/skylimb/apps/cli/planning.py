"""The verb that finds a posture for an experiment: `plan`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar

from skylimb.apps.cli import output
from skylimb.apps.cli.arguments import arg
from skylimb.apps.cli.options import Assignments, Experiment, settings_of
from skylimb.base.errors import ConfigError

if TYPE_CHECKING:
    import numpy as np

    from skylimb.control.planning.task_posture import TaskPosture
    from skylimb.robots.held_results import NotHeld
    from skylimb.studies.planning.task_plan import TaskPlan


_MOST = 1000.0
"""Greatest force that may be given, N."""


@dataclass(frozen=True)
class Plan:
    """Find the posture that leaves the rotors the most torque all along an experiment's path.

    Joint angles, heading and vectoring angles are chosen together, for the push along the surface's normal
    and the drag of its friction, within joint limits, without links or rotors touching anything. With --apply
    the experiment is written anew, with its robot standing that way.
    """

    examples: ClassVar[str] = """
        skylimb plan paper
        skylimb plan paper --force 5 --picture posture.png
        skylimb plan paper --controller following --apply planned
        skylimb run planned/experiment.toml --controller following
    """

    experiment: Experiment = "paper"
    controller: Annotated[
        str, arg(metavar="NAME", help="What is to fly it: its force, and what its vectoring angles keep.")
    ] = "hybrid"
    force: Annotated[str, arg(metavar="N", help="Normal force; by default the controller's, else 3 N.")] = ""
    set: Assignments = ()
    picture: Annotated[str, arg(metavar="PNG", help="Draw both postures into this new file.")] = ""
    apply: Annotated[str, arg(metavar="DIR", help="New folder for the experiment and its robot.")] = ""

    def __call__(self) -> int:
        """Search, print, draw, write."""
        from skylimb.base.files import new_file, require_new

        force = _force(self.force)
        for path in filter(None, (self.picture, self.apply)):
            require_new(path)
        import skylimb
        from skylimb.flight.experiments.experiment import robot_of
        from skylimb.studies.planning.task_plan import EXPERIMENT, plan_posture, write_planned

        experiment = skylimb.load_experiment(self.experiment, settings_of(self.set))
        robot = robot_of(experiment)
        controller = skylimb.load_controller(self.controller, robot)
        with output.working("looking for a posture"):
            plan = plan_posture(experiment, robot, controller, force)
        _show(plan)
        if self.picture:
            from skylimb.analysis.figures import style
            from skylimb.studies.planning.task_figure import task_figure

            with new_file(self.picture) as path:
                path.write_bytes(style.png(task_figure(robot, plan.task, plan.own, plan.planned)))
            print(f"Drawn into {self.picture}")
        if self.apply:
            write_planned(plan, experiment, self.apply)
            print(f"Written: skylimb run {self.apply}/{EXPERIMENT} --controller {self.controller}")
        return 0


def _force(text: str) -> float | None:
    if not text:
        return None
    try:
        force = float(text)
    except ValueError:
        raise ConfigError(f"--force = '{text}' must be a number (N)") from None
    if not 0.0 < force < _MOST:
        raise ConfigError(f"--force = {force:g} N is outside of 0 .. {_MOST:g} N")
    return force


def _show(plan: TaskPlan) -> None:
    title = f"{plan.robot.name}, pressing with {plan.force:g} N at {len(plan.points)} points of the path"
    table = output.plain_table(title, "", "own posture", "planned")
    own, planned = _column(plan.own), _column(plan.planned)
    for name, value in planned.items():
        table.add_row(name, own.get(name, "-"), value)
    console = output.console_for()
    console.print(table)
    if not plan.own:
        least = f"; it can hold {plan.own.greatest:.1f} N" if plan.own.greatest else ""
        console.print(f"Its own posture cannot do this task: {plan.own}{least}")


def _column(posture: TaskPosture | NotHeld) -> dict[str, str]:
    """What is shown of a posture."""
    if not posture:
        return {}
    return {
        "worst margin, N m": f"{posture.margin:.2f}",
        "joint angles, rad": _listed(posture.joint_angles),
        "vectoring angles, rad": _listed(posture.vectoring_angles),
        "heading beside the contact axis, rad": f"{posture.heading:.3f}",
        "thrusts, N": f"{posture.thrusts.min():.1f} .. {posture.thrusts.max():.1f}",
    }


def _listed(values: np.ndarray) -> str:
    return ", ".join(f"{value:.3f}" for value in values) or "none"


VERBS = {"plan": Plan}
