"""Whether a campaign has flown enough: a function of the finished draws, whoever flew them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import combinations

import numpy as np

from skylimb.studies.campaign.frozen import Campaign
from skylimb.studies.campaign.rows import Row
from skylimb.studies.campaign.statistics import compare_paired, scores_of, success_rate


def looks(campaign: Campaign) -> Iterator[int]:
    """Numbers of draws at which the rule is looked at, the last being all of them."""
    stop, most = campaign.spec.stop, campaign.spec.draws
    if stop is not None:
        draws = stop.at_least
        while draws < most:
            yield draws
            draws += stop.every
    yield most


def enough(campaign: Campaign, rows: Mapping[int, Row], draws: int) -> bool:
    """Whether the intervals over the first `draws` draws are narrow enough to stop."""
    stop = campaign.spec.stop
    if stop is None:
        return False
    scores = scores_of(campaign, rows, draws)
    count = len(scores.draws)
    if count < 2:
        return False
    if stop.until == "success":
        rates = [success_rate(int(column.sum()), count) for column in scores.success.T]
        return max(rate.high - rate.low for rate in rates) <= stop.width
    if stop.until not in scores.metrics:
        return False
    columns = list(scores.cost(stop.until).T)
    # A controller alone is compared with nothing: what is left is the interval of its own median.
    pairs = list(combinations(columns, 2)) or [(columns[0], np.zeros(count))]
    found = [compare_paired(first, second) for first, second in pairs]
    widths = [0.0 if pair.low == pair.high else pair.high - pair.low for pair in found]
    return max(widths) <= stop.width
