"""A push on the flying robot: a constant wrench at its centre of gravity for a while."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import mujoco
import numpy as np

from skylimb.config import require_non_negative, require_range


@dataclass(frozen=True)
class DisturbanceConfig:
    """The push.

    Attributes:
        force: W, N, through the true centre of gravity.
        torque: W, N m.
        start: s.
        duration: s.
    """

    force: tuple[float, float, float] = (0.0, 0.0, 0.0)
    torque: tuple[float, float, float] = (0.0, 0.0, 0.0)
    start: float = 0.0
    duration: float = 0.0

    def __post_init__(self) -> None:
        for entry in self.force:
            require_range("disturbance", "force", entry, -100.0, 100.0, "N")
        for entry in self.torque:
            require_range("disturbance", "torque", entry, -50.0, 50.0, "N m")
        require_non_negative("disturbance", "start", self.start, "s")
        require_non_negative("disturbance", "duration", self.duration, "s")


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
