"""What a calibration finds: how the real robot and its sensors differ from their description.

In free flight the mass and a thrust scale common to all rotors are one number, as F = m a scales both, and so
does the inertia. Rotor scales are therefore over the mass's, and `mass_scale` is what no flight shows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skylimb.robots.model import Robot


@dataclass(frozen=True)
class Parameter:
    """One table of a calibration.

    Attributes:
        name: as an experiment or a report has it.
        unit: SI.
        entries: names of its entries; one, empty, for a single number.
        center: what is believed before any flight, of every entry.
        spread: its standard deviation. It is wide, so that a flight decides and not the belief.
        wanted: standard deviation that a good flight leaves.
        meaning: in a few words.
    """

    name: str
    unit: str
    entries: tuple[str, ...]
    center: tuple[float, ...]
    spread: float
    wanted: float
    meaning: str

    @property
    def labels(self) -> tuple[str, ...]:
        """A name for every entry."""
        return tuple(f"{self.name} {entry}".strip() for entry in self.entries)


def parameters(robot: Robot) -> tuple[Parameter, ...]:
    """What is estimated of this robot, in the order of a flat vector."""
    axes, rotors = ("x", "y", "z"), tuple(rotor.name for rotor in robot.description.rotors)
    lag = float(np.mean([rotor.lag for rotor in robot.description.rotors]))
    return (
        Parameter(
            "attitude_misalignment",
            "rad",
            axes,
            (0.0, 0.0, 0.0),
            0.035,
            0.0026,
            "rotation vector from the true to the measured body axes",
        ),
        Parameter(
            "cog_offset",
            "m",
            axes,
            (0.0, 0.0, 0.0),
            0.02,
            0.0015,
            "true less described centre of gravity, root link's axes",
        ),
        Parameter(
            "rotor_scale",
            "",
            rotors,
            (1.0,) * len(rotors),
            0.1,
            0.005,
            "true over commanded thrust of each rotor, over the mass's scale",
        ),
        Parameter("rotor_lag", "s", ("",), (lag,), 0.02, 0.005, "time constant of the thrusts"),
        Parameter("latency", "s", ("",), (0.02,), 0.02, 0.002, "age of a measurement when it comes"),
        Parameter(
            "lean",
            "",
            axes[:2],
            (0.0, 0.0),
            0.01,
            0.0026,
            "steady push along the axes of W over the weight: wind, or a world frame that leans",
        ),
        Parameter(
            "gravity",
            "m/s^2",
            ("",),
            (robot.description.gravity,),
            0.02,
            0.05,  # it trades for the rotor scales in a hover, so it is wanted as well as they are
            "of the place, which is not the same everywhere",
        ),
    )


def centers(given: tuple[Parameter, ...]) -> np.ndarray:
    """What is believed before any flight, flat."""
    return np.concatenate([one.center for one in given])


def spreads(given: tuple[Parameter, ...]) -> np.ndarray:
    """Standard deviations of that belief, flat."""
    return np.concatenate([np.full(len(one.center), one.spread) for one in given])


def scaled(information: np.ndarray, given: tuple[Parameter, ...]) -> np.ndarray:
    """Fisher information in units of the wanted accuracy, (p, p).

    An eigenvalue above 1 means that its direction is known better than wanted. A flight is as good as the
    smallest of them.
    """
    wanted = np.concatenate([np.full(len(one.center), one.wanted) for one in given])
    return information * np.outer(wanted, wanted)


def slices(given: tuple[Parameter, ...]) -> dict[str, slice]:
    """Where each parameter stands in the flat vector."""
    ends = np.cumsum([0, *(len(one.center) for one in given)])
    return {one.name: slice(int(a), int(b)) for one, a, b in zip(given, ends, ends[1:], strict=False)}
