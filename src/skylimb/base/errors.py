"""The one family of errors that a user's mistake can raise.

Every message names the thing, the value it had and what was allowed, on one line. The command line prints it
and exits with code 2; it never shows a traceback for one of these.
"""

from __future__ import annotations

import difflib
import importlib
import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any


class SkylimbError(Exception):
    """Base of every error that this package raises on purpose."""


class ConfigError(SkylimbError):
    """A configuration, preset or option that cannot be used: unknown key, wrong type, value out of range."""


class UnreadableError(ConfigError):
    """A file of the user's that is not there or cannot be read."""


class UnknownNameError(ConfigError):
    """A name that is not among those known: an experiment, controller, robot, key or signal."""


class UnknownKeyError(UnknownNameError, KeyError):
    """The same where a table was asked for the name, as in `run.metrics["eror"]`."""

    __str__ = Exception.__str__  # a KeyError's own shows its text in quotes


class UserCodeError(ConfigError):
    """An error in a user's own Python: a law, a controller, a path, a metric or a figure."""


class DescriptionError(SkylimbError):
    """A robot description that is incomplete or that no physical body can have."""


class UnreachableError(SkylimbError):
    """A pose or reach outside of what the robot's joints allow."""


class AllocationError(SkylimbError):
    """An allocation matrix that cannot produce the wanted wrench."""


class CompileError(SkylimbError):
    """C code that could not be compiled here: no compiler, or what it said."""


class OutputError(SkylimbError):
    """An output folder or file that exists already, or cannot be written or read."""


class MissingExtraError(SkylimbError):
    """A package that only one of the extras installs, and that is not here."""


EXTRAS = {
    "report": ("matplotlib", "jinja2", "PIL", "fontTools", "cycler"),
    "draw": ("svgelements", "HersheyFonts"),
    "studio": ("websockets",),
    "campaign": ("pyarrow", "scipy"),
    "cluster": ("dask", "distributed", "dask_jobqueue"),
    "import": ("yourdfpy", "trimesh", "xacrodoc", "collada"),
    "learn": ("gymnasium",),
    "logs": ("rosbags", "mcap", "lz4"),
    "ros": ("yaml",),
    "ros2": ("cyclonedds",),
    "tune": ("cma",),
    "video": ("av",),
}
"""Packages that an extra of skylimb installs, as Python imports them; SciPy comes with several."""

LAST_PYTHON = {"cyclonedds": (3, 13)}
"""The last Python that a package has wheels for, where there are later ones."""


def first_line(error: Exception) -> str:
    """The first line of what an error says, or its kind where it says nothing."""
    return (str(error).splitlines() or [type(error).__name__])[0]


def missing_extra(package: str) -> MissingExtraError:
    """An error that names a package of an extra, and the command that installs it.

    Args:
        package: as Python imports it.
    """
    here, last = sys.version_info[:2], LAST_PYTHON.get(package, sys.version_info[:2])
    if here > last:
        return MissingExtraError(
            f"'{package}' is not installed: it has wheels for Python {last[0]}.{last[1]} and older, "
            f"and this is {here[0]}.{here[1]}"
        )
    extra = next(extra for extra, packages in EXTRAS.items() if package in packages)
    return MissingExtraError(f"'{package}' is not installed: pip install 'skylimb[{extra}]'")


def of_an_extra(error: ImportError) -> MissingExtraError | None:
    """What to install where an import failed for want of an extra; None where something else is wrong."""
    package = (error.name or "").partition(".")[0]
    return missing_extra(package) if any(package in packages for packages in EXTRAS.values()) else None


@contextmanager
def of_extras() -> Iterator[None]:
    """An import inside of it that fails for want of an extra says what to install."""
    try:
        yield
    except ImportError as error:
        raise of_an_extra(error) or error from None


def extra_module(name: str) -> Any:
    """A module that only an extra installs.

    Args:
        name: as Python imports it.

    Raises:
        MissingExtraError: when it is not installed.
    """
    with of_extras():
        return importlib.import_module(name)


def nearest(name: str, known: Iterable[str]) -> str | None:
    """The known name most like `name`, or None when none is near; a very long one would take its time."""
    if len(name) > _LONG_NAME:
        return None
    others = [other for other in known if other != name]
    found = difflib.get_close_matches(name, others, n=1, cutoff=0.5)
    return found[0] if found else None


def did_you_mean(guess: str | None) -> str:
    """The end of a message that names what was meant; nothing where nothing is near."""
    return f"; did you mean '{guess}'?" if guess else ""


_LONG_NAME = 100
"""Letters of a wrong name that a message repeats."""


def unknown_name(kind: str, name: str, known: Iterable[str], endings: Iterable[str] = ()) -> UnknownNameError:
    """An error for `name`, with the nearest right name first and then all that are allowed.

    Args:
        kind: what the name should have named, for example "experiment".
        name: what was given.
        known: every name that would have been right.
        endings: of files that may be named as well; one that is there is the first guess.
    """
    known = sorted(set(known))
    files = [f"{name}{ending}" for ending in endings if os.path.isfile(f"{name}{ending}")]
    hint = did_you_mean(files[0] if files else nearest(name, known))
    listed = ", ".join(known or ["none"]) if len(known) <= 24 else f"{', '.join(known[:24])}, ..."
    name = name if len(name) <= _LONG_NAME else f"{name[:_LONG_NAME]}..."
    return UnknownNameError(f"unknown {kind} {name!r}{hint} (known: {listed})")


def unknown_key(kind: str, name: object, known: Iterable[str]) -> UnknownKeyError:
    """The same for a table that has no such entry: a KeyError as well, for whoever catches one."""
    return UnknownKeyError(str(unknown_name(kind, str(name), known)))


def choice_error(option: str, value: str, choices: Iterable[str]) -> ConfigError:
    """An error for the value of an option that must be one of some words."""
    known = list(choices)
    hint = did_you_mean(nearest(value, known))
    return ConfigError(f"{option} = '{value}' is not one of {', '.join(known)}{hint}")
