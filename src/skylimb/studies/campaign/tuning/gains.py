"""Gains as the search sees them: where a controller has them now, and as points of the unit cube."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from skylimb.base.config import value_of
from skylimb.base.errors import ConfigError
from skylimb.control.controller import resolved_tables
from skylimb.flight.experiments.experiment import robot_of
from skylimb.studies.campaign.frozen import Campaign
from skylimb.studies.campaign.spec import Search

Gains = dict[str, float]
"""Dotted gain of a controller -> its value."""


def present_gains(campaign: Campaign, name: str, search: Search) -> Gains:
    """The gains that are searched, as the controller has them now.

    Raises:
        ConfigError: when the controller has no such gains, or cannot fly with the ends of their ranges.
    """
    robot = robot_of(campaign.experiment_of(campaign.draw(0)))
    tables = resolved_tables(campaign.load(name, robot))
    found = {key: value_of(tables, key) for key in search.gains}
    for key, value in found.items():
        if value is None:  # refused with the nearest right name, if there is no such gain
            campaign.load(name, robot, {key: search.gains[key][0]})
        if not isinstance(value, int | float) or isinstance(value, bool):
            raise ConfigError(f"tune.gains.'{key}' is no single number of controller '{name}'")
    for end in (0, 1):
        campaign.load(name, robot, {key: bounds[end] for key, bounds in search.gains.items()})
    return {key: float(value) for key, value in found.items()}


def to_point(gains: Gains, search: Search) -> list[float]:
    """Gains as a point of the unit cube, kept a little off its faces."""
    point = []
    for key, (low, high) in search.gains.items():
        value = float(np.clip(gains[key], low, high))
        if search.logarithmic:
            point.append(np.log(value / low) / np.log(high / low))
        else:
            point.append((value - low) / (high - low))
    # The search wants two coordinates at least; where there is one gain, the second moves nothing.
    point += [0.5] * (2 - len(point))
    return [float(np.clip(entry, 0.01, 0.99)) for entry in point]


def from_point(point: Sequence[float], search: Search) -> Gains:
    """Gains at a point of the unit cube; entries beyond the gains move nothing."""
    found = {}
    for entry, (key, (low, high)) in zip(point, search.gains.items(), strict=False):
        share = float(np.clip(entry, 0.0, 1.0))
        found[key] = low * (high / low) ** share if search.logarithmic else low + (high - low) * share
    return found
