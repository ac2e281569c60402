"""A push on the flying robot: a constant wrench at its centre of gravity for a while."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated

import mujoco
import numpy as np

from skylimb.keys import Key, configuration


@configuration
class DisturbanceConfig:
    """A push on the flying robot."""

    force: Annotated[
        tuple[float, float, float],
        Key("N", "force in W, through the true centre of gravity", low=-100.0, high=100.0),
    ] = (0.0, 0.0, 0.0)
    torque: Annotated[tuple[float, float, float], Key("N m", "torque in W", low=-50.0, high=50.0)] = (
        0.0,
        0.0,
        0.0,
    )
    start: Annotated[float, Key("s", "time since take-off at which it begins", low=0.0, high=1e5)] = 0.0
    duration: Annotated[float, Key("s", "how long it lasts; 0 for none", low=0.0, high=1e5)] = 0.0


def active(config: DisturbanceConfig, times: np.ndarray) -> np.ndarray:
    """Whether the push acts in the tick that begins at each time, (k,)."""
    return (times >= config.start - 1e-9) & (times < config.start + config.duration - 1e-9)


def pushes(config: DisturbanceConfig, times: np.ndarray) -> bool:
    """Whether anything pushes in the ticks that begin at these times."""
    return bool(active(config, times).any() and (np.any(config.force) or np.any(config.torque)))


def pusher(
    config: DisturbanceConfig, model: mujoco.MjModel, data: mujoco.MjData, root: str, times: np.ndarray
) -> Callable[[int], None] | None:
    """A function that sets the push before the steps of tick k; None where nothing pushes."""
    if not pushes(config, times):
        return None
    acts = active(config, times)
    body = model.body(root).id
    force, torque = np.array(config.force), np.array(config.torque)

    def push(k: int) -> None:
        data.qfrc_applied[:] = 0.0
        if acts[k]:
            # Positions of the step before last are at hand; the centre of gravity must be that of now.
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            mujoco.mj_applyFT(model, data, force, torque, data.subtree_com[body], body, data.qfrc_applied)

    return push
