"""One figure of a vectoring table: angles, slope, guaranteed torque and hover tilt over the posture."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from skylimb.planning.posture import posture_family
from skylimb.planning.vectoring import VectoringTable
from skylimb.robots import Robot

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Okabe and Ito's colours with dashes: told apart by every eye, and in grey.
_LINES = (
    ("#0072B2", "-"),
    ("#D55E00", "--"),
    ("#009E73", "-."),
    ("#CC79A7", ":"),
    ("#E69F00", "-"),
    ("#56B4E9", "--"),
)


def vectoring_figure(robot: Robot, table: VectoringTable) -> Figure:
    """Draw a table over its whole range of theta; what the joint limits forbid is shaded.

    Returns:
        A figure that belongs to no window; save it with `figure.savefig`.
    """
    # Drawing is rare, and importing matplotlib takes longer than loading a robot.
    from matplotlib.figure import Figure

    theta = np.linspace(table.theta_min, table.theta_max, 211)
    figure = Figure(figsize=(7.0, 5.2), layout="constrained")
    (angles, slope), (torque, tilt) = figure.subplots(2, 2, sharex=True)
    _draw(angles, theta, np.unwrap(table.angles(theta), axis=0), r"vectoring angles $\psi$ (rad)", robot)
    _draw(slope, theta, table.slope(theta), r"slope $d\psi/d\theta$ (rad/rad)", robot)
    _draw(torque, theta, table.guaranteed_torque(theta)[:, None], "guaranteed torque (N m)", None)
    _draw(tilt, theta, 1e3 * table.hover_tilt(theta)[:, None], "hover tilt (mrad)", None)
    for axes in (torque, tilt):
        axes.set_xlabel(r"shape angle $\theta$ (rad)")
        axes.set_ylim(bottom=0.0)
    family = posture_family(robot)
    for axes in (angles, slope, torque, tilt):
        axes.axvline(family.theta_nominal, color="0.4", linewidth=0.8)
        for low, high in ((table.theta_min, family.theta_min), (family.theta_max, table.theta_max)):
            if low < high:
                axes.axvspan(low, high, color="0.9", zorder=0, label="beyond the joint limits")
    angles.plot([], [], color="0.4", linewidth=0.8, label="nominal posture")
    handles, labels = angles.get_legend_handles_labels()
    unique = dict(zip(labels, handles, strict=True))
    figure.legend(
        unique.values(), unique.keys(), loc="outside lower center", ncols=3, fontsize="small", frameon=False
    )
    figure.suptitle(f"Vectoring angles of {robot.name}")
    return figure


def _draw(axes: Axes, theta: np.ndarray, values: np.ndarray, label: str, robot: Robot | None) -> None:
    names = robot.description.vectoring_joints if robot is not None else ("",) * values.shape[1]
    for index, name in enumerate(names):
        colour, dashes = _LINES[index % len(_LINES)]
        axes.plot(theta, values[:, index], color=colour, linestyle=dashes, label=name or None)
    axes.set_ylabel(label)
    axes.spines[["top", "right"]].set_visible(False)
    axes.margins(x=0.0)
