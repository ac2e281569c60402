"""What a policy is shown: what the robot measures and is asked for, or the truth as well."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from skylimb.base.errors import unknown_name
from skylimb.base.packing import Layout
from skylimb.flight.takeoff import Takeoff
from skylimb.simulation.rows import reference_layout
from skylimb.studies.envs.tasks import EnvSettings

_MEASURED = (
    "root_quaternion_measured", "root_velocity_measured", "root_angular_velocity_measured",
    "joint_angles_measured", "vectoring_angles_measured", "thrusts_command",
    "external_force_estimate", "external_torque_estimate",
)  # fmt: skip
"""Signals that a robot has, where its flight has them."""

_ASKED = ("velocity", "tip_velocity", "contact_axis", "force", "touch")
"""Entries of the reference."""

_TRUE = ("configuration_velocity", "contact_force")
"""Signals that only a simulation has."""


class Part(NamedTuple):
    """A part of an observation.

    Attributes:
        name: what it is.
        size: how many numbers.
    """

    name: str
    size: int


class Observations:
    """Makes observations of the signals, references and tips of n flights.

    Args:
        takeoff: one of the flights.
        settings: what is shown.
        drawn: keys of the draw that are numbers.

    Attributes:
        parts: of one observation, in its order.
    """

    def __init__(self, takeoff: Takeoff, settings: EnvSettings, drawn: tuple[str, ...]) -> None:
        self._signals, self._asked = takeoff.tick.signals, reference_layout(takeoff.plant.robot)
        for name in settings.signals:
            if name not in self._signals.slices:
                raise unknown_name(
                    f"signal of controller {takeoff.controller.name}", name, self._signals.slices
                )
        self._more = _columns(self._signals, settings.signals)
        self._alone = settings.observations == "signals"
        self._privileged = settings.observations == "privileged"
        shown = [name for name in _MEASURED if name in self._signals.slices]
        self._columns = _columns(self._signals, shown)
        self._rows = _columns(self._asked, _ASKED)
        parts = _parts(self._signals, settings.signals)
        if not self._alone:
            parts += [Part("root_from_reference", 3), *_parts(self._signals, shown)]
            parts += [Part("tip_ahead", 3), *_parts(self._asked, _ASKED)]
        if self._privileged:
            self._true = _columns(self._signals, _TRUE)
            parts += [Part("true_root_from_reference", 3), Part("true_tip_error", 3)]
            parts += [*_parts(self._signals, _TRUE), *(Part(f"drawn {key}", 1) for key in drawn)]
        self.parts = tuple(parts)
        self.size = sum(part.size for part in parts)

    def of(self, signals: np.ndarray, asked: np.ndarray, tips: np.ndarray, drawn: np.ndarray) -> np.ndarray:
        """Observations, (n, size).

        Args:
            signals: of the last tick, (n, signals).
            asked: references, (n, entries).
            tips: W, m, (n, 3).
            drawn: values of the draw, (n, keys).
        """
        more = signals[:, self._more]
        if self._alone:
            return more
        position = asked[:, self._asked.slices["position"]]
        tip = asked[:, self._asked.slices["tip_position"]]
        measured = signals[:, self._signals.slices["root_position_measured"]]
        shown = [more, measured - position, signals[:, self._columns], tip - position, asked[:, self._rows]]
        if self._privileged:
            true = signals[:, self._signals.slices["configuration"]][:, :3]
            shown += [true - position, tips - tip, signals[:, self._true], drawn]
        return np.concatenate(shown, axis=1)


def _columns(layout: Layout, names: tuple[str, ...] | list[str]) -> np.ndarray:
    return np.concatenate([np.zeros(0, int), *(np.r_[layout.slices[name]] for name in names)])


def _parts(layout: Layout, names: tuple[str, ...] | list[str]) -> list[Part]:
    return [Part(name, layout.slices[name].stop - layout.slices[name].start) for name in names]
