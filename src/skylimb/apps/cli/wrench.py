"""The verb that says what a robot can do in a posture: `robot wrench`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated

from skylimb.apps.cli import output
from skylimb.apps.cli.arguments import arg
from skylimb.apps.cli.options import within
from skylimb.base.errors import ConfigError

if TYPE_CHECKING:
    import numpy as np

    from skylimb.robots.equilibrium_results import Held, NotHeld, Within
    from skylimb.robots.model import Robot
    from skylimb.studies.planning.feasible_wrench import FeasibleWrench

    Pushes = dict[str, tuple[np.ndarray, dict[str, Held | NotHeld]]]
    """Name of a direction -> the direction, and what was found by column."""


def robot_wrench(
    robot: Annotated[str, arg("A robot's name, folder or file.", "NAME")],
    *,
    posture: Annotated[
        tuple[str, ...], arg("Its joint angles; by default the nominal posture.", "RAD ...")
    ] = (),
    vectoring: Annotated[
        tuple[str, ...],
        arg("Its vectoring angles; by default those with which a flight gets there.", "RAD ..."),
    ] = (),
    direction: Annotated[
        tuple[str, ...], arg("Three numbers: a direction to push in, besides the axes.", "X ...")
    ] = (),
    tilt: Annotated[float, arg("How far the measured link may lean into a push.", "RAD")] = 0.35,
    moves: Annotated[
        float, arg("How far each vectoring angle may move; by default all of its travel.", "RAD")
    ] = math.inf,
    out: Annotated[
        str, arg("New folder for wrench.json (numbers, corners, faces) and wrench.png.", "DIR")
    ] = "",
) -> None:
    """Say what a robot can do in a posture: forces, torques, and how hard its tip can push.

    Thrusts and the torques of the servos are within their limits, the robot is at rest. Level is the measured
    link, from which tilt counts. Pushes are in the level frame whose x axis is the heading; "none" is a
    posture in which it cannot rest so at all, "?" one where every search came to no end. Each is the best of
    several searches: where angles move, it can be held, and a harder one is not ruled out.

    Examples:
        skylimb robot wrench hydrus_xi_quad
        skylimb robot wrench hydrus_xi_quad --direction 1 0.3 0 --out out/wrench
        skylimb robot wrench hydrus_xi_quad --posture 1.2 0.7 -0.4 --tilt 0.2 --moves 1
    """
    from skylimb.base.files import require_new

    within("--tilt", tilt, 0.0, 1.5, "rad")
    within("--moves", moves, 0.0, math.inf, "rad")
    if out:
        require_new(out)
    import skylimb
    from skylimb.studies.planning.feasible_wrench import unit_vector

    model = skylimb.load_robot(robot)
    q = _numbers("--posture", posture, model.n_joints)
    psi = _numbers("--vectoring", vectoring, model.n_vectoring)
    asked_direction = _numbers("--direction", direction, 3)
    directions = _axes()
    if asked_direction is not None:
        directions["yours"] = unit_vector(asked_direction)
    feasible = skylimb.feasible_wrench(model, q, psi)
    asked = _asked(model, tilt, moves)
    with output.working("working out the pushes"):
        pushes = {
            name: (axis, {column: feasible.push(axis, limits) for column, limits in asked.items()})
            for name, axis in directions.items()
        }
    _show(feasible, pushes, tuple(asked))
    if out:
        _write(feasible, pushes, (tilt, moves), out)
        print(f"\nWritten to {out}: wrench.json, wrench.png")


def _asked(robot: Robot, tilt: float, moves: float) -> dict[str, Within]:
    """What is asked of every direction, by the name of its column."""
    from skylimb.robots.equilibrium_results import Within

    tilts = {"level": 0.0} | ({f"tilted up to {tilt:g} rad": tilt} if tilt > 0.0 else {})
    if robot.n_vectoring == 0:
        return {name: Within(one) for name, one in tilts.items()}
    held = {f"{name}, angles held": Within(one) for name, one in list(tilts.items())[-1:]}
    far = "" if math.isinf(moves) else f" up to {moves:g} rad"
    return held | {f"{name}, angles move{far}": Within(one, moves) for name, one in tilts.items()}


def _numbers(option: str, words: tuple[str, ...], count: int) -> np.ndarray | None:
    """The numbers that an option gives, of which there have to be so many; None where it was not given."""
    import numpy as np

    if not words:
        return None
    try:
        numbers = np.array([float(word) for text in words for word in text.split(",") if word])
    except ValueError:
        raise ConfigError(f"{option} = '{' '.join(words)}' must be {count} numbers") from None
    if len(numbers) != count or not np.all(np.isfinite(numbers)):
        raise ConfigError(f"{option} = '{' '.join(words)}' must be {count} finite numbers")
    return numbers


def _axes() -> dict[str, np.ndarray]:
    import numpy as np

    return {
        f"{'+-'[side]}{'xyz'[axis]}": (1 - 2 * side) * np.eye(3)[axis] for axis in range(3) for side in (0, 1)
    }


def _show(feasible: FeasibleWrench, pushes: Pushes, columns: tuple[str, ...]) -> None:
    from skylimb.studies.planning.wrench_tables import summary

    output.show_table(summary(feasible).items(), title=feasible.robot.name)
    rows = []
    for name, (axis, found) in pushes.items():
        shown = name if name != "yours" else f"({', '.join(f'{part:.2f}' for part in axis)})"
        cells = [f"{one.force:.1f}" if one else "none" if one.limit else "?" for one in found.values()]
        last = found[columns[-1]]
        rows.append((shown, *cells, str(last.limit or "nothing") if last else str(last)))
    title = "Greatest push of the tip at rest, N"
    output.show_table(rows, "Direction", *columns, "What ends it", title=title)


def _write(feasible: FeasibleWrench, pushes: Pushes, asked: tuple[float, float], out: str) -> None:
    import json

    from skylimb.analysis.figures import style
    from skylimb.base.files import new_folder
    from skylimb.studies.planning.wrench_figure import wrench_figure
    from skylimb.studies.planning.wrench_tables import as_tables, push_tables

    tables = {
        **as_tables(feasible),
        "tilt": asked[0],
        "moves": asked[1] if math.isfinite(asked[1]) else None,
        "pushes": {name: push_tables(axis, found) for name, (axis, found) in pushes.items()},
    }
    # The robot is drawn with its angles held.
    columns = list(next(iter(pushes.values()))[1])
    drawn = next((name for name in columns if name.endswith("held")), columns[-1])
    forces = {
        name: (axis, one.force if (one := found[drawn]) else math.nan)
        for name, (axis, found) in pushes.items()
    }
    figure = wrench_figure(feasible, forces)
    with new_folder(out) as folder:
        (folder / "wrench.json").write_text(json.dumps(tables, indent=1) + "\n", encoding="utf-8")
        (folder / "wrench.png").write_bytes(style.png(figure))
