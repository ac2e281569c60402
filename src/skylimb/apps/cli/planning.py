"""The verb that finds a posture for an experiment: `plan`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

from skylimb.apps.cli import output
from skylimb.apps.cli.arguments import arg
from skylimb.apps.cli.options import Experiment, Settings, within

if TYPE_CHECKING:
    import numpy as np

    from skylimb.control.planning.task import TaskPosture
    from skylimb.robots.equilibrium_results import NotHeld
    from skylimb.studies.planning.rehearsal import Rehearsal
    from skylimb.studies.planning.task_plan import TaskPlan


def plan(
    experiment: Experiment = "paper",
    *,
    controller: Annotated[
        str, arg("What is to fly it: its force, and what its vectoring angles keep.", "NAME")
    ] = "hybrid",
    force: Annotated[float | None, arg("Normal force; by default what is commanded, else 3 N.", "N")] = None,
    set: Settings = None,
    by: Annotated[
        Literal["flight", "margin"],
        arg("Propose only what flies as well as its own posture, or the greatest margin that is not lost."),
    ] = "flight",
    picture: Annotated[str, arg("Draw both postures into this new file.", "PNG")] = "",
    apply: Annotated[str, arg("New folder for the experiment and its robot.", "DIR")] = "",
) -> None:
    """Find the posture that leaves the rotors the most torque all along an experiment's path.

    Joint angles, heading and vectoring angles are chosen together, for the push along the surface's normal
    and the drag of its friction, within joint limits, without links or rotors touching anything. A posture
    is flown, with the asked force, before it is proposed. With --apply the experiment is written anew, with
    its robot standing that way.

    Examples:
        skylimb plan paper
        skylimb plan paper --force 5 --picture posture.png
        skylimb plan paper --controller following --by margin --apply planned
        skylimb run planned/experiment.toml --controller following
    """
    from skylimb.base.files import new_file, require_new

    for path in filter(None, (picture, apply)):
        require_new(path)
    if force is not None:
        within("--force", force, 0.001, 1000.0, "N")
    import skylimb
    from skylimb.flight.loading import load_flight
    from skylimb.studies.planning.task_plan import EXPERIMENT, write_planned

    loaded = load_flight(experiment, controller, set=set)  # a wrong name is refused before anything is said
    with output.working("looking for a posture"):
        found = skylimb.plan(loaded.experiment, loaded.controller, force, by=by)
    _show(found)
    if picture:
        from skylimb.analysis.figures import style
        from skylimb.studies.planning.task_figure import task_figure

        with new_file(picture) as path:
            path.write_bytes(style.png(task_figure(found.robot, found.task, found.nominal, found.planned)))
        print(f"Drawn into {picture}")
    if apply:
        write_planned(found, apply)
        print(f"Written: skylimb run {apply}/{EXPERIMENT} --controller {controller}")


def _show(found: TaskPlan) -> None:
    own = {**_column(found.nominal), **_flight(found.own_flight)}
    planned = {**_column(found.planned), **_flight(found.planned_flight)}
    title = f"{found.robot.name}, pressing with {found.force:g} N at {len(found.points)} points of the path"
    output.show_table(
        [(name, own.get(name, "-"), value) for name, value in planned.items()],
        *("", "own posture", "planned"),
        title=title,
    )
    if not found.nominal:
        least = f"; it can hold {found.nominal.greatest:.1f} N" if found.nominal.greatest else ""
        print(f"Its own posture cannot do this task: {found.nominal}{least}")


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


def _flight(flown: Rehearsal | None) -> dict[str, str]:
    """What is shown of its flights."""
    if flown is None or flown.lost:
        return {} if flown is None else {"flown": flown.lost}
    return {
        "flown: normal force, N": f"{flown.force:.2f} +- {flown.spread:.2f}",
        "flown: in touch": f"{flown.touch:.2f}",
        "flown: off its line, mm": f"{1e3 * flown.line:.1f}",
    }


def _listed(values: np.ndarray) -> str:
    return ", ".join(f"{value:.3f}" for value in values) or "none"
