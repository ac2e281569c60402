"""What a table of flights says: rates, paired differences, ranks with ties, and where controllers fail.

A loss counts as a loss. In every comparison a lost flight stands behind any flight that finished, and two
lost ones are equal; none is ever left out.
"""

from skylimb.studies.campaign.statistics.intervals import LEVEL, Rate, success_rate
from skylimb.studies.campaign.statistics.paired import Paired, compare_paired
from skylimb.studies.campaign.statistics.ranking import level_of_pair, rank
from skylimb.studies.campaign.statistics.regions import Region, failure_region, parameters_by_information
from skylimb.studies.campaign.statistics.scores import Scores, is_success, refusal, scores_of
from skylimb.studies.campaign.statistics.sign_test import draws_needed, fewest_draws

__all__ = [
    "LEVEL",
    "Paired",
    "Rate",
    "Region",
    "Scores",
    "compare_paired",
    "draws_needed",
    "failure_region",
    "fewest_draws",
    "is_success",
    "level_of_pair",
    "parameters_by_information",
    "rank",
    "refusal",
    "scores_of",
    "success_rate",
]
