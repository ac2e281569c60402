"""Reads a campaign's spec from its TOML file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from skylimb.campaign.distributions import Distribution, Grid, distribution, is_distribution
from skylimb.campaign.spec import FROZEN, CampaignSpec, PlainSpec
from skylimb.config import from_mapping, read_toml
from skylimb.errors import ConfigError, unknown_name


def load_spec(path: str | Path) -> CampaignSpec:
    """Read a campaign's TOML; files that it names are looked for beside it.

    Raises:
        ConfigError: naming the key that is unknown, missing or of the wrong kind.
    """
    path = Path(path)
    return spec_from_mapping(read_toml(path), f"campaign {path.name}", path.parent)


def spec_from_mapping(mapping: Mapping[str, Any], where: str, folder: Path | None = None) -> CampaignSpec:
    """A spec from nested tables, every key checked.

    Args:
        mapping: as TOML gives it.
        where: the source, for messages.
        folder: where the files that it names lie; None takes their paths as they stand.
    """
    tables = {key: value for key, value in mapping.items() if key != FROZEN}
    vary = tables.pop("vary", {})
    for key in tables:
        if key not in PlainSpec.__dataclass_fields__:
            raise unknown_name(f"key of {where}", key, [*PlainSpec.__dataclass_fields__, "vary"])
    if not isinstance(vary, dict):
        raise ConfigError(f"{where}: vary = {vary!r} should be a table")
    if "set" in tables and isinstance(tables["set"], dict):
        tables["set"] = _flat(tables["set"])
    plain = from_mapping(PlainSpec, tables, where)
    try:
        varied = {key: distribution(key, table) for key, table in _distributions(vary, "")}
        values = {name: getattr(plain, name) for name in PlainSpec.__dataclass_fields__}
        if folder is not None:
            values["experiment"] = _beside(folder, plain.experiment)
            values["controllers"] = tuple(_beside(folder, name) for name in plain.controllers)
        if not values["draws"] and varied and all(isinstance(entry, Grid) for entry in varied.values()):
            count = 1
            for entry in varied.values():
                count *= len(entry.extremes())
            values["draws"] = count
        for key in varied:
            if key in values["set"]:
                raise ConfigError(f"'{key}' stands both in set and in vary")
        _check_only(plain.only, varied, values["controllers"])
        return CampaignSpec(**values, vary=varied)
    except ConfigError as error:
        raise type(error)(f"{where}: {error}") from None


def _check_only(
    only: Mapping[str, tuple[str, ...]], varied: Mapping[str, Distribution], controllers: tuple[str, ...]
) -> None:
    names = [Path(name).stem for name in controllers]
    for key, owners in only.items():
        if key not in varied or not key.startswith("controller."):
            raise unknown_name("varied gain in only", key, [k for k in varied if k.startswith("controller.")])
        for owner in owners:
            if owner not in names:
                raise unknown_name(f"controller of only.'{key}'", owner, names)


def _beside(folder: Path, name: str) -> str:
    is_file = name.endswith((".toml", ".py"))
    return (folder / name).as_posix() if is_file else name


def _flat(table: Mapping[str, Any], path: str = "") -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, value in table.items():
        dotted = f"{path}.{key}" if path else key
        found |= _flat(value, dotted) if isinstance(value, dict) else {dotted: value}
    return found


def _distributions(table: Mapping[str, Any], path: str) -> list[tuple[str, dict[str, Any]]]:
    """Every distribution under its dotted key; `surface.friction = {...}` may be written without quotes."""
    found: list[tuple[str, dict[str, Any]]] = []
    for key, value in table.items():
        dotted = f"{path}.{key}" if path else key
        if is_distribution(value):
            found.append((dotted, value))
        elif isinstance(value, dict) and value:
            if all(not isinstance(entry, dict) for entry in value.values()):
                found.append((dotted, value))
            else:
                found += _distributions(value, dotted)
        else:
            raise ConfigError(
                f"vary.'{dotted}' = {value!r} must be a table such as {{ uniform = [0.1, 0.8] }}"
            )
    return found
