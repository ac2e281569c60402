"""A campaign's Python files of the user's: metrics, controllers and laws."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from skylimb.analysis.scores.user_scores import metric_file
from skylimb.control.laws.preset import law_folder
from skylimb.control.laws.slots import SLOTS, law_file
from skylimb.studies.campaign.digests import code_digest, one_digest
from skylimb.studies.campaign.draws import GAIN
from skylimb.studies.campaign.spec import CampaignSpec


def code_files(
    use: Iterable[str], controllers: Mapping[str, Mapping[str, Any]], spec: CampaignSpec
) -> list[Path]:
    """The user's Python files of a campaign's metrics, controllers and laws."""
    found = [metric_file(file) for file in use]
    for entry in controllers.values():
        path, preset = Path(entry["path"]), entry.get("preset")
        if preset is None:
            found.append(path)
        elif "code" in entry:
            found += [file for s in SLOTS for file in _law_files(s, preset.get(s), path, spec)]
    return found


def law_digests(preset: Mapping[str, Any], path: Path, spec: CampaignSpec) -> dict[str, str]:
    """Digest of the user's laws in each slot that has any."""
    return {
        slot: one_digest([code_digest(file) for file in files])
        for slot in SLOTS
        if (files := _law_files(slot, preset.get(slot), path, spec))
    }


def _law_files(slot: str, table: Any, preset: Path, spec: CampaignSpec) -> list[Path]:
    """The user's files of the laws that draws fly in a slot: those that are drawn, else the preset's own."""
    key = f"{GAIN}{slot}.law"
    drawn = key in spec.vary and preset.stem in spec.only.get(key, (preset.stem,))
    own = [table["law"]] if isinstance(table, dict) and "law" in table else []
    laws = spec.vary[key].extremes() if drawn else own
    files = (law_file(slot, str(name), law_folder(preset)) for name in laws)
    return [file for file in files if file is not None]
