"""Every file that produced a flight, as it goes into the folder of its run."""

from __future__ import annotations

import hashlib
import inspect
import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from skylimb.analysis.recording.origin import SOURCES
from skylimb.base.errors import UnreadableError
from skylimb.base.keys import files_of
from skylimb.base.sources import Source, read_source
from skylimb.base.user_modules import sources_of_module, unnamed_files
from skylimb.control.cascade import Cascade
from skylimb.control.controller import Controller
from skylimb.control.laws.slots import SLOTS, Slot
from skylimb.control.laws.user_controller import UserController
from skylimb.control.planning.vectoring import vectoring_file
from skylimb.flight.plan import FlightPlan
from skylimb.robots.model import Robot

_USED = "use"
"""Key of a bundle with metrics; no key of the configuration."""

_FARTHEST = 3
"""Folders above the first file of a bundle in which the others may lie."""


@dataclass(frozen=True)
class RunFiles:
    """What a run's folder has of the files that it was flown with.

    Attributes:
        files: place in the folder -> content.
        places: dotted key of the configuration -> place of the file that it names.
        problems: why the run cannot be flown again from its folder, one line each.
        used: places of the files with metrics and figures of the user.
    """

    files: Mapping[str, bytes]
    places: Mapping[str, str]
    problems: tuple[str, ...] = ()
    used: tuple[str, ...] = ()


def run_files(plan: FlightPlan) -> RunFiles:
    """The copies of every user's file that a flight depends on; what comes with skylimb is not among them."""
    files: dict[str, bytes] = {}
    places: dict[str, str] = {}
    used: list[str] = []
    problems = not_repeatable(plan.controller)
    for key, bundle in _bundles(plan):
        if not bundle or bundle[0].shipped:
            continue
        root, first = _root(bundle), bundle[0].path
        if key and key != _USED:
            problems += unnamed_files(first)
        if root is None:
            problems.append(f"{key}: '{first.name}' needs files that lie far from it")
            root = first.parent
        inside = {
            source.path.relative_to(root).as_posix(): source
            for source in bundle
            if source.path.is_relative_to(root)
        }
        called = first.parent.name if key == "robot" else first.stem
        folder = f"{SOURCES}/{called}-{_digest(inside)}"
        files |= {f"{folder}/{name}": source.content for name, source in inside.items()}
        place = f"{folder}/{next(iter(inside))}"
        if key == _USED:
            used.append(place)
        elif key:
            places[key] = place
    return RunFiles(files, places, tuple(problems), tuple(used))


def _bundles(plan: FlightPlan) -> Iterator[tuple[str, tuple[Source, ...]]]:
    """Files that belong together, the one that is named first, and the dotted key that names it.

    The key is empty for files that are only kept, such as TOML files that a user named: the run's
    configuration has all their values. Functions that a script handed over come from no file.
    """
    for key, owner in files_of(plan.experiment):
        yield key, _robot_files(plan.robot, plan.needs.vectoring) if key == "robot" else owner.sources
    for name, slot in _laws(plan.controller):
        yield f"controller.{name}.law", getattr(slot.law, "sources", ())
    yield "controller.file", getattr(plan.controller, "sources", ())
    yield "", _code_of(plan.controller)
    for module in dict.fromkeys(sys.modules.get(one.function.__module__) for one in plan.own):
        yield _USED, sources_of_module(module)
    yield from (("", (source,)) for source in plan.originals)


def _laws(controller: Controller) -> list[tuple[str, Slot]]:
    """The filled slots of a cascade by name; none of another controller."""
    return list(zip(SLOTS, controller.preset.slots, strict=True)) if isinstance(controller, Cascade) else []


def not_repeatable(controller: Controller) -> list[str]:
    """Why a controller cannot be made again from its files, one line each."""
    if isinstance(controller, Cascade):
        return [
            f"the {name} law '{slot.name}' was handed over as an object, not as a file"
            for name, slot in _laws(controller)
            if not getattr(slot.law, "sources", ()) and not _is_ours(slot.law)
        ]
    if getattr(controller, "sources", ()):
        odd = controller.unrepeatable if isinstance(controller, UserController) else ""
        return [odd] if odd else []
    code = _code_of(controller)
    kept = f"a copy of {code[0].path.name} is kept" if code else "its class stands in no file"
    changed = controller.changed if isinstance(controller, UserController) else ""
    spent = f"; it has changed its own '{changed}', with which its next flight begins" if changed else ""
    return [
        f"controller '{controller.name}' was handed over as an object, and how it was made is not known "
        f"({kept}){spent}; a Python file with controller(robot) can be flown again"
    ]


def _is_ours(law: Any) -> bool:
    name = getattr(law, "__name__", "") if inspect.ismodule(law) else type(law).__module__
    return name.partition(".")[0] == "skylimb"


def _code_of(controller: Controller) -> tuple[Source, ...]:
    """The files of the class of a controller at hand; none for a class that was typed into a console."""
    kind = type(getattr(controller, "made", controller))
    if kind.__module__.partition(".")[0] == "skylimb" or getattr(controller, "sources", ()):
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


def _digest(files: Mapping[str, Source]) -> str:
    listed = "".join(f"{name}\0{source.digest}\0" for name, source in files.items())
    return hashlib.sha256(listed.encode()).hexdigest()[:8]
