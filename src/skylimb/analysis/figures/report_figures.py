"""Every figure that a report can show, with its words."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path

from matplotlib.figure import Figure

from skylimb.analysis.figures import style
from skylimb.analysis.figures.area import drawn_area
from skylimb.analysis.figures.boxes import WHISKERS, contact_distributions, sliding_errors
from skylimb.analysis.figures.drawing import SMOOTHING as FORCE_SMOOTHING
from skylimb.analysis.figures.drawing import drawn_line
from skylimb.analysis.figures.over_time import SMOOTHING, cog_tracking, contact_direction
from skylimb.analysis.figures.pose_strip import poses, poses_seen
from skylimb.analysis.figures.progress import common_tool, task_progress
from skylimb.analysis.figures.traces import pen_traces
from skylimb.analysis.recording import Run
from skylimb.analysis.scores.signals import ADAPTATION_THRESHOLD, in_contact
from skylimb.analysis.scores.user_scores import UserFigure


@dataclass(frozen=True)
class ReportFigure:
    """A figure with what a reader needs to read it.

    Attributes:
        name: of its files, without the ending.
        title: a few words.
        caption: what is drawn, and what to look for.
        draw: makes the figure from runs by name.
        suits: whether some runs have something to show in it; any do by default.
    """

    name: str
    title: str
    caption: str
    draw: Callable[[Mapping[str, Run]], Figure]
    suits: Callable[[Mapping[str, Run]], bool] = bool


def _several(runs: Mapping[str, Run]) -> bool:
    """Whether there is something to compare: a lost flight has no box."""
    return len(runs) > 1 and not all(run.failed for run in runs.values())


def _of_a_drawing(runs: Mapping[str, Run]) -> bool:
    return all("reference_line" in run.log for run in runs.values())


def _of_a_touch(runs: Mapping[str, Run]) -> bool:
    """Whether something was touched; a drawing has a better figure of it."""
    return not _of_a_drawing(runs) and any(in_contact(run.log).any() for run in runs.values())


def _flow(text: str) -> str:
    """A text without its line breaks."""
    return " ".join(text.split())


REPORT_FIGURES = (
    ReportFigure(
        "drawing",
        "The drawing",
        _flow(f"""
            Seen from the robot along the contact axis. Thin: the pen's reference; thick: where the pen
            touched, coloured by the normal force (mean of {FORCE_SMOOTHING:g} s). Below: how far each drawn
            sample is from the nearest point of the reference line, over the length drawn so far. Grey: what
            the pen drew while it touched down, settled and left. Place is how far the best rigid move takes
            the line to its reference, shape what that leaves.
        """),
        drawn_line,
        _of_a_drawing,
    ),
    ReportFigure(
        "area",
        "The drawn area",
        _flow("""
            The line of a soft pen is as wide as it presses. Dark: wanted and drawn; blue: wanted, and not
            drawn; orange: drawn, and not wanted. IoU is the dark area over all three.
        """),
        drawn_area,
        lambda runs: all("reference_width" in run.log for run in runs.values()),
    ),
    ReportFigure(
        "task",
        "The task",
        _flow("""
            Solid: what was done with the tool, a valve's turn from its first stop, the depth of a peg's end
            below the face of its hole, or the angle by which a foot is off lying flat. Dashed: what was
            commanded. Yellow: it touches. The verdict looks at the end: where the valve stays, and the last
            five seconds of sliding for peg and foot.
        """),
        task_progress,
        lambda runs: common_tool(runs) is not None,
    ),
    ReportFigure(
        "pen_traces",
        "What the pen drew",
        _flow("""
            The surface as seen from the robot. Dashed: the line without any error. A law that leads the pen
            has the pen's reference there; of any other it is what a pen held still in the robot would draw if
            the centre of gravity kept to its reference. A sloped surface stretches the path. Look for how
            much of it friction takes away, and where the line breaks because the pen lost touch.
        """),
        pen_traces,
        _of_a_touch,
    ),
    ReportFigure(
        "cog_tracking",
        "Centre of gravity along the sliding directions",
        _flow("""
            Solid: the centre of gravity; dashed: the mission's reference; yellow: the pen touches. Where the
            solid line trails the dashed one, friction holds the pen back, or the reference is sent as
            positions alone and the controller lacks its velocity. Impedance control resists friction.
            Dotted, where there is one: the control law's own target, for a law that leads the centre of
            gravity to where the pen is right.
        """),
        cog_tracking,
    ),
    ReportFigure(
        "sliding_errors",
        "Error along the sliding directions",
        _flow(f"""
            Absolute distance of the centre of gravity from the mission's reference over the sliding period,
            the same reference for every controller. Boxes span the quartiles, the bar and the number beside
            it are the median, whiskers reach from {WHISKERS[0]:g} to {WHISKERS[1]:g} %.
        """),
        sliding_errors,
        _several,
    ),
    ReportFigure(
        "contact_direction",
        "Displacement and force along the contact direction",
        _flow(f"""
            Above: how far the centre of gravity is from the mission's reference, which in contact lies behind
            the surface. A controller that keeps the centre of gravity is pushed away from it, one that
            regulates the force stays away by itself. Below: the force that the controller estimated
            (coloured) and the true contact force (black), both as means of {SMOOTHING:g} s; the pale band
            reaches from the smallest to the largest estimate within that time. Pushed by the surface, both
            are negative. Yellow: the pen touches; pink: it touches and the arm has given way by more
            than {1e3 * ADAPTATION_THRESHOLD:g} mm. Blue, where there is any: the controller held the touch
            for lost and looked for the surface again.
        """),
        contact_direction,
    ),
    ReportFigure(
        "contact_distributions",
        "Displacement and force, distributions",
        _flow("""
            The same two quantities over the sliding period, as box plots. An arm that gives way takes up part
            of the board's depth, and the centre of gravity moves less.
        """),
        contact_distributions,
        _several,
    ),
    ReportFigure(
        "poses",
        "The body moves, the arm gives way",
        _flow("""
            Seen from above, at five instants of the sliding period. Grey: where the robot would be if its
            centre of gravity kept to the mission's reference (white cross) in the shape that it had before
            the contact. From the grey robot to the coloured one are both parts of what the contact does: the
            body is moved, as the number says, and the arm is bent, as the reach says. Under the laws that
            adapt, the arm folds where the board comes near and the body moves less.
        """),
        poses,
        poses_seen,
    ),
)
"""Every figure, in the order in which a report shows them."""


def user_figures(runs: Mapping[str, Run], figures: Iterable[UserFigure]) -> list[ReportFigure]:
    """A user's own figures of every run that did not fail."""
    return [
        ReportFigure(
            f"{figure.name}-{name}" if len(runs) > 1 else figure.name,
            f"{figure.name} of {name}" if len(runs) > 1 else figure.name,
            figure.caption,
            lambda _, figure=figure, run=run: figure(run),
        )
        for figure in figures
        for name, run in runs.items()
        if not run.failed
    ]


def write_figures(
    runs: Mapping[str, Run],
    folder: Path,
    own: Iterable[ReportFigure] = (),
    part: Callable[[str], AbstractContextManager[None]] = nullcontext,
) -> list[Path]:
    """Draw every figure that suits these runs into `folder`, as PNG and PDF, and return the PNG paths.

    Args:
        runs: by name.
        folder: where.
        own: figures besides `REPORT_FIGURES`.
        part: around each by its name; it may note what fails and let the others be drawn.

    Raises:
        OSError: when a file cannot be written.
    """
    drawn = []
    for picture in (*REPORT_FIGURES, *own):
        with part(f"figure '{picture.name}'"):
            if picture.suits(runs):
                folder.mkdir(parents=True, exist_ok=True)
                drawn.append(style.save(picture.draw(runs), folder / picture.name)[0])
    return drawn
