"""What is asked of a new robot before it is written: what a URDF seldom says, each with a proposal."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from skylimb.apps.robot_import.checking import RobotReport, check_robot_file, flight_tables
from skylimb.apps.robot_import.mapping import Mapping as MappingFile
from skylimb.apps.robot_import.proposal import SPIN
from skylimb.base.config import from_mapping
from skylimb.base.errors import ConfigError, SkylimbError, unknown_name
from skylimb.robots.flight_file import FlightFile

_SAME_MASS = 0.02
"""Share of the mass that a scale may say otherwise."""
_NONE, _FORWARD = "none", ("x", "z")

Ask = Callable[[str, str], str]
"""Words, behind what was wrong with the last answer; and the proposal -> an answer, empty for the latter."""

Question = Callable[[RobotReport], tuple[str, str, Callable[[str], dict[str, Any]]]]
"""What was found so far -> words, proposal, and what an answer adds to the mapping file."""


def _mass(report: RobotReport) -> tuple[str, str, Callable[[str], dict[str, Any]]]:
    def take(answer: str) -> dict[str, Any]:
        said = _number("mass", answer)
        if abs(said - report.mass) > _SAME_MASS * report.mass:
            heaviest = max(report.description.links, key=lambda link: link.inertial.mass)
            raise ConfigError(
                f"mass = {said:g} kg, but the links of the file weigh {report.mass:.4g} kg together; correct "
                f"their <mass> first (the heaviest is '{heaviest.name}' with {heaviest.inertial.mass:g} kg)"
            )
        return {}

    return "What does it weigh, with its battery, kg?", f"{report.mass:.4g}", take


def _arm(report: RobotReport) -> tuple[str, str, Callable[[str], dict[str, Any]]]:
    shape = report.description.shape_joints

    def take(answer: str) -> dict[str, Any]:
        named = [] if answer == _NONE else answer.replace(",", " ").split()
        locked = [name for name in shape if name not in named]
        roles = [("shape", name) for name in named] + [("locked", name) for name in locked]
        return {"joints": [{"name": name, "role": role} for role, name in roles]} if roles else {}

    return f"Which joints bend it? Names, or '{_NONE}'.", " ".join(shape) or _NONE, take


def _tip(report: RobotReport) -> tuple[str, str, Callable[[str], dict[str, Any]]]:
    tip = _flight(report).tip
    place = " ".join(f"{float(part):g}" for part in tip.position)

    def take(answer: str) -> dict[str, Any]:
        link, *words = answer.replace(",", " ").split() or [""]
        forward = {"forward": words.pop()} if words and words[-1] in _FORWARD else {}
        if len(words) not in (0, 3):
            raise ConfigError(f"tip = '{answer}' must be a link, or a link and x y z in m, and x or z")
        position = [_number("tip", word) for word in words] or [0.0, 0.0, 0.0]
        return {"tip": {"link": link, "position": position, "radius": tip.radius, **forward}}

    words = "Which point touches? Its link, x y z there (m), and the axis that points out, x or z."
    return words, f"{tip.link} {place} {tip.forward or 'x'}", take


def _thrust(report: RobotReport) -> tuple[str, str, Callable[[str], dict[str, Any]]]:
    rotors = flight_tables(_flight(report))["rotors"]
    most = max(rotor["thrust_max"] for rotor in rotors)

    def take(answer: str) -> dict[str, Any]:
        share = _number("thrust", answer) / most
        return {"rotors": [{**rotor, "thrust_max": share * rotor["thrust_max"]} for rotor in rotors]}

    return "How much does its strongest rotor push at most, N?", f"{most:g}", take


def _spin(report: RobotReport) -> tuple[str, str, Callable[[str], dict[str, Any]]]:
    rotors = flight_tables(_flight(report))["rotors"]
    links = [rotor["link"] for rotor in rotors]

    def take(answer: str) -> dict[str, Any]:
        named = [] if answer == _NONE else answer.replace(",", " ").split()
        for name in named:
            if name not in links:
                raise unknown_name("rotor's link in spin", name, links)
        return {"rotors": [{**rotor, "spin": -1 if rotor["link"] in named else 1} for rotor in rotors]}

    words = f"Which rotors turn clockwise, seen against their thrust? Links, or '{_NONE}'."
    proposed = " ".join(rotor["link"] for rotor in rotors if rotor["spin"] < 0)
    return words, proposed or _NONE, take


def _flight(report: RobotReport) -> FlightFile:
    assert report.flight is not None  # a robot of another form is refused before
    return report.flight


QUESTIONS: Mapping[str, Question] = {
    "mass": _mass,
    "arm": _arm,
    "tip": _tip,
    "spin": _spin,
    "thrust": _thrust,
}
_IN_DOUBT = {"spin": SPIN}
"""Questions that are only asked where something is doubted, and what."""


def interview(
    path: str | Path,
    answers: Mapping[str, str],
    ask: Ask,
    packages: str | Path | None = None,
    args: Mapping[str, str] | None = None,
) -> Iterator[tuple[RobotReport, MappingFile]]:
    """What is known before each question and after the last, and what is said so far.

    An answer that cannot be is refused, and its question asked again: the others are not lost.

    Args:
        path: as of `check_robot_file`.
        answers: what is said already, by question; an empty one is asked.
        ask: called for the others.
        packages: as of `check_robot_file`.
        args: as of `check_robot_file`.

    Raises:
        SkylimbError: one of `answers` that cannot be, or a file that cannot be read.
    """

    def check(tables: dict[str, Any]) -> tuple[RobotReport, MappingFile]:
        said = from_mapping(MappingFile, tables, "the answers")
        return check_robot_file(path, packages, said, args=args), said

    tables: dict[str, Any] = {}
    report, said = check(tables)
    if report.flight is None:
        raise ConfigError(f"'{path}' is a robot of skylimb's form already; copy its folder")
    for name, question in QUESTIONS.items():
        yield report, said
        given, doubted = answers.get(name, ""), _IN_DOUBT.get(name)
        if not given and doubted and all(doubt.what != doubted for doubt in report.doubts):
            continue
        words, proposed, take = question(report)
        typed, wrong = not given, ""
        while True:
            # A proposal that is taken stays one: its doubts are shown, and nothing is put in its place.
            given = ask(f"{wrong}{words}", proposed) if typed else given
            if not given:
                break
            try:
                added = take(given)
                if added:
                    report, said = check({**tables, **added})
            except SkylimbError as error:
                if not typed:
                    raise
                wrong = f"{error}\n"
                continue
            tables.update(added)
            break
    yield report, said


def _number(name: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not -1e4 < value < 1e4:
        raise ConfigError(f"{name} = '{text}' must be a number")
    return value
