"""Stops at the joints' limits, as a spring and a damper of their own, and how long a flight leans on them."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from skylimb.base.errors import ConfigError
from skylimb.simulation.contact import IMPEDANCE

LEANS = 1e-3
"""A joint within this of its limit, or beyond, leans on its stop, rad."""


def tune_joint_stops(
    model: mujoco.MjModel, joints: Sequence[str], stiffness: float | None, damping: float
) -> None:
    """Write stiffness (N m/rad) and damping (N m s/rad) of the stops; None leaves the engine's own.

    Raises:
        ConfigError: when the time step cannot carry them.
    """
    if stiffness is None:
        return
    step = float(model.opt.timestep)
    for name in joints:
        joint = model.joint(name).id
        # The engine divides by this inertia, its average in the reference configuration.
        inertia = 1.0 / float(model.dof_invweight0[model.jnt_dofadr[joint]])
        for key, value, most in (
            ("stiffness", stiffness, 0.25 * inertia / step**2),
            ("damping", damping, inertia / step),
        ):
            if value > most:
                raise ConfigError(
                    f"plant.joint_stop_{key} = {value:g} is too much for a time step of {step:g} s and "
                    f"{inertia:.3g} kg m^2 at joint '{name}': at most {most:.4g}"
                )
        scale = (1.0 - IMPEDANCE) / inertia  # the stop is a spring beside the joint
        model.jnt_solref[joint] = (-stiffness * scale, -damping * scale)
        model.jnt_solimp[joint] = (IMPEDANCE, IMPEDANCE, 1e-3, 0.5, 2.0)


def leaning(
    angles: np.ndarray, lower: np.ndarray, upper: np.ndarray, names: Sequence[str]
) -> dict[str, float]:
    """The share of a flight's ticks in which each joint leans on a stop, of those that do.

    Args:
        angles: of the joints at every tick, (k, nq), rad.
        lower: limits, (nq,), rad.
        upper: limits, (nq,), rad.
        names: of the joints.
    """
    if not len(angles):
        return {}
    shares = np.mean((angles < lower + LEANS) | (angles > upper - LEANS), axis=0)
    return {name: float(share) for name, share in zip(names, shares, strict=True) if share > 0.0}
