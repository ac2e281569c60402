"""What a flight would show: its Fisher information, scaled by the accuracy that is wanted of each parameter.

An eigenvalue above 1 means that its direction is known better than wanted. A manoeuvre is as good as the
smallest of them.
"""

from __future__ import annotations

import numpy as np

from skylimb.studies.calibration.parameters import Parameter

WANTED = {
    "attitude_misalignment": 0.0026,
    "cog_offset": 0.0015,
    "rotor_scale": 0.005,
    "rotor_lag": 0.005,
    "latency": 0.002,
    "lean": 0.0026,
    "gravity": 0.05,
}
"""Standard deviation that is wanted of each parameter: 0.15 degrees, 1.5 mm, 0.5 %, 5 ms, 2 ms.

That of gravity is the rotor scales', as they trade for each other in a hover."""


def wanted(given: tuple[Parameter, ...]) -> np.ndarray:
    """The wanted standard deviation of every entry, flat."""
    return np.concatenate([np.full(len(one.center), WANTED[one.name]) for one in given])


def scaled(information: np.ndarray, given: tuple[Parameter, ...]) -> np.ndarray:
    """The information in units of the wanted accuracy, (p, p)."""
    scale = wanted(given)
    return information * np.outer(scale, scale)


def worth(information: np.ndarray, given: tuple[Parameter, ...]) -> float:
    """Smallest eigenvalue of the scaled information."""
    return float(np.linalg.eigvalsh(scaled(information, given))[0])
