"""Pushes on the flying robot: constant wrenches, at its centre of gravity or at a point of a link."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from typing import Annotated

import mujoco
import numpy as np

from skylimb.errors import ConfigError, unknown_name
from skylimb.keys import Key, configuration

Vector = tuple[float, float, float]

_ZERO = (0.0, 0.0, 0.0)
_Word, _Vector = ctypes.c_int64, ctypes.c_double * 3


@configuration
class DisturbanceConfig:
    """A push on the flying robot."""

    force: Annotated[
        Vector, Key("N", "force in W, through the true centre of gravity", low=-100.0, high=100.0)
    ] = _ZERO
    torque: Annotated[Vector, Key("N m", "torque in W", low=-50.0, high=50.0)] = _ZERO
    start: Annotated[float, Key("s", "time since take-off at which it begins", low=0.0, high=1e5)] = 0.0
    duration: Annotated[float, Key("s", "how long it lasts; 0 for none", low=0.0, high=1e5)] = 0.0


@configuration
class PushConfig:
    """One of several pushes on the flying robot; what acts at the same time adds up."""

    start: Annotated[float, Key("s", "time since take-off at which it begins", low=0.0, high=1e5)]
    duration: Annotated[float, Key("s", "how long it lasts", above=0.0, high=1e5)]
    force: Annotated[Vector, Key("N", "force in W", low=-100.0, high=100.0)] = _ZERO
    torque: Annotated[Vector, Key("N m", "torque in W", low=-50.0, high=50.0)] = _ZERO
    link: Annotated[str, Key("", "link that is pushed; empty for the robot's true centre of gravity")] = ""
    point: Annotated[
        Vector, Key("m", "where the force acts, in the link's axes; only with a link", low=-10.0, high=10.0)
    ] = _ZERO

    def check(self) -> None:
        """Refuse a point without a link."""
        if any(self.point) and not self.link:
            raise ConfigError(
                f"point = {list(self.point)} m needs a link, in whose axes it is; link is empty"
            )


class Push(ctypes.Structure):
    """A push on a model; `Push` of flight.c is declared from these fields.

    begin, end: ticks from which and before which it acts. body: that is pushed. local: 1 when the force acts
    at `point`, m, in the body's axes; 0 when it acts at the centre of gravity of the body and all below it.
    """

    _fields_ = (
        ("begin", _Word), ("end", _Word), ("body", _Word), ("local", _Word),
        ("force", _Vector), ("torque", _Vector), ("point", _Vector),
    )  # fmt: skip


def resolved_pushes(
    disturbance: DisturbanceConfig,
    pushes: Sequence[PushConfig],
    model: mujoco.MjModel,
    root: str,
    times: np.ndarray,
) -> list[Push]:
    """All pushes that act in the ticks that begin at `times` (s), in the order in which they are added up.

    Raises:
        UnknownNameError: when a push names a link that the robot does not have.
    """
    single = PushConfig(
        start=disturbance.start,
        duration=max(disturbance.duration, 1e-9),
        force=disturbance.force,
        torque=disturbance.torque,
    )
    wanted = [*([single] if disturbance.duration > 0.0 else []), *pushes]
    found = []
    for push in wanted:
        begin, end = np.searchsorted(times, [push.start - 1e-9, push.start + push.duration - 1e-9])
        if begin < end and (any(push.force) or any(push.torque)):
            body = body_of(push.link or root, model)
            local = int(bool(push.link))
            found.append(Push(begin, end, body, local, push.force, push.torque, push.point))
    return found


def body_of(link: str, model: mujoco.MjModel) -> int:
    """The body of a link.

    Raises:
        UnknownNameError: when there is none.
    """
    body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, link)
    if body < 1:
        raise unknown_name("link in pushes", link, [model.body(i).name for i in range(1, model.nbody)])
    return body


def pusher(
    pushes: Sequence[Push], model: mujoco.MjModel, data: mujoco.MjData
) -> Callable[[int], None] | None:
    """A function that sets all pushes before the steps of tick k; None where nothing pushes."""
    if not pushes:
        return None
    numbers = [(p.begin, p.end, p.body, bool(p.local), *map(np.array, (p.force, p.torque))) for p in pushes]
    points = [tuple(push.point) for push in pushes]

    def push(k: int) -> None:
        data.qfrc_applied[:] = 0.0
        moved = False
        for (begin, end, body, local, force, torque), point in zip(numbers, points, strict=True):
            if not begin <= k < end:
                continue
            if not moved:
                # Positions of the step before last are at hand; the wrench must act where the robot is now.
                mujoco.mj_kinematics(model, data)
                mujoco.mj_comPos(model, data)
                moved = True
            at = data.subtree_com[body]
            if local:
                x, R = data.xpos[body], data.xmat[body]
                # Term by term, as in C: a matrix product may round otherwise.
                at = np.array(
                    [
                        x[i] + (R[3 * i] * point[0] + R[3 * i + 1] * point[1] + R[3 * i + 2] * point[2])
                        for i in range(3)
                    ]
                )
            mujoco.mj_applyFT(model, data, force, torque, at, body, data.qfrc_applied)

    return push
