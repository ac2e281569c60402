"""The numbers that the paper printed, to stand beside ours.

They are measurements on a real robot, and not targets to tune to.
"""

from __future__ import annotations

from dataclasses import dataclass

from skylimb.analysis.paper.configuration import is_the_papers
from skylimb.analysis.recording import Run

SOURCE = (
    "Z. Luo, M. Lei, J. Li, Y. Chen, Z. Xiong, M. Zhao: Hybrid Impedance-Admittance Control with Multi-Link "
    "Aerial Robot for Contact-Rich Surface Sliding Task, section Experiments (the text on the two box plots)"
)
"""Where the numbers stand."""


@dataclass(frozen=True)
class PublishedMedians:
    """What the paper gives for one controller, under the names of our metrics.

    It prints no z error and no true contact force.

    Attributes:
        error_u_median: median error of the CoG in y, m.
        displacement_median: median displacement of the CoG in x, m.
        estimated_force_median: median estimated external force in x, N.
    """

    error_u_median: float
    displacement_median: float
    estimated_force_median: float


PUBLISHED = {
    "pid": PublishedMedians(0.134, 0.133, -1.190),
    "impedance": PublishedMedians(0.079, 0.137, -0.453),
    "admittance": PublishedMedians(0.105, 0.088, -0.712),
    "hybrid": PublishedMedians(0.083, 0.084, -0.328),
}
"""By controller."""


def published(controller: str, metric: str) -> float | None:
    """The paper's number for a controller and one of our metrics, or None where it prints none."""
    return getattr(PUBLISHED.get(controller), metric, None)


def published_beside(run: Run, metric: str) -> float | None:
    """The paper's number to stand beside a run's own; None where it prints none.

    None as well beside a run of any other configuration than the paper's (`configuration`).
    """
    number = published(run.controller, metric)
    return number if number is not None and is_the_papers(run) else None
