"""The declared prior: every unknown of the paper with its distribution and the reason for it."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from skylimb.base.config import read_toml, to_mapping
from skylimb.base.errors import ConfigError, unknown_name
from skylimb.studies.campaign.distributions import Distribution
from skylimb.studies.campaign.reading import spec_from_mapping
from skylimb.studies.campaign.spec import CampaignSpec

PRIOR = Path(__file__).with_name("prior.toml")
MEASURES = "paper"
"""The set of measures that the claims need."""

_TABLES = ("seed", "experiment", "controllers", "set", "unknown", "kept")


@dataclass(frozen=True)
class Unknown:
    """Something that the paper leaves open.

    Attributes:
        key: dotted key of the experiment, or of the controllers with "controller." before it.
        distribution: what it could have been.
        reason: why that and no narrower.
        controllers: whose gain it is; empty for all, or for the world.
    """

    key: str
    distribution: Distribution
    reason: str
    controllers: tuple[str, ...] = ()

    @property
    def words(self) -> str:
        """The distribution in words, as in the file."""
        (kind, value), *options = to_mapping(self.distribution).items()
        more = "".join(f", {name} {value_text(entry)}" for name, entry in options)
        return f"{kind.replace('_', ' ')} {value_text(value)}{more}"


@dataclass(frozen=True)
class Fixed:
    """Something that the paper leaves open as well, and that is the same in every draw."""

    name: str
    value: str
    reason: str


@dataclass(frozen=True)
class Prior:
    """A prior file.

    Attributes:
        unknowns: what varies.
        kept: what is open and does not vary.
        digest: SHA-256 of the file, by which a result names the prior that it was flown with.
    """

    unknowns: tuple[Unknown, ...]
    kept: tuple[Fixed, ...]
    digest: str
    _plain: dict[str, Any]

    def campaign(self, draws: int) -> CampaignSpec:
        """The ensemble as a campaign: all controllers fly every draw with the same seed."""
        vary = {unknown.key: to_mapping(unknown.distribution) for unknown in self.unknowns}
        only = {u.key: list(u.controllers) for u in self.unknowns if u.controllers}
        spec = {**self._plain, "draws": draws, "measures": [MEASURES], "only": only, "logs": "none"}
        return spec_from_mapping({**spec, "vary": vary}, "the prior")


def load_prior(path: Path = PRIOR) -> Prior:
    """Read a prior.

    Raises:
        ConfigError: where a key is unknown, a distribution cannot be used, or a reason is missing.
    """
    tables = read_toml(path)
    for key in tables:
        if key not in _TABLES:
            raise unknown_name(f"key of prior {path.name}", key, _TABLES)
    unknown, kept = tables.pop("unknown", {}), tables.pop("kept", {})
    for key, entry in {**unknown, **kept}.items():
        if not isinstance(entry.get("reason"), str) or not entry["reason"].strip():
            raise ConfigError(f"prior: unknown '{key}' has no reason; a range without one is a guess")
    vary = {
        key: {name: value for name, value in entry.items() if name not in ("reason", "controllers")}
        for key, entry in unknown.items()
    }
    spec = spec_from_mapping({**tables, "draws": 1, "vary": vary}, f"prior {path.name}")
    return Prior(
        tuple(
            Unknown(key, drawn, unknown[key]["reason"], tuple(unknown[key].get("controllers", ())))
            for key, drawn in spec.vary.items()
        ),
        tuple(Fixed(key, str(entry.get("value", "")), entry["reason"]) for key, entry in kept.items()),
        hashlib.sha256(path.read_bytes()).hexdigest(),
        tables,
    )


def value_text(value: Any) -> str:
    """A drawn value, or what it is drawn from."""
    if isinstance(value, list):
        return f"[{', '.join(map(value_text, value))}]"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
