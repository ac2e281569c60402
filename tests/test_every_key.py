"""Every configuration class of the package: each key says what it is, and refuses what makes no sense."""

import dataclasses
import importlib
import pkgutil
from collections.abc import Iterator
from typing import Any

import pytest

import skylimb
from skylimb.base.config import from_mapping
from skylimb.base.errors import ConfigError
from skylimb.base.keys import REQUIRED, is_configuration, keys_of
from skylimb.base.keys.fields import entry_section, fields_of, has_numbers, members_of, section_of
from skylimb.control.laws.preset import SLOTS, find_law, law_names
from skylimb.flight.experiments.experiment import Settings
from skylimb.robots.flight_file import FlightFile
from skylimb.simulation.surfaces import SURFACES

UNITS = {
    "", "1/(N m)", "1/N", "1/m", "1/s", "1/s^2", "1/s^3", "1/s^4", "A", "Hz", "J", "N", "N m", "N m/A",
    "N m s", "N m/rad", "N m s/rad", "N s", "N s/m", "N s^2", "N/m", "N/s", "N^2/rad^2", "V", "kg",
    "kg m^2", "m", "m/N", "m^2", "m/s", "m/s^2", "m/s^3", "rad", "rad/N", "rad/rad", "rad/s", "rad^2", "s",
}  # fmt: skip


def _configurations() -> Iterator[type]:
    for module in pkgutil.walk_packages(skylimb.__path__, "skylimb."):
        if not module.name.endswith("__main__"):
            for thing in vars(importlib.import_module(module.name)).values():
                if is_configuration(thing) and thing.__module__ == module.name:
                    yield thing


CONFIGURATIONS = sorted(set(_configurations()), key=lambda cls: f"{cls.__module__}.{cls.__name__}")
LAWS = [find_law(slot, law, None).Gains for slot in SLOTS for law in law_names(slot)]  # type: ignore[arg-type]
ROOTS = [Settings, FlightFile, *SURFACES.values(), *LAWS]

each = pytest.mark.parametrize("cls", CONFIGURATIONS, ids=lambda cls: f"{cls.__module__}.{cls.__name__}")


def _inside(cls: type) -> Iterator[type]:
    yield cls
    for kind, key in fields_of(cls).values():
        part = section_of(kind) or entry_section(kind)
        if key is None and part is not None:
            yield from _inside(part)


@each
def test_a_key_has_a_unit_that_exists_a_meaning_and_a_range(cls: type) -> None:
    for name, info in keys_of(cls).items():
        assert info.unit in UNITS, name
        assert info.meaning, name
        assert not info.meaning.endswith("."), name
        assert not has_numbers(info.type) or info.key.bounded, name


@each
def test_a_configuration_says_what_it_is_and_leaves_its_keys_to_speak_for_themselves(cls: type) -> None:
    assert cls.__doc__
    assert "Attributes:" not in cls.__doc__
    assert not cls.__doc__.startswith(f"{cls.__name__}(")


@pytest.mark.parametrize("root", ROOTS, ids=lambda cls: f"{cls.__module__}.{cls.__name__}")
def test_what_files_are_read_into_has_keys_throughout(root: type) -> None:
    for cls in _inside(root):
        assert is_configuration(cls), f"{cls.__module__}.{cls.__name__}"
        for name, info in keys_of(cls).items():
            assert info.default is REQUIRED or info.default is None or not _wrong(cls, name, info.default)


def _wrong(cls: type, name: str, value: Any) -> bool:
    try:
        fields = {field.name for field in dataclasses.fields(cls)}  # type: ignore[arg-type]
        if name in fields:
            from_mapping(cls, {name: value}, "default")
    except ConfigError as error:
        return "is missing" not in str(error) and f"{name} = " in str(error)
    return False


def _too_much() -> Iterator[tuple[str, Any]]:
    for key, info in keys_of(Settings).items():
        kinds = members_of(info.type)
        if "<" not in key and (float in kinds or int in kinds):
            yield key, 10**400 if int in kinds else 1e308


@pytest.mark.parametrize(("key", "value"), [*_too_much(), ("phases.tare", 1e6), ("phases.settle", 1e308)])
def test_no_number_of_an_experiment_is_without_bounds(key: str, value: Any) -> None:
    table: Any = value
    for name in reversed(key.split(".")):
        table = {name: table}
    with pytest.raises(ConfigError) as caught:
        from_mapping(Settings, table, "mine.toml")
    assert str(caught.value).startswith(f"mine.toml: {key} = ")
    assert len(str(caught.value)) < 160
