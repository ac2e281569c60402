"""A peg at the tip: a round bar with a round end, which may touch the walls of a hole in several places.

It stands in the place of the tip's ball, its end as far out as the ball's. Each wall touches it by a pair of
its own with the surface's stiffness; the engine gives a bar on a flat wall two touches, one near either end.
"""

from __future__ import annotations

import mujoco
import numpy as np

from skylimb.robots.description import Tip
from skylimb.simulation.contact import add_contact_pair, tune_contact_pair
from skylimb.simulation.contact_keys import PAIR_NAME, ContactParameters
from skylimb.simulation.plant_config import Peg
from skylimb.simulation.surface_bodies import SurfaceParts

PEG_GEOM = "tip_peg"


def add_peg(
    spec: mujoco.MjSpec,
    tip_geom: str,
    tip: Tip,
    peg: Peg,
    parts: SurfaceParts,
    parameters: ContactParameters,
) -> None:
    """Put a peg over the tip's ball, and let it and every part of the surface collide.

    Args:
        spec: with the tip in it.
        tip_geom: the tip's ball.
        tip: of the robot's description.
        peg: radius and length, m.
        parts: what is touched.
        parameters: of each contact.
    """
    ball, (radius, length) = spec.geom(tip_geom), peg
    along = direction_of(tip)
    end = np.asarray(ball.pos) + (tip.radius - radius) * along
    ball.parent.add_geom(
        name=PEG_GEOM,
        type=mujoco.mjtGeom.mjGEOM_CAPSULE,
        fromto=[*(end - (length - radius) * along), *end],
        size=[radius, 0.0, 0.0],
        mass=0.0,
        contype=0,
        conaffinity=0,
        rgba=ball.rgba,
    )
    for index, geom in enumerate(parts.geoms):
        add_contact_pair(spec, PEG_GEOM, geom, parameters, pair_name(index))


def tune_peg(model: mujoco.MjModel, parameters: ContactParameters) -> None:
    """Write the solver parameters of all its pairs."""
    for pair in range(model.npair):
        tune_contact_pair(model, parameters, model.pair(pair).name)


def direction_of(tip: Tip) -> np.ndarray:
    """Along the peg and out of the robot, axes of the tip's link, (3,): along its stem, or its x axis."""
    if tip.stem is None:
        return np.array([1.0, 0.0, 0.0])
    along = np.asarray(tip.position) - np.asarray(tip.stem)
    return along / np.linalg.norm(along)


def pair_name(index: int) -> str:
    """Of the pair of the peg and a part of the surface."""
    return PAIR_NAME if index == 0 else f"{PAIR_NAME}_{index}"
