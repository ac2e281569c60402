"""Whether the files of the user's that flights read are still those that a campaign was begun with."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from skylimb.analysis.scores.user_scores import metric_file
from skylimb.base.errors import ConfigError
from skylimb.flight.experiments.experiment import Experiment
from skylimb.robots.loader import load_robot
from skylimb.studies.campaign.code import law_digests
from skylimb.studies.campaign.digests import (
    changed_files,
    code_digest,
    file_digests,
    files_read,
)
from skylimb.studies.campaign.frozen import Campaign, possible


class Unchanged:
    """What the flights of a campaign may read.

    Args:
        campaign: that was begun, perhaps long ago or on another machine.

    Raises:
        ConfigError: when a robot, or a file that an experiment names, is another one now.
    """

    def __init__(self, campaign: Campaign) -> None:
        self._campaign = campaign
        self._require(
            campaign.robots, {name: load_robot(name).description.digest for name in campaign.robots}
        )
        experiments = possible(campaign) if campaign.files else []
        found = file_digests(experiments)
        self._require(campaign.files, {key: found.get(key) for key in campaign.files})
        self._files = files_read(experiments)

    def require(self, flown: Iterable[Experiment]) -> None:
        """Refuse flights that have read, or may have read, another file than the campaign was begun with.

        Args:
            flown: their experiments. They read files when they need them: what is the same after the flights
                was the same before.

        Raises:
            ConfigError: naming the file, or why it cannot be read any more.
        """
        spec, use = self._campaign.spec, self._campaign.use
        self._require(use, {file: code_digest(metric_file(file)) for file in use})
        for entry in self._campaign.controllers.values():
            if "code" in entry:
                path = Path(entry["path"])
                own = law_digests(entry["preset"], path, spec) if "preset" in entry else code_digest(path)
                self._require({entry["path"]: entry["code"]}, {entry["path"]: own})
        experiments = [*flown]
        for name in {one.robot for one in experiments}:
            known = load_robot(name).description.digest in self._campaign.robots.values()
            self._require({name: True}, {name: known})
        for key, digests in files_read(experiments).items():
            self._require({key: True}, {key: digests <= self._files.get(key, digests)})

    def _require(self, begun: Mapping[str, Any], now: Mapping[str, Any]) -> None:
        """Refuse the first name whose digest is another one now."""
        for name, digest in begun.items():
            if now[name] != digest:
                raise ConfigError(
                    f"what '{name}' names is another than when the campaign was begun"
                    f"{changed_files(self._campaign.read)}; rows of both would stand in one table. Take the "
                    "change back, and --resume goes on; or fly anew, into another folder"
                )
