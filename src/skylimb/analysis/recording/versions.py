"""Which versions produced a run: part of every record, so that a result can be traced and repeated."""

from __future__ import annotations

import hashlib
import platform
from functools import cache
from importlib import metadata
from pathlib import Path

PACKAGES = ("skylimb", "mujoco", "casadi", "numpy", "scipy", "xarray", "h5py")
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


@cache
def code_digest() -> str:
    """Digest of this package's own code and data, 12 digits; its version changes only with a release."""
    package, total = Path(__file__).parents[2], hashlib.sha256()
    kinds = (".py", ".c", ".h", ".toml", ".urdf")
    for path in sorted(path for path in package.rglob("*") if path.suffix in kinds):
        total.update(path.relative_to(package).as_posix().encode() + b"\0")
        total.update(path.read_bytes().replace(b"\r\n", b"\n") + b"\0")
    return total.hexdigest()[:12]


@cache
def _c_library() -> str:
    return " ".join(platform.libc_ver()).strip() or "none"


def computing_versions() -> dict[str, str]:
    """`versions` and this package's code: what decides the bits of a flight on any machine."""
    return {**versions(), "skylimb_code": code_digest()}


def origin_versions() -> dict[str, str]:
    """Everything that decides the bits of a run: `computing_versions`, and the C library."""
    return {**computing_versions(), "c_library": _c_library()}
