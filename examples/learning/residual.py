"""`following` with a residual that was learned: a small network moves the path across the contact axis.

    skylimb run --controller examples/learning/residual.toml

The network sees what the law itself knows, in the axes of the task (`SEEN`), and says between -1 and 1 how
far the path is moved along u and v. What it saw is recorded as `policy_observation`, which is what the
environment of `train.py` shows; there `offset` is the action, and the network is silent (`share = 0`).

Its weights are in policy.json with the robot, the version of the format and the layout of what it sees. A
file that does not fit is refused before take-off.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from skylimb.base.errors import ConfigError
from skylimb.base.keys import Key, configuration
from skylimb.base.sources import read_source
from skylimb.control.needs import Needs
from skylimb.control.press import wanted_force
from skylimb.control.translation.laws import following
from skylimb.symbolic import clip, cross, dot, tanh, vector

REQUIRES, OPTIONAL = following.REQUIRES, following.OPTIONAL

FORMAT, VERSION = "skylimb policy", 1
POLICY = Path(__file__).with_name("policy.json")
FILES = ("policy.json",) if POLICY.is_file() else ()  # kept with every flight

SEEN = (
    ("tip_error", 2, 0.01),  # m, along u and v
    ("velocity_error", 2, 0.05),  # m/s
    ("path_velocity", 2, 0.1),  # m/s
    ("force_across", 2, 1.0),  # N, estimated
    ("force_error", 1, 0.5),  # N, along the contact axis
    ("engaged", 1, 1.0),
)
"""What the network sees: name, numbers, and what each is divided by."""

Pair = tuple[float, float]


@configuration
class Gains(following.Gains):
    """Those of `following`, and the residual's."""

    reach: Annotated[float, Key("m", "how far the network may move the path", low=0.0, high=0.1)] = 0.02
    share: Annotated[float, Key("", "1: the network counts; 0: it is silent", low=0.0, high=1.0)] = 1.0
    offset: Annotated[Pair, Key("m", "how far the path is moved besides", low=-0.1, high=0.1)] = (0.0, 0.0)


def needs(gains: Gains) -> Needs:
    return following.needs(gains)


def initial_state(gains: Any, start: Any) -> following.State:
    if gains.share > 0.0:
        read_policy(POLICY, start.robot.name)
        if not _LAYERS:
            raise ConfigError(f"'{POLICY}' was written after this law was read; fly it from a fresh process")
    return following.initial_state(gains, start)


def step(gains: Any, state: Any, inputs: Any) -> Any:
    reference = inputs.reference
    u = reference.sliding_axis
    v = cross(reference.contact_axis, u)
    seen = observation(gains, inputs, u, v)
    said = _LAYERS and network(_LAYERS, seen)
    along = [gains.offset[i] + (gains.share * gains.reach * said[i] if said else 0.0) for i in (0, 1)]
    moved = along[0] * u + along[1] * v
    reference = reference._replace(
        position=reference.position + moved, tip_position=reference.tip_position + moved
    )
    state, force, signals = following.step(gains, state, inputs._replace(reference=reference))
    return state, force, {**signals, "policy_observation": vector(*seen), "policy_offset": vector(*along)}


def observation(gains: Any, inputs: Any, u: Any, v: Any) -> list[Any]:
    """What the network sees, in the order of `SEEN`, each of about the size of 1."""
    body, arm, reference = inputs.estimate.body, inputs.estimate.arm, inputs.reference
    force = inputs.estimate.wrench.force
    tip = body.position + arm - reference.tip_position
    late = body.velocity - reference.tip_velocity
    missing = wanted_force(reference.force, gains.force) - inputs.contact.normal_force
    parts = [
        [dot(u, tip), dot(v, tip)],
        [dot(u, late), dot(v, late)],
        [dot(u, reference.tip_velocity), dot(v, reference.tip_velocity)],
        [dot(u, force), dot(v, force)],
        [missing * inputs.contact.engaged],
        [inputs.contact.engaged],
    ]
    return [
        clip(one / scale, -5.0, 5.0) for part, (_, _, scale) in zip(parts, SEEN, strict=True) for one in part
    ]


def network(layers: list[tuple[np.ndarray, np.ndarray]], seen: list[Any]) -> list[Any]:
    """Layers of tanh, and a last one that is held between -1 and 1."""
    for number, (weights, bias) in enumerate(layers):
        seen = [
            sum((w * x for w, x in zip(row, seen, strict=True)), b)
            for row, b in zip(weights, bias, strict=True)
        ]
        seen = [tanh(x) if number < len(layers) - 1 else clip(x, -1.0, 1.0) for x in seen]
    return seen


def read_policy(path: Path, robot: str = "") -> list[tuple[np.ndarray, np.ndarray]]:
    """The layers of a policy's file, each its weights and its bias.

    Args:
        path: of the file.
        robot: that will fly it; any where it is empty.

    Raises:
        ConfigError: naming what does not fit.
    """
    try:
        told = json.loads(read_source(path).content)
        found = told["format"], told["version"], told["robot"], told["observation"]
        layers = [(np.array(one["weights"], float), np.array(one["bias"], float)) for one in told["layers"]]
    except (ValueError, TypeError, KeyError) as error:
        raise ConfigError(f"'{path}' is no policy: {type(error).__name__}: {error}") from error
    wanted = FORMAT, VERSION, robot or found[2], layout()
    for what, is_, should in zip(("format", "version", "robot", "observation"), found, wanted, strict=True):
        if is_ != should:
            raise ConfigError(f"policy '{path}': {what} is {is_!r}, this law needs {should!r}")
    sizes = [sum(size for _, size, _ in SEEN), *(len(bias) for _, bias in layers)]
    for number, (weights, bias) in enumerate(layers):
        if (
            weights.shape != (sizes[number + 1], sizes[number])
            or not np.isfinite([*weights.flat, *bias]).all()
        ):
            raise ConfigError(f"policy '{path}': layer {number} has the wrong shape, or is not finite")
    if sizes[-1] != 2:
        raise ConfigError(f"policy '{path}': it says {sizes[-1]} numbers, this law needs 2")
    return layers


def layout() -> list[list[Any]]:
    """What a policy's file says of what it sees."""
    return [[name, size, scale] for name, size, scale in SEEN]


def policy_text(robot: str, layers: list[tuple[np.ndarray, np.ndarray]]) -> str:
    """A policy's file."""
    told = [{"weights": w.tolist(), "bias": b.tolist()} for w, b in layers]
    head = {"format": FORMAT, "version": VERSION, "robot": robot, "observation": layout()}
    return json.dumps({**head, "layers": told})


_LAYERS = read_policy(POLICY) if FILES else []
