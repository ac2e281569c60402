"""What a table of flights says: rates, paired differences, ranks with ties, and where controllers fail.

A loss counts as a loss. In every comparison a lost flight stands behind any flight that finished, and two
lost ones are equal; none is ever left out.
"""

from skylimb.campaign.statistics.intervals import LEVEL, Rate, success_rate
from skylimb.campaign.statistics.paired import Paired, compare_paired
from skylimb.campaign.statistics.ranking import rank
from skylimb.campaign.statistics.regions import Region, failure_region, telling_parameters
from skylimb.campaign.statistics.scores import Scores, is_success, scores_of

__all__ = [
    "LEVEL",
    "Paired",
    "Rate",
    "Region",
    "Scores",
    "compare_paired",
    "failure_region",
    "is_success",
    "rank",
    "scores_of",
    "success_rate",
    "telling_parameters",
]
