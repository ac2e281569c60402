"""Which unknown moves which number: rank correlations over the draws."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from skylimb.studies.campaign.frozen import Campaign
from skylimb.studies.campaign.rows import parameters
from skylimb.studies.campaign.statistics.intervals import rank_correlation

CHANCE = {"shown": 2.82, "clear": 4.23}
"""How many standard deviations of chance from which an unknown shows, and from which it is clear.

Ranks of n draws that have nothing to do with each other correlate by 1 / sqrt(n - 1) in the mean square:
0.07 of 200, where these are 0.2 and 0.3; 0.23 of 20.
"""


def beyond_chance(draws: int, word: str) -> float:
    """The rank correlation from which an unknown is "shown", or "clear", with so many draws."""
    return CHANCE[word] / math.sqrt(max(draws - 1, 1))


def shown_unknowns(sensitivity: Mapping[tuple[str, str], Mapping[str, float]], draws: int) -> list[str]:
    """Unknowns that show in one of the numbers.

    Args:
        sensitivity: (controller, key) -> unknown -> rank correlation, NaN where there is none.
        draws: over which they are.
    """
    least = beyond_chance(draws, "shown")
    strongest: dict[str, float] = {}
    for found in sensitivity.values():
        for name, value in found.items():
            strongest[name] = max(strongest.get(name, 0.0), abs(value) if math.isfinite(value) else 0.0)
    return [name for name, value in strongest.items() if value >= least]


def unknown_columns(campaign: Campaign, draws: int) -> dict[str, np.ndarray]:
    """Every unknown as a column of numbers, (draws,).

    Entries of a list stand apart, unless one factor scales them all. A choice of two is 0 or 1. An angle on
    the circle enters as the place where the lap starts, across and up. What scatters about a middle enters a
    second time as its distance from there: a number that any error makes worse has no correlation with its
    sign.
    """
    table = [parameters(campaign, campaign.draw(index)) for index in range(draws)]
    columns: dict[str, np.ndarray] = {}
    for name in table[0]:
        values = [row[name] for row in table]
        key, _, entry = name.rpartition(".")
        times = campaign.spec.vary[key].times if entry.isdigit() else None
        if times:
            if entry == "0":
                columns[key] = np.array(values) / times[0]
            continue
        if name.endswith("start_angle"):
            angles = np.array(values)
            columns[f"{name}, across"] = np.round(np.cos(angles), 9)
            columns[f"{name}, up"] = np.round(np.sin(angles), 9)
        elif isinstance(values[0], str):
            known = sorted(set(values))
            columns[name] = np.array([float(known.index(value)) for value in values])
        else:
            columns[name] = np.array([float(value) for value in values])
            spread = campaign.spec.vary.get(name, campaign.spec.vary.get(key))
            if spread is not None and spread.normal:
                columns[f"|{name}|"] = np.abs(columns[name] - spread.normal[0])
    return columns


def correlations(columns: Mapping[str, np.ndarray], values: np.ndarray) -> dict[str, float]:
    """Spearman's rank correlation of a number with every unknown, over the flights that finished."""
    there = np.isfinite(values)
    return {name: rank_correlation(column[there], values[there]) for name, column in columns.items()}
