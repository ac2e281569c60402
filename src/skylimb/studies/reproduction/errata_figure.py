"""One figure that shows what each printed form does."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr
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


def fly_errata() -> dict[str, Run]:
    """The flights of the figure."""
    robot = load_robot("hydrus_xi_quad")
    return {
        "lift": run("paper", "impedance", set=HOVER),
        "lift as printed": run("paper", impedance_with_mass_times_force(robot), set=HOVER),
        "arm": run("paper", "hybrid"),
        "arm, eq:admittance control": run("paper", hybrid_with(admittance_as_printed, robot)),
        "arm, eq:difference method1": run("paper", hybrid_with(difference_as_printed, robot)),
        "velocities sent": run("paper", "impedance", set={"trajectory.feedforward": "velocity"}),
        "positions sent": run("paper", "impedance"),
    }


@style.styled
def errata_figure(runs: Mapping[str, Run]) -> Figure:
    """What the printed forms do, beside the corrected ones.

    Args:
        runs: of `fly_errata`.
    """
    figure, ((lift, arm), (leak, follow)) = style.sheet(4.8, 2, 2)
    for ax, panel in ((lift, _LIFT), (arm, _ARM), (follow, _FOLLOW)):
        panel.draw(ax, runs)
    _leak(leak)
    arm.axvline(_begin(runs["arm"], "slide"), color=style.TRUTH, linewidth=0.7)
    arm.set_ylim(-95.0, 150.0)  # room for the legend above
    sent = runs["positions sent"]
    sliding = in_phase(sent.log, "slide")
    times = sent.log.time.values[sliding] - _begin(sent, "slide")
    reference = sent.log.cog_position_reference.values[sliding, 1]
    follow.plot(times, reference, label="reference", zorder=1, **style.AS_REFERENCE)
    for ax in (lift, arm, leak, follow):
        ax.legend()
    return figure


@dataclass(frozen=True)
class _Panel:
    """Curves of several flights over time.

    Attributes:
        title: of the panel.
        xlabel: of the time.
        ylabel: of what is drawn.
        drawn: that, of a log, (k,).
        shown: which of a run's ticks are, (k,).
        curves: name of a flight, colour, and what the curve is called.
        zero: phase whose beginning is the panel's zero of time; the take-off when empty.
    """

    title: str
    xlabel: str
    ylabel: str
    drawn: Callable[[xr.Dataset], xr.DataArray]
    shown: Callable[[Run], np.ndarray]
    curves: tuple[tuple[str, str, str], ...]
    zero: str = ""

    def draw(self, ax: Axes, runs: Mapping[str, Run]) -> None:
        """Draw every curve; a cross marks the end of a flight that was lost."""
        for name, colour, text in self.curves:
            run = runs[name]
            shown = self.shown(run)
            times = run.log.time.values[shown] - (_begin(run, self.zero) if self.zero else 0.0)
            height = self.drawn(run.log).values[shown]
            ax.plot(times, height, color=colour, label=text)
            if run.failed:
                ax.plot(times[-1], height[-1], "x", color=style.FAILURE, markersize=6)
        ax.set(title=self.title, xlabel=self.xlabel, ylabel=self.ylabel)


def _begin(run: Run, phase: str) -> float:
    """When a phase of a run begins, s."""
    return float(run.log.time.values[np.argmax(in_phase(run.log, phase))])


_LIFT = _Panel(
    "eq:thrust translation 2",
    "time (s)",
    "height above the reference (m)",
    lambda log: (log.cog_position - log.cog_position_reference)[:, 2],
    lambda run: run.log.time.values <= _PENDING,
    (("lift", RIGHT, "f_cmd"), ("lift as printed", WRONG, "m f_cmd, as printed")),
)
_ARM = _Panel(
    "the arm's admittance",
    "time (s)",
    "commanded extension (mm)",
    lambda log: 1e3 * (log.reach_command - log.reach_reference),
    lambda run: run.log.time.values >= _begin(run, "approach"),
    (
        ("arm", RIGHT, "corrected"),
        ("arm, eq:admittance control", WRONG, "eq:admittance control, as printed"),
        ("arm, eq:difference method1", OTHER, "eq:difference method1, as printed"),
    ),
)
_FOLLOW = _Panel(
    "eq:error of rotation (impedance)",
    "time of the slide (s)",
    "CoG in y (m)",
    lambda log: log.cog_position[:, 1],
    lambda run: in_phase(run.log, "slide"),
    (("velocities sent", RIGHT, "e_v with p_ref'"), ("positions sent", WRONG, "p_ref' = 0")),
    zero="slide",
)


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
