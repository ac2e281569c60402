"""Who wins a campaign, in words, and how many draws would tell where nobody does."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from skylimb.analysis.figures import style
from skylimb.studies.campaign.statistics import draws_needed, level_of_pair
from skylimb.studies.campaign.statistics.sign_test import better
from skylimb.studies.campaign.summary import Summary

_MOST = 10_000
"""Draws beyond which a number of draws is no longer named."""


def shown_ranks(ranks: Sequence[int]) -> list[int]:
    """The ranks to show: none, 0, where the draws tell nobody apart."""
    return list(ranks) if len(set(ranks)) > 1 else [0] * len(ranks)


def verdicts(summary: Summary, aim: str) -> list[str]:
    """Who is first, in words, for each thing that is ranked; silent where all share the first rank.

    Args:
        summary: of the campaign.
        aim: what a controller is good at that has many successes.
    """
    scores, names = summary.scores, summary.scores.controllers
    said = []
    for key, ranks in summary.ranks.items():
        first = [style.label(name) for name, place in zip(names, ranks, strict=True) if place == 1]
        what = aim if key == "success" else within(scores.declared[key].text(summary.axes))
        what = what.removesuffix(" (truth)")
        if len(first) < len(names):
            verb = "are level and lead" if len(first) > 1 else "leads"
            said.append(f"{_listed(first)} {verb} in {what}")
    return said


def draws_needed_for(summary: Summary, score: str) -> list[str]:
    """For each pair that these draws don't tell apart in the score, about how many draws would."""
    scores, names = summary.scores, summary.scores.controllers
    if score not in scores.metrics:
        return []
    values, level = scores.cost(score), level_of_pair(len(names))
    what = within(scores.declared[score].text(summary.axes))
    lines = []
    for a, b in combinations(range(len(names)), 2):
        if better(values[:, a], values[:, b], level):
            continue
        both = f"{style.label(names[a])} and {style.label(names[b])}"
        count = draws_needed(values[:, a], values[:, b], level)
        some = f"about {_rounded(count)} draws" if count <= _MOST else f"more than {_MOST} draws"
        lines.append(
            f"{both}: {some} would tell them apart in the {what}"
            if np.isfinite(count)
            else f"{both}: no difference in the {what}"
        )
    return lines


def fails_where(summary: Summary, name: str, failure: str) -> str:
    """Where in what was drawn a controller fails, in words; `failure` is what that is called."""
    rate, region = summary.rates[name], summary.regions[name]
    if not rate.draws:
        return "nothing was flown"
    if rate.successes == rate.draws:
        return f"no {failure}"
    if rate.successes == 0:
        return f"all {rate.draws} fail"
    if region is None:
        return f"{rate.draws - rate.successes} of {rate.draws} fail; no parameter tells where"
    conditions = " and ".join(str(condition) for condition in region.conditions)
    return (
        f"{region.failed} of {region.draws} fail where {conditions}; elsewhere {region.failed_outside} of "
        f"{region.draws_outside}"
    )


def within(text: str) -> str:
    """A description in the middle of a sentence."""
    return text[:1].lower() + text[1:]


def _rounded(count: float) -> int:
    """A number with two places that count."""
    return int(float(f"{count:.2g}"))


def _listed(words: list[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"
