"""What a policy is paid for: small functions of what was seen in a step, one number for each environment.

A term is 0 at worst and 1 at best, or 0 at best and negative; weights are the environment's. Each is in
`info` by its name, so that a curve of each can be drawn.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from skylimb.base.errors import ConfigError, UserCodeError
from skylimb.base.packing import Layout
from skylimb.base.user_code import guarded

_NEAR, _LIKE = 0.01, 0.5
"""Where a line is well drawn, m; where a press is well held, N."""


@dataclass(frozen=True)
class Seen:
    """What happened in a step in n environments.

    Attributes:
        signals: of the last tick, (n, signals), where `layout` says.
        layout: of the signals.
        references: of the mission's present tick, (n, entries), where `asked` says.
        asked: layout of the references.
        tips: where the tip is, W, m, (n, 3).
        actions: of this step, (n, actions).
        before: of the step before.
        lost: whether the flight was lost, (n,).
        force: press that is wanted where the path says none, N.
    """

    signals: np.ndarray
    layout: Layout
    references: np.ndarray
    asked: Layout
    tips: np.ndarray
    actions: np.ndarray
    before: np.ndarray
    lost: np.ndarray
    force: float

    def signal(self, name: str) -> np.ndarray:
        """A signal, (n, width)."""
        return self.signals[:, self.layout.slices[name]]

    def reference(self, name: str) -> np.ndarray:
        """An entry of the reference, (n, width)."""
        return self.references[:, self.asked.slices[name]]


def on_path(seen: Seen) -> np.ndarray:
    """How near the tip is to its path, across the contact axis: 1 on it, 0.42 at 10 mm."""
    n = seen.reference("contact_axis")
    off = seen.tips - seen.reference("tip_position")
    off = off - n * np.sum(n * off, axis=1, keepdims=True)
    return 1.0 - np.tanh(np.linalg.norm(off, axis=1) / _NEAR) ** 2


def press(seen: Seen) -> np.ndarray:
    """How near the press is to what is wanted: 1 at it, 0.42 at 0.5 N; 0 where the path asks for no touch."""
    told = seen.reference("force")[:, 0]
    wanted = np.where(told > 0.0, told, seen.force)
    pressed = -np.sum(seen.reference("contact_axis") * seen.signal("contact_force"), axis=1)
    touch = seen.reference("touch")[:, 0]
    return touch * (1.0 - np.tanh(np.abs(np.abs(pressed) - wanted) / _LIKE) ** 2)


def calm(seen: Seen) -> np.ndarray:
    """Minus the robot's rates squared, (rad/s)^2."""
    return -np.sum(seen.signal("configuration_velocity")[:, 3:6] ** 2, axis=1)


def effort(seen: Seen) -> np.ndarray:
    """Minus the spread of the thrusts over their mean, squared."""
    thrusts = seen.signal("thrusts_command")
    return -((thrusts.std(axis=1) / np.maximum(thrusts.mean(axis=1), 1e-3)) ** 2)


def smooth(seen: Seen) -> np.ndarray:
    """Minus the change of the action, squared."""
    return -np.sum((seen.actions - seen.before) ** 2, axis=1)


def lost(seen: Seen) -> np.ndarray:
    """-1 where the flight is lost."""
    return -seen.lost.astype(float)


REWARDS: dict[str, Callable[[Seen], np.ndarray]] = {
    each.__name__: each for each in (on_path, press, calm, effort, smooth, lost)
}
"""Every term by its name."""

_SHIPPED = frozenset(REWARDS)


def reward(function: Callable[[Seen], np.ndarray]) -> Callable[[Seen], np.ndarray]:
    """Make a function of the user's a term, known by its name.

    Raises:
        ConfigError: when a term that ships has that name.
    """
    name = function.__name__
    if name in _SHIPPED:
        raise ConfigError(f"reward '{name}' has the name of one that ships; choose another")
    REWARDS[name] = guarded(function, f"reward '{name}'")
    return function


def term(name: str, seen: Seen) -> np.ndarray:
    """A term by its name, one number for each environment.

    Raises:
        UserCodeError: when a user's function fails, or returns something else.
    """
    found, wanted = np.asarray(REWARDS[name](seen)), (len(seen.lost),)
    if found.shape != wanted or found.dtype.kind not in "fiub":
        raise UserCodeError(
            f"reward '{name}' should return numbers of shape {wanted}; it returned {found.shape}"
        )
    if not np.isfinite(found).all():
        raise UserCodeError(f"reward '{name}' returned {found[~np.isfinite(found)][0]}, no finite number")
    return found
