"""The area that a soft pen covers: its line is as wide as it presses.

Line and width are those of the experiment (`trajectory.force`, `trajectory.brush`), and those that were
flown: the place of the tip at every sample in touch, landing and leaving included, and the mean of the normal
force over `FORCE_WINDOW`, as what is soft does not follow a hard tip's chatter. Both are drawn as discs on a
grid. Nothing is moved to fit: a drawing beside its place covers another area.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from skylimb.analysis.recording.run import Run
from skylimb.analysis.scores.force import FORCE_WINDOW
from skylimb.analysis.scores.pen_line import between_gaps, dense, marks
from skylimb.analysis.scores.score import DRAWING, metric
from skylimb.analysis.scores.signals import around, samples_within

if TYPE_CHECKING:
    import xarray as xr

CELL = 0.0005
"""Side of a cell of the grid, m."""


class Areas(NamedTuple):
    """Two areas on one grid.

    Attributes:
        wanted: the cells that the reference covers, (along u, along v).
        drawn: those that the pen covered.
        low: (u, v) of the first cell's middle, m, (2,).
    """

    wanted: np.ndarray
    drawn: np.ndarray
    low: np.ndarray


@metric(
    unit="",
    smaller_is_better=False,
    ranked=False,
    group=DRAWING,
    row="drawn area over wanted area: what both cover, of what either covers",
    meaning="Area that the drawn and the wanted line both cover, over the area that either covers",
)
def area_iou(run: Run) -> float:
    """Intersection over union of the drawn and the wanted area; no number without a soft pen."""
    found = areas(run.log)
    if found is None:
        return np.nan
    either = np.count_nonzero(found.wanted | found.drawn)
    return float(np.count_nonzero(found.wanted & found.drawn) / max(either, 1))


def areas(log: xr.Dataset) -> Areas | None:
    """The wanted and the drawn area; None of a log without a soft pen, or whose force has a gap in touch."""
    if not {"reference_width", "contact_force_normal"} <= set(log.variables):
        return None
    line = np.column_stack([log.reference_line.values, log.reference_width.values])
    samples, points = marks(log)
    count = samples_within(log.time.values, FORCE_WINDOW)
    force = around(log.contact_force_normal.values, count).mean(axis=-1)[samples]
    if not np.isfinite(force).all():
        return None
    width = float(log.reference_width.attrs["per_force"]) * force
    return areas_of(
        np.vstack([dense(stroke) for stroke in between_gaps(line)]), np.column_stack([points, width])
    )


def areas_of(wanted: np.ndarray, drawn: np.ndarray) -> Areas:
    """Two areas made of discs: rows of u, v and width, m, (n, 3) and (m, 3)."""
    both = np.vstack([wanted, drawn])
    low = both[:, :2].min(axis=0) - both[:, 2].max()
    size = np.ceil((both[:, :2].max(axis=0) + both[:, 2].max() - low) / CELL).astype(int) + 1
    return Areas(_covered(wanted, low, size), _covered(drawn, low, size), low)


def _covered(discs: np.ndarray, low: np.ndarray, size: np.ndarray) -> np.ndarray:
    """The cells of a grid that some discs cover, (rows, columns); the grid has room for all of each."""
    covered = np.zeros(size, dtype=bool)
    centres = np.round((discs[:, :2] - low) / CELL).astype(int)
    radii = np.round(0.5 * discs[:, 2] / CELL, 1)
    for radius in np.unique(radii[radii > 0.0]):
        reach = np.arange(-int(radius), int(radius) + 1)
        beside = np.stack(np.meshgrid(reach, reach, indexing="ij"), axis=-1).reshape(-1, 2)
        beside = beside[np.hypot(*beside.T) <= radius]
        cells = np.unique(centres[radii == radius], axis=0)[:, None, :] + beside
        covered[cells[..., 0], cells[..., 1]] = True
    return covered
