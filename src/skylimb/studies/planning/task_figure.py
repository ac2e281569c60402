"""The picture of a planned posture beside the nominal one, from above, and what is left at each push."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from skylimb.analysis.figures import style
from skylimb.base.rotations import rot_z
from skylimb.control.planning.task import Task, TaskPosture
from skylimb.robots.equilibrium_results import NotHeld
from skylimb.robots.model import Robot
from skylimb.studies.planning.outline import outline


@style.styled
def task_figure(robot: Robot, task: Task, nominal: TaskPosture | NotHeld, planned: TaskPosture) -> Figure:
    """Both postures from above, tips on the surface, and the margin at each point of the path.

    Args:
        robot: whose postures they are.
        task: the pushes.
        nominal: the nominal posture, if it holds them.
        planned: the one that was found.
    """
    figure, (above, margins) = style.sheet(2.9, 1, 2, width_ratios=[1.2, 1.0])
    shown = [("nominal", nominal, style.TRUTH), ("planned", planned, style.CURVES[0])]
    for name, posture, colour in shown:
        if not isinstance(posture, NotHeld):
            _draw_robot(above, robot, posture, colour, name)
            points = np.arange(1, len(posture.margins) + 1)
            margins.plot(points, posture.margins, "o-", color=colour, ms=3, lw=1.0, label=name)
    normal = task.normals.mean(axis=0)[:2]
    along = 0.5 * np.array([-normal[1], normal[0]]) / max(float(np.hypot(*normal)), 1e-9)
    above.plot(*np.array([-along, along]).T, color=style.DARK, lw=3.0)
    above.set(
        xlabel="along the contact axis from the tip, m", ylabel="y, m", aspect="equal", title="From above"
    )
    above.legend()
    margins.axhline(0.0, color=style.DARK, lw=0.6)
    margins.set(
        xlabel="point of the path", ylabel="torque left about any axis, N m", title="While it presses"
    )
    margins.set_ylim(bottom=min(0.0, margins.get_ylim()[0]))
    margins.legend()
    return figure


def _draw_robot(axes: Any, robot: Robot, posture: TaskPosture, colour: str, name: str) -> None:
    q, psi = posture.joint_angles, posture.vectoring_angles
    state = robot.at(q, psi)
    turn = (rot_z(posture.heading - state.tip_heading) @ state.R_root_C.T)[:2]  # seen from above
    chain, rotors = outline(robot, q, psi)
    axes.plot(*(turn @ (chain - state.tip_root).T), color=colour, lw=2.0, label=name)
    for _, _, disc in rotors:
        axes.plot(*(turn @ (disc - state.tip_root).T), color=colour, lw=0.8)
    axes.plot(*(turn @ (state.cog_root - state.tip_root)), "*", color=colour, ms=7)
