"""Which versions produced a run: part of every record, so that a result can be traced and repeated."""

from __future__ import annotations

import platform
from functools import cache
from importlib import metadata

PACKAGES = ("skylimb", "mujoco", "casadi", "numpy", "scipy", "xarray", "h5netcdf")
"""The packages whose version can change a run or how its record is read."""


@cache
def _versions() -> tuple[tuple[str, str], ...]:
    found = [("python", platform.python_version()), ("platform", f"{platform.system()} {platform.machine()}")]
    for package in PACKAGES:
        try:
            found.append((package, metadata.version(package)))
        except metadata.PackageNotFoundError:
            found.append((package, "not installed"))
    return tuple(found)


def versions() -> dict[str, str]:
    """Versions of this package, of Python and of what it computes with, and the kind of machine.

    Nothing is imported for it, and nothing in it names a user, a host or a path.
    """
    return dict(_versions())
