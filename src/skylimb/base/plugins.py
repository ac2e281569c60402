"""What installed packages add: entry points of the groups `skylimb.laws`, `skylimb.robots` and their like.

    [project.entry-points."skylimb.laws"]
    "translation.spring" = "my_package.laws.spring"            # the file my_package/laws/spring.py

An entry point names a file of its package, which serves wherever a user could name a file of his own: it is
checked, flown, recorded and copied into a run's folder as that would be. Nothing of a package is imported
before one of its names is used, so a package that is broken costs its own names and nothing else.
"""

from __future__ import annotations

import functools
import importlib.util
import sys
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path

from skylimb.base.errors import ConfigError

GROUPS = {
    "laws": (".py",),
    "controllers": (".toml", ".py"),
    "robots": ("/flight.toml",),
    "surfaces": (".py",),
    "experiments": (".toml",),
    "metrics": (".py",),
}
"""What packages may add, and how the files of each end. A law's name begins with its slot's."""


def added_names(group: str, prefix: str = "") -> list[str]:
    """The names that packages add to a group.

    Args:
        group: a key of `GROUPS`.
        prefix: that names have to begin with; it is left out.
    """
    names = {entry.name for entry in _entries(group, tuple(sys.path)) if entry.name.startswith(prefix)}
    return sorted(name.removeprefix(prefix) for name in names)


def added_file(group: str, name: str, ships: bool) -> Path | None:
    """The file that a package adds under a name; None where none adds it, and where skylimb has it itself.

    Args:
        group: a key of `GROUPS`.
        name: of the entry point.
        ships: whether skylimb has that name too; it keeps it then.

    Raises:
        ConfigError: when the name is not its package's alone, or the package has no such file.
    """
    found = [] if ships else [entry for entry in _entries(group, tuple(sys.path)) if entry.name == name]
    if len(found) > 1:
        owners = " and by ".join(map(_package, found))
        raise ConfigError(f"skylimb.{group}: '{name}' is added by {owners}; only one may")
    return _file(found[0], group) if found else None


def added_by(group: str, name: str) -> str:
    """Which package adds a name, or why it cannot be used."""
    try:
        added_file(group, name, ships=False)
    except ConfigError as error:
        return f"not usable: {error}"
    return next(_package(entry) for entry in _entries(group, tuple(sys.path)) if entry.name == name)


@functools.lru_cache(maxsize=32)
def _entries(group: str, path: tuple[str, ...]) -> tuple[EntryPoint, ...]:
    """A group's entry points on Python's path, which is searched anew where it has changed."""
    del path
    return tuple(entry_points(group=f"skylimb.{group}"))


def _package(entry: EntryPoint) -> str:
    return f"{entry.dist.name} {entry.dist.version}" if entry.dist else entry.value


def _file(entry: EntryPoint, group: str) -> Path:
    """The file that an entry point names, found without the package being imported."""
    top, *rest = entry.value.split(".")
    try:
        spec = importlib.util.find_spec(top)
    except (ImportError, ValueError):
        spec = None
    places = [Path(place).joinpath(*rest) for place in (spec and spec.submodule_search_locations) or ()]
    if spec and spec.origin and not rest:  # a module by itself
        places.append(Path(spec.origin).with_suffix(""))
    files = [Path(f"{place}{ending}") for place in places for ending in GROUPS[group]]
    file = next((file for file in files if file.is_file()), None)
    if file is None:
        endings = " or ".join(GROUPS[group])
        raise ConfigError(
            f"skylimb.{group}: '{entry.name}' of package {_package(entry)} should name a file that ends in "
            f"{endings}, as in my_package.name; '{entry.value}' names none"
        )
    return file
