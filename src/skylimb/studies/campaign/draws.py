"""The draws of a campaign: a pure function of the spec and an index, the same wherever it is evaluated.

Point p of the sequence is a point of the unit cube, one coordinate for each number that is drawn. Where the
spec has grids, each point is flown in every cell of the grid before the next one is taken: draw i is point
i // cells in cell i % cells. Every controller flies the same draws, noise included.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.stats import qmc

from skylimb.base.config import put, to_mapping
from skylimb.studies.campaign.spec import CampaignSpec

GAIN = "controller."
"""Before a varied key: a gain of the controller's, not a key of the experiment."""

_BLOCK = 1024
"""Points that are laid at once; a power of two, as the Sobol sequence likes it."""


@dataclass(frozen=True)
class Draw:
    """One draw.

    Attributes:
        index: of the draw.
        seed: of the flight's noise.
        values: dotted key -> value, in the spec's order.
    """

    index: int
    seed: int
    values: dict[str, Any]

    @property
    def gains(self) -> dict[str, Any]:
        """Those of the values that belong to the controller, without their prefix."""
        return {key.removeprefix(GAIN): value for key, value in self.values.items() if key.startswith(GAIN)}


def draw(spec: CampaignSpec, index: int) -> Draw:
    """Draw `index` (from 0; it may go beyond `spec.draws`) of a campaign."""
    point = _point(spec, index // spec.cells)
    cell = index % spec.cells
    values: dict[str, Any] = {}
    at = 0
    for key, entry in spec.vary.items():
        if entry.grid:
            values[key] = entry.grid[cell % len(entry.grid)]
            cell //= len(entry.grid)
        else:
            values[key] = entry.value(point[at : at + entry.dimensions])
            at += entry.dimensions
    noise = int(np.random.SeedSequence([spec.seed, 1, index]).generate_state(1)[0])
    return Draw(index, int(values.pop("seed", noise)), values)


def _point(spec: CampaignSpec, index: int) -> np.ndarray:
    dimensions = sum(entry.dimensions for entry in spec.vary.values())
    if not dimensions:
        return np.zeros(0)
    block, row = divmod(index, _BLOCK)
    return _block(spec.sampling, spec.seed, dimensions, block)[row]


@lru_cache(maxsize=8)
def _block(sampling: str, seed: int, dimensions: int, block: int) -> np.ndarray:
    """Points block * _BLOCK and following of a sequence, (_BLOCK, dimensions)."""
    if sampling == "random":
        return np.random.default_rng([seed, 0, block]).random((_BLOCK, dimensions))
    kind = qmc.Sobol if sampling == "sobol" else qmc.Halton
    sequence = kind(dimensions, scramble=True, rng=np.random.default_rng(seed))
    if block:
        sequence.fast_forward(block * _BLOCK)
    return sequence.random(_BLOCK)


def changed(mapping: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """A deep copy of nested tables with the values under some dotted keys replaced.

    A number in a key picks an entry of a list.

    Raises:
        ConfigError: when a key leads through something that is neither table nor list.
    """
    copy = to_mapping(mapping, keep_none=True)
    for key, value in changes.items():
        put(copy, key, value)
    return copy
