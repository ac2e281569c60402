"""Reads a campaign's spec from its TOML file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from skylimb.base.config import from_mapping, read_toml
from skylimb.base.errors import ConfigError, unknown_name
from skylimb.studies.campaign.spec import CampaignSpec

FROZEN = "frozen"
"""The table that a campaign's folder adds to its copy of the spec; see `skylimb.studies.campaign.frozen`."""


def load_spec(path: str | Path) -> CampaignSpec:
    """Read a campaign's TOML; files that it names are looked for beside it, wherever one is later.

    Raises:
        ConfigError: naming the key that is unknown, missing or of the wrong kind.
    """
    path = Path(path)
    return spec_from_mapping(read_toml(path), f"campaign {path.name}", path.parent.resolve())


def spec_from_mapping(mapping: Mapping[str, Any], where: str, folder: Path | None = None) -> CampaignSpec:
    """A spec from nested tables, every key checked.

    Args:
        mapping: as TOML gives it. In `set` and `vary`, `surface.friction` may be one key or nested tables.
        where: the source, for messages.
        folder: where the files that it names lie; None takes their paths as they stand.
    """
    tables = {key: value for key, value in mapping.items() if key != FROZEN}
    if isinstance(tables.get("set"), dict):
        tables["set"] = _flat(tables["set"], lambda table: False)
    if isinstance(tables.get("vary"), dict):
        tables["vary"] = _flat(tables["vary"], _is_distribution)
        for key, value in tables["vary"].items():
            if not isinstance(value, dict):
                raise ConfigError(
                    f"{where}: vary.'{key}' = {value!r} must be a table such as {{ uniform = [0.1, 0.8] }}"
                )
    use = tables.get("use")
    if isinstance(use, list) and all(isinstance(file, str) for file in use):
        tables["use"] = [file if folder is None else _beside(folder, file) for file in use]
    spec = from_mapping(CampaignSpec, tables, where)
    names = [Path(name).stem for name in spec.controllers]
    for key, owners in spec.only.items():
        for owner in owners:
            if owner not in names:
                raise unknown_name(f"controller of only.'{key}'", owner, names)
    if folder is not None:
        controllers = tuple(_beside(folder, name) for name in spec.controllers)
        spec = replace(spec, experiment=_beside(folder, spec.experiment), controllers=controllers)
    return spec if spec.draws else replace(spec, draws=spec.cells)


def _beside(folder: Path, name: str) -> str:
    is_file = name.endswith((".toml", ".py"))
    return (folder / name).as_posix() if is_file else name


def _is_distribution(table: Mapping[str, Any]) -> bool:
    """Whether a table describes a distribution; a table of tables leads to further keys."""
    return not table or any(not isinstance(value, dict) for value in table.values())


def _flat(
    table: Mapping[str, Any], is_leaf: Callable[[Mapping[str, Any]], bool], path: str = ""
) -> dict[str, Any]:
    """Nested tables as one table of dotted keys; a table that `is_leaf` is a value."""
    found: dict[str, Any] = {}
    for key, value in table.items():
        dotted = f"{path}.{key}" if path else key
        found |= (
            _flat(value, is_leaf, dotted)
            if isinstance(value, dict) and not is_leaf(value)
            else {dotted: value}
        )
    return found
