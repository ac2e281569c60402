"""What an ensemble flies otherwise than the paper without having declared it unknown."""

from __future__ import annotations

from skylimb.analysis.paper.configuration import CONTROLLERS, Difference, differences
from skylimb.control.controller import resolved_tables
from skylimb.flight.experiments.experiment import robot_of
from skylimb.studies.campaign.frozen import Campaign
from skylimb.studies.reproduction.prior import Prior


def flown_otherwise(prior: Prior, campaign: Campaign) -> list[Difference]:
    """Keys that every draw has otherwise than the paper's configuration, apart from the prior's unknowns.

    Args:
        prior: what was drawn from.
        campaign: its ensemble.
    """
    drawn = campaign.draw(0)
    experiment = campaign.experiment_of(drawn)
    robot = robot_of(experiment)
    unknown = tuple(unknown.key for unknown in prior.unknowns)
    found: dict[str, Difference] = {}  # by words: controllers that differ alike are said once
    for name in campaign.names:
        if name in CONTROLLERS:
            gains = resolved_tables(campaign.load(name, robot))
            config = {**experiment.to_mapping(), "controller": gains}
            found |= {str(d): d for d in differences(config, name) if not d.key.startswith(unknown)}
    return list(found.values())
