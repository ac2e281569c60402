"""The result as reproduction.json."""

from __future__ import annotations

import math

from skylimb.analysis.scores.registry import SCORES
from skylimb.base.config import to_mapping
from skylimb.studies.campaign.frozen import Campaign
from skylimb.studies.campaign.statistics import LEVEL
from skylimb.studies.campaign.summary import json_text
from skylimb.studies.reproduction.prior import Prior
from skylimb.studies.reproduction.result import HIGH, LOW, Result

FORMAT_VERSION = 1
DIGITS = 6
"""Significant digits of the file's numbers: enough to compare, and the file stays small."""


def command(draws: int) -> str:
    """The command that makes the result."""
    return f"skylimb reproduce --draws {draws} --out DIR"


def result_json(prior: Prior, campaign: Campaign, result: Result) -> str:
    """The file's text; numbers that are not there are null."""
    content = {
        "format": FORMAT_VERSION,
        "command": command(result.draws),
        "draws": result.draws,
        "flights": result.flights,
        "interval": [LOW, HIGH],
        "confidence": LEVEL,
        "inside": {
            "count": result.inside,
            "of": sum(math.isfinite(number.paper) for number in result.numbers),
        },
        "numbers": [
            {
                "controller": number.controller,
                "metric": number.key,
                "unit": SCORES[number.key].unit,
                "paper": number.paper,
                **number.ours._asdict(),
                "percentile": number.percentile,
                "inside": number.inside if math.isfinite(number.paper) else None,
                "by_reading": {value: spread._asdict() for value, spread in number.split.items()},
            }
            for number in result.numbers
        ],
        "ratios": [
            {
                "metric": ratio.key,
                "first": ratio.first,
                "second": ratio.second,
                "paper": ratio.paper,
                **ratio.ours._asdict(),
                "percentile": ratio.percentile,
                "inside": ratio.inside,
            }
            for ratio in result.ratios
        ],
        "claims": [
            {
                "name": judged.claim.name,
                "section": judged.claim.section,
                "text": judged.claim.text,
                "formula": judged.claim.formula,
                "all_draws": judged.rate._asdict(),
                "draws_without_loss": judged.finished._asdict(),
                "true_of_the_printed_numbers": judged.paper,
                "by_reading": {value: rate._asdict() for value, rate in judged.split.items()},
            }
            for judged in result.claims
        ],
        "failures": {
            name: {"count": sum(causes.values()), "causes": causes}
            for name, causes in result.failures.items()
        },
        "refused": {str(index): cause for index, cause in result.refused.items()},
        "sensitivity": {
            f"{name}.{key}": correlations for (name, key), correlations in result.sensitivity.items()
        },
        "nearest": [near._asdict() for near in result.nearest],
        "prior": {
            "sha256": prior.digest,
            "unknowns": [
                {
                    "key": unknown.key,
                    **to_mapping(unknown.distribution),
                    "controllers": list(unknown.controllers),
                    "reason": unknown.reason,
                }
                for unknown in prior.unknowns
            ],
            "kept": [vars(entry) for entry in prior.kept],
        },
        "versions": campaign.versions,
    }
    return json_text(content, 1, DIGITS)
