"""One figure that shows what each printed form does."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from skylimb.analysis.figures import style
from skylimb.analysis.recording.run import Run
from skylimb.analysis.scores.signals import in_phase
from skylimb.flight.public import run
from skylimb.robots.loader import load_robot
from skylimb.studies.reproduction.printed_forms import (
    admittance_as_printed,
    difference_as_printed,
    hybrid_with,
    impedance_with_mass_times_force,
    leak_matrix,
)

HOVER = {
    "approach.contact": False,
    "trajectory.shape": "hold",
    "trajectory.duration": 1.0,
    "phases.hover": 2.0,
    "phases.tare": 0.5,
    "phases.settle": 0.0,
    "phases.hover_end": 0.0,
}
"""A free flight: no board is needed to see the lift."""

RIGHT, WRONG, OTHER = "#0072B2", "#D55E00", "#8C6D00"
_PENDING = 1.6


def fly_errata(changes: Mapping[str, Any] | None = None) -> dict[str, Run]:
    """The flights of the figure.

    Args:
        changes: dotted keys of the experiment and new values, for all of them.
    """
    robot, given = load_robot("hydrus_xi_quad"), dict(changes or {})
    hover = {**given, **HOVER}
    return {
        "lift": run("paper", "impedance", set=hover),
        "lift as printed": run("paper", impedance_with_mass_times_force(robot), set=hover),
        "arm": run("paper", "hybrid", set=given),
        "arm, eq:admittance control": run("paper", hybrid_with(admittance_as_printed, robot), set=given),
        "arm, eq:difference method1": run("paper", hybrid_with(difference_as_printed, robot), set=given),
        "velocities sent": run("paper", "impedance", set={**given, "trajectory.feedforward": "velocity"}),
        "positions sent": run("paper", "impedance", set=given),
    }


@style.styled
def errata_figure(runs: Mapping[str, Run]) -> Figure:
    """What the printed forms do, beside the corrected ones.

    Args:
        runs: of `fly_errata`.
    """
    figure = Figure((style.WIDTH, 4.8), layout="constrained")
    axes = figure.subplots(2, 2)
    _lift(axes[0, 0], runs)
    _arm(axes[0, 1], runs)
    _leak(axes[1, 0])
    _follow(axes[1, 1], runs)
    return figure


def _curve(
    ax: Axes, run: Run, shown: np.ndarray, height: np.ndarray, line: tuple[str, str], since: float = 0.0
) -> None:
    """A flight's curve over the ticks that are shown; a cross marks the end of one that was lost.

    Args:
        ax: where.
        run: flown.
        shown: whether each tick is, (k,).
        height: what is drawn, (k,).
        line: its colour and what it is called.
        since: time that is the panel's zero, s.
    """
    times = run.log.time.values[shown] - since
    ax.plot(times, height[shown], color=line[0], label=line[1])
    if run.failed:
        ax.plot(times[-1], height[shown][-1], "x", color=style.FAILURE, markersize=6)


def _lift(ax: Axes, runs: Mapping[str, Run]) -> None:
    for name, line in (("lift", (RIGHT, "f_cmd")), ("lift as printed", (WRONG, "m f_cmd, as printed"))):
        log = runs[name].log
        height = log.cog_position.values[:, 2] - log.cog_position_reference.values[:, 2]
        _curve(ax, runs[name], log.time.values <= _PENDING, height, line)
    ax.set(title="eq:thrust translation 2", xlabel="time (s)", ylabel="height above the reference (m)")
    ax.legend()


def _arm(ax: Axes, runs: Mapping[str, Run]) -> None:
    approach = _begin(runs["arm"], "approach")
    for name, line in (
        ("arm", (RIGHT, "corrected")),
        ("arm, eq:admittance control", (WRONG, "eq:admittance control, as printed")),
        ("arm, eq:difference method1", (OTHER, "eq:difference method1, as printed")),
    ):
        log = runs[name].log
        moved = 1e3 * (log.reach_command - log.reach_reference).values
        _curve(ax, runs[name], log.time.values >= approach, moved, line)
    ax.axvline(_begin(runs["arm"], "slide"), color=style.TRUTH, linewidth=0.7)
    ax.set(title="the arm's admittance", xlabel="time (s)", ylabel="commanded extension (mm)")
    ax.set_ylim(-95.0, 150.0)  # room for the legend above
    ax.legend(loc="upper right")


def _begin(run: Run, phase: str) -> float:
    return float(run.log.time.values[np.argmax(in_phase(run.log, phase))])


def _leak(ax: Axes) -> None:
    leak = leak_matrix(load_robot("hydrus_xi_quad"), np.pi / 6)
    for index, (axis, colour) in enumerate(zip("xyz", (RIGHT, OTHER, WRONG), strict=True)):
        ax.bar(
            np.arange(3) + 0.25 * (index - 1), leak[index], width=0.22, color=colour, label=f"force in {axis}"
        )
    ax.axhline(0.0, color=style.DARK, linewidth=1.2)
    ax.text(0.02, 0.04, "printed: zero", transform=ax.transAxes, fontsize=7)
    ax.set_xticks(range(3), ["1 N m of roll", "of pitch", "of yaw"])
    ax.set(title="eq:thrust rotation 1: the leak Q_t pinv(Q_r)", ylabel="N")
    ax.legend()


def _follow(ax: Axes, runs: Mapping[str, Run]) -> None:
    log, start = runs["positions sent"].log, _begin(runs["positions sent"], "slide")
    sliding = in_phase(log, "slide")
    ax.plot(
        log.time.values[sliding] - start, log.cog_position_reference.values[sliding, 1],
        color=style.REFERENCE, linestyle=(0, (4, 2.5)), linewidth=0.9, label="reference",
    )  # fmt: skip
    for name, line in (
        ("velocities sent", (RIGHT, "e_v with p_ref'")),
        ("positions sent", (WRONG, "p_ref' = 0")),
    ):
        log = runs[name].log
        _curve(ax, runs[name], in_phase(log, "slide"), log.cog_position.values[:, 1], line, start)
    ax.set(title="eq:error of rotation (impedance)", xlabel="time of the slide (s)", ylabel="CoG in y (m)")
    ax.legend()
