"""Which flights keep their log, and which flights are the worst."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from skylimb.studies.campaign.frozen import Campaign
from skylimb.studies.campaign.rows import BROKEN_OFF, FLOWN, LOST, REFUSED, Row
from skylimb.studies.campaign.spec import log_limit
from skylimb.studies.campaign.statistics import is_success


def log_flag(campaign: Campaign) -> str:
    """The `log` of a campaign's jobs; the worst flights are known only when all have flown."""
    return {"failures": "failed", "all": "always"}.get(campaign.spec.logs, "never")


def wanted_logs(campaign: Campaign, rows: Mapping[int, Row]) -> list[int]:
    """Flights that keep their log by the policy."""
    policy, flown = campaign.spec.logs, [row for row in rows.values() if row["status"] in FLOWN]
    kept = {"none": [], "failures": [row for row in flown if row["status"] in BROKEN_OFF], "all": flown}
    chosen = kept[policy] if policy in kept else worst(campaign, flown, log_limit(policy) or 0)
    return sorted(row["flight"] for row in chosen)


def worst(campaign: Campaign, rows: Iterable[Row], count: int) -> list[Row]:
    """The worst flights first: losses, then those that were no success, then by the spec's `score`."""
    score = campaign.spec.scores[campaign.spec.score]

    def order(row: Row) -> tuple[int, float, int]:
        if row["status"] in LOST:
            return 0, 0.0, row["flight"]
        value = row[score.name]
        bad = float("-inf") if value is None else -score.sign * value
        return (2 if is_success(campaign, row) else 1), bad, row["flight"]

    return sorted((row for row in rows if row["status"] != REFUSED), key=order)[:count]
