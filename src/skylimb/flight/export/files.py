"""The files of an exported controller."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping
from hashlib import sha256
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from skylimb.base.c_code import c_source
from skylimb.base.errors import ConfigError
from skylimb.base.files import new_folder
from skylimb.base.keys import described, rows_of
from skylimb.base.packing import Layout
from skylimb.base.signal_table import SIGNALS
from skylimb.control.controller import Controller, TraceableController, controller_signals, require_compiled
from skylimb.control.laws.traced_step import TracedStep
from skylimb.control.supervisor.limits import Limits
from skylimb.control.supervisor.records import Flags
from skylimb.control.supervisor.table import TABLE
from skylimb.flight.export.step import NAME, Vector, controller_step, example_vector
from skylimb.robots.model import Robot

_TEMPLATES = Path(__file__).parent
_EXACT = """\
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__ > 0)
#error "gates are comparisons that NaN fails: build without -ffast-math and -ffinite-math-only"
#endif
typedef char build_without_fsingle_precision_constant[sizeof(double) == 8 && sizeof(1.0) == 8 ? 1 : -1];
"""
"""Of both files that compute: with such flags limits and last digits are gone, and no compiler says so."""
_QUIET = """\
#if defined(__GNUC__) /* every function has the same arguments, used or not */
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif
"""
TOLERANCE = 1e-12
"""Greatest difference, relative to the number's own size where that is above 1, that the example accepts."""


def export_c(
    controller: Controller,
    folder: str | Path,
    control_period: float = 0.005,
    beside: Mapping[str, bytes] = MappingProxyType({}),
    limits: Limits | None = None,
) -> list[Path]:
    """Write a controller under its supervisor as C99 that allocates nothing and needs only libm.

    Left in the folder: `controller_function.c` (CasADi's own text of the cascade), `controller.c` and
    `controller.h` (its gains, first state, the place of every named number, and one function to call),
    `test_vector.h` (inputs of some ticks and what they must give), `main.c`, an example that holds the code
    against the vector, and `host.c`, which reads measurements and writes commands.

    Args:
        controller: a cascade; a user's own Python class cannot be exported.
        folder: new.
        control_period: s, that the code is called with.
        beside: more files for the folder, by name.
        limits: when the supervisor acts.

    Returns:
        The files.

    Raises:
        ConfigError: when the controller cannot be traced, or the period is not positive.
        OutputError: when the folder exists or cannot be written.
    """
    traced = require_compiled(controller, "written as C")
    if not 0.0 < control_period < math.inf:
        raise ConfigError(f"control period = {control_period:g} s must be positive")
    step = controller_step(traced, control_period, limits)
    texts = {
        "controller_function.c": f"{_QUIET}{_EXACT}{c_source(step.function)}",
        "controller.h": _header(traced, step, control_period, limits or Limits()),
        "controller.c": _source(traced.robot, step),
        "test_vector.h": _vector(example_vector(traced, step)),
        "main.c": (_TEMPLATES / "example_main.c").read_text("utf-8"),
        "host.c": (_TEMPLATES / "host.c").read_text("utf-8"),
    }
    digest = f"0x{sha256(''.join(texts.values()).encode()).hexdigest()[:8]}ul"
    texts = {name: text.replace("@DIGEST@", digest) for name, text in texts.items()}
    with new_folder(folder) as staging:
        for name, text in texts.items():
            (staging / name).write_text(text, encoding="utf-8")
        for name, content in beside.items():
            (staging / name).write_bytes(content)
    return [Path(folder) / name for name in (*texts, *beside)]


_ABOUT = {
    "measurement.position": "origin of the measured link, W, m",
    "measurement.quaternion": "its attitude, w x y z",
    "measurement.velocity": "of that origin, W, m/s",
    "measurement.angular_velocity": "of the link, in its own axes, rad/s",
    "measurement.joint_angles": "shape joints, rad",
    "measurement.vectoring_angles": "vectoring joints, rad",
    "measurement.capture_age": "of the pose and twist above, as their stamp says, s",
    "measurement.imu.angular_velocity": "of the IMU's link, in the IMU's axes, rad/s",
    "measurement.imu.specific_force": "in the IMU's axes, mean since the last call, m/s^2; at rest g up",
    "reference.position": "centre of gravity, W, m",
    "reference.velocity": "m/s; zero when positions alone are sent",
    "reference.acceleration": "m/s^2; likewise",
    "reference.heading": "the heading in the nominal posture, about W's z, rad",
    "reference.reach": "nominal, m",
    "reference.joint_angles": "nominal posture, rad",
    "reference.vectoring_angles": "of that posture, rad",
    "reference.contact_axis": "unit vector into the surface, W",
    "reference.tare": "1 while the bias of the force estimate is averaged",
    "reference.align": "1 to keep the heading though the joints give way",
    "reference.adapt": "1 while the arm may answer to force",
    "reference.tip_position": "of the tip over the nominal surface, W, m",
    "reference.tip_velocity": "m/s, always sent",
    "reference.tip_acceleration": "m/s^2, always sent",
    "reference.touch": "1 while the tip is to touch",
    "reference.wait": "1 while the mission should not go on without touch",
    "reference.sliding_axis": "unit vector u of the sliding plane, W",
    "reference.force": "wanted normal force, N; 0 where the controller's own counts",
    "reference.clearance": "of a lifted pen from a surface that goes on as where it left, m; or 0",
    "reference.fine": "1 while a small stroke is drawn",
    "flags.pose": "1 where a pose has come since the last tick, else 0",
    "flags.joints": "1 where joint angles have",
    "flags.late": "1 where this tick came too late",
    "flags.land": "1 to break the flight off",
    "flags.stop": "1 to stop the motors",
    "command.thrusts": "N",
    "command.joint_angles": "rad",
    "command.vectoring_angles": "rad",
}


def _header(controller: TraceableController, step: TracedStep, dt: float, limits: Limits) -> str:
    parts: list[tuple[str, Layout[Any]]] = [
        ("measurement", step.inputs.measurement),
        ("reference", step.inputs.reference),
        ("gains", step.inputs.gains),
        ("command", step.commands),
        ("flags", Layout(Flags())),
        ("signals", step.signals),
    ]
    about = {**_ABOUT, **_about_gains(controller), **_about_signals(controller)}
    order = _order(controller.robot)
    first = step.inputs.state.slices[f"watch.flags.{Flags._fields[0]}"].start
    lines = [
        f"#define SKYLIMB_STATE_SIZE {len(step.state)}",
        f"#define SKYLIMB_STATE_FLAGS {first} /* its flags */",
    ]
    for part, layout in parts:
        lines += ["", f"#define SKYLIMB_{part.upper()}_SIZE {layout.size}"]
        for name, where in layout.slices.items():
            width = where.stop - where.start
            names = order.get(name, ()) if part != "gains" else ()
            of = f"of {', '.join(names)}" if len(names) == width else ""
            says = _words(about.get(f"{part}.{name}", ""), of)
            words = [f"{width} {'number' if width == 1 else 'numbers'}", says]
            comment = _in_comment(": ".join(filter(None, words)))
            called = re.sub(r"\W", "_", f"{part}_{name}").upper()
            lines.append(f"#define SKYLIMB_{called} {where.start} /* {comment} */")
    template = (_TEMPLATES / "controller_template.h").read_text("utf-8")
    return (
        template.replace("@ROBOT_TEXT@", json.dumps(controller.robot.name, ensure_ascii=False))
        .replace("@CONTROLLER_TEXT@", json.dumps(controller.name, ensure_ascii=False))
        .replace("@CONTROLLER@", _in_comment(controller.name))
        .replace("@ROBOT@", _in_comment(controller.robot.name))
        .replace("@PERIOD@", repr(float(dt)))
        .replace("@SIZES@", "\n".join(lines))
        .replace("@STATUS@", "\n".join(_status()))
        .replace("@LIMITS@", "\n".join(_about_limits(limits)))
        .replace("@MEASURED@", _in_comment(controller.robot.description.measured_link))
    )


def _order(robot: Robot) -> dict[str, tuple[str, ...]]:
    """Rotors or joints in their order, by the name of what is one number for each."""
    says = robot.description
    rotors = tuple(one.name for one in says.rotors)
    return {
        "thrusts": rotors,
        "rotor_shares_estimate": rotors,
        "joint_angles": says.shape_joints,
        "vectoring_angles": says.vectoring_joints,
    }


def _about_limits(limits: Limits) -> Iterator[str]:
    """A line for every key of the supervisor, which in C is always on."""
    for name, value, info in described(limits):
        if name != "on":
            yield _in_comment(f" *   {name} = {value}: {_words(info.meaning, info.unit)}")


def _status() -> Iterator[str]:
    """Modes and bits of the supervisor's table."""
    for number, (name, meaning) in enumerate(TABLE.modes.items()):
        yield f"#define SKYLIMB_{name} {number}ul /* {meaning} */"
    for place, (name, meaning) in enumerate(TABLE.bits.items()):
        yield f"#define SKYLIMB_BIT_{name.upper()} {1 << place:#x}ul /* {meaning} */"


def _about_gains(controller: TraceableController) -> dict[str, str]:
    """Meaning, unit and range of every gain."""
    rows = rows_of(controller.key_tables())
    return {f"gains.{name}": _words(info.meaning, info.unit, info.range) for name, _, info in rows}


def _about_signals(controller: TraceableController) -> dict[str, str]:
    """Meaning, unit and frame of every signal: those that everybody knows, and a law's own."""
    known = {f"signals.{name}": _words(of.long_name, of.units, of.frame) for name, of in SIGNALS.items()}
    own = controller_signals(controller).items()
    return known | {f"signals.{name}": _words(of.meaning, of.unit, of.frame) for name, of in own}


def _words(*about: str) -> str:
    return "; ".join(filter(None, about))


def _in_comment(words: str) -> str:
    """Words that end no comment of C."""
    return words.replace("*/", "* /")


def _source(robot: Robot, step: TracedStep) -> str:
    limits = zip(robot.thrust_limits(), robot.joint_limits(), robot.vectoring_limits(), strict=True)
    least, greatest = (_numbers(np.concatenate(part)) for part in limits)
    template, function = (_TEMPLATES / "controller_template.c").read_text("utf-8"), step.function
    return (
        template.replace("@EXACT@", _EXACT)
        .replace("@FUNCTION@", NAME)
        .replace("@WORK@", str(max(1, function.sz_w())))
        .replace("@ARGUMENTS@", str(function.sz_arg()))
        .replace("@RESULTS@", str(function.sz_res()))
        .replace("@STATE@", _numbers(step.state))
        .replace("@GAINS@", _numbers(step.gains))
        .replace("@LEAST@", least)
        .replace("@GREATEST@", greatest)
        .replace("@WELL@", _numbers(np.array(Flags())))
    )


def _vector(vector: Vector) -> str:
    lines = [
        "/* What the exported code is held against: inputs of a few ticks, and what they must give. */",
        f"#define TEST_TICKS {len(vector['command'])}",
        f"#define TEST_TOLERANCE {TOLERANCE!r}",
    ]
    for name, table in vector.items():
        rows = ",\n".join(f"  {{{_numbers(row)}}}" for row in table)
        lines.append(f"static const double test_{name}[{table.shape[0]}][{table.shape[1]}] = {{\n{rows}\n}};")
    return "\n".join(lines) + "\n"


def _numbers(values: np.ndarray) -> str:
    """Numbers in C, each with as many digits as it needs to come back the same."""
    return ", ".join(repr(float(value)).replace("inf", "HUGE_VAL") for value in values)
