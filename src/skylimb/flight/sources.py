"""Every file that produced a flight, as it goes into the folder of its run."""

from __future__ import annotations

import hashlib
import inspect
import os
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skylimb.analysis.recording.origin import SOURCES
from skylimb.analysis.scores.user_scores import UserScore
from skylimb.base.errors import UnreadableError
from skylimb.base.keys import files_of
from skylimb.base.sources import Source, read_source
from skylimb.base.user_modules import sources_of_module
from skylimb.control.controller import Controller
from skylimb.control.needs import needs_of
from skylimb.control.planning.vectoring import vectoring_file
from skylimb.control.slots import SLOTS
from skylimb.robots.model import Robot

if TYPE_CHECKING:
    from skylimb.flight.plan import FlightPlan

_USED = "use"
"""Key of a bundle with metrics; no key of the configuration."""

_FARTHEST = 3
"""Folders above the first file of a bundle in which the others may lie."""


@dataclass(frozen=True)
class Bundle:
    """Files that belong together.

    Attributes:
        key: dotted key of the configuration that names the first; empty for files that are only kept.
        files: the first is the one that is named.
    """

    key: str
    files: tuple[Source, ...]


@dataclass(frozen=True)
class Kept:
    """What a run's folder keeps of its files.

    Attributes:
        files: place in the folder -> content.
        places: dotted key of the configuration -> place of the file that it names.
        problems: why the run cannot be flown again from its folder, one line each.
        used: places of the files with metrics and figures of the user's own.
    """

    files: Mapping[str, bytes]
    places: Mapping[str, str]
    problems: tuple[str, ...] = ()
    used: tuple[str, ...] = ()


def kept_sources(plan: FlightPlan) -> Kept:
    """The copies of every user's file that a flight depends on; what comes with skylimb is not among them."""
    files: dict[str, bytes] = {}
    places: dict[str, str] = {}
    used: list[str] = []
    problems = list(_controller_problems(plan.controller))
    for bundle in (*_bundles(plan), *_metric_bundles(plan.own), *plan.originals):
        if not bundle.files or bundle.files[0].shipped:
            continue
        root = _root(bundle.files)
        if root is None:
            first = bundle.files[0].path.name
            problems.append(f"{bundle.key}: '{first}' needs files that lie far from it")
            root = bundle.files[0].path.parent
        inside = [source for source in bundle.files if source.path.is_relative_to(root)]
        names = [source.path.relative_to(root).as_posix() for source in inside]
        first = bundle.files[0].path
        called = first.parent.name if bundle.key == "robot" else first.stem
        folder = f"{SOURCES}/{called}-{_digest(names, inside)}"
        files |= {f"{folder}/{name}": source.content for name, source in zip(names, inside, strict=True)}
        if bundle.key == _USED:
            used.append(f"{folder}/{names[0]}")
        elif bundle.key:
            places[bundle.key] = f"{folder}/{names[0]}"
    return Kept(files, places, tuple(problems), tuple(used))


def originals(experiment: Any, controller: Any) -> tuple[Bundle, ...]:
    """The TOML files that a user named, for people to read: the run's configuration has all their values."""
    names = [name for name in (experiment, controller) if isinstance(name, str) and name.endswith(".toml")]
    return tuple(Bundle("", (read_source(name),)) for name in names)


def _bundles(plan: FlightPlan) -> Iterator[Bundle]:
    for key, owner in files_of(plan.experiment):
        if key == "robot":
            yield Bundle(key, _robot_files(plan.robot, needs_of(plan.controller).vectoring))
        else:
            yield Bundle(key, owner.sources)
    yield from _controller_bundles(plan.controller)


def _metric_bundles(own: Sequence[UserScore]) -> Iterator[Bundle]:
    """The files of metrics and figures; none of functions that a script handed over."""
    modules = dict.fromkeys(sys.modules.get(one.function.__module__) for one in own)
    for module in modules:
        yield Bundle(_USED, sources_of_module(module))


def _controller_bundles(controller: Controller) -> Iterator[Bundle]:
    preset, sources = getattr(controller, "preset", None), getattr(controller, "sources", ())
    if preset is not None:
        for name, slot in zip(SLOTS, preset.slots, strict=True):
            yield Bundle(f"controller.{name}.law", getattr(slot.law, "sources", ()))
    elif sources:
        yield Bundle("controller.file", sources)
    else:
        yield Bundle("", _code_of(controller))


def _controller_problems(controller: Controller) -> Iterator[str]:
    """Why a controller cannot be made again from what the run's folder has."""
    preset = getattr(controller, "preset", None)
    if preset is not None:
        for name, slot in zip(SLOTS, preset.slots, strict=True):
            if not getattr(slot.law, "sources", ()) and not _is_ours(slot.law):
                yield f"the {name} law '{slot.name}' was handed over as an object, not as a file"
    elif not getattr(controller, "sources", ()):
        code = _code_of(controller)
        kept = f"a copy of {code[0].path.name} is kept" if code else "its class stands in no file"
        yield (
            f"controller '{controller.name}' was handed over as an object, and how it was made is not known "
            f"({kept}); a Python file with controller(robot) can be flown again"
        )


def _is_ours(law: Any) -> bool:
    name = getattr(law, "__name__", "") if inspect.ismodule(law) else type(law).__module__
    return name.partition(".")[0] == "skylimb"


def _code_of(controller: Controller) -> tuple[Source, ...]:
    """The files that an object's class comes from; none for a class that was typed into a console."""
    kind = type(getattr(controller, "made", controller))
    if kind.__module__.partition(".")[0] == "skylimb":
        return ()
    known = sources_of_module(sys.modules.get(kind.__module__))
    if known:
        return known
    try:
        return (read_source(inspect.getsourcefile(kind) or ""),)
    except (TypeError, OSError, UnreadableError):
        return ()


def _robot_files(robot: Robot, purpose: str) -> tuple[Source, ...]:
    """Flight TOML, URDF, meshes, and the vectoring angles, which would be searched anew."""
    description = robot.description
    if not description.sources or description.sources[0].shipped:
        return ()
    meshes = {visual.mesh for link in description.links for visual in link.visuals if visual.mesh is not None}
    table = vectoring_file(robot, purpose)
    beside = () if table is None else (Source(description.folder / table[0], table[1].encode()),)
    return (*description.sources, *map(read_source, sorted(meshes)), *beside)


def _root(files: Sequence[Source]) -> Path | None:
    """The folder that has all of the files; None where it lies too far up."""
    home = files[0].path.parent
    try:
        root = Path(os.path.commonpath([source.path.parent for source in files]))
    except ValueError:  # on different drives
        return None
    return root if len(home.relative_to(root).parts) < _FARTHEST else None


def _digest(names: Iterable[str], files: Iterable[Source]) -> str:
    total = hashlib.sha256()
    for name, source in zip(names, files, strict=True):
        total.update(f"{name}\0{source.digest}\0".encode())
    return total.hexdigest()[:8]
