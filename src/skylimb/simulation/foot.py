"""A foot: four balls around the tip's own, so that the tip can lie flat on a surface and carry a torque.

The five balls are alike and stand in the plane across the tip link's x axis, the four at the corners of a
square. Each touches by a pair of its own, with a fifth of the surface's stiffness and damping: together they
are as stiff as the tip alone would be. Pressed flat with N they give a torque of up to half_width N about an
edge, and they slide at mu N whatever the torque.
"""

from __future__ import annotations

import dataclasses

import mujoco

from skylimb.simulation.contact import add_contact_pair, effective_mass, tune_contact_pair
from skylimb.simulation.contact_keys import PAIR_NAME, ContactParameters

CORNERS = ((1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0))
"""Directions of the corners along the tip link's y and z axes."""

BALLS = 1 + len(CORNERS)
"""How many share the load."""

_PLATE = (0.35, 0.37, 0.40, 1.0)


def add_foot(
    spec: mujoco.MjSpec, tip_geom: str, half_width: float, surface_geom: str, parameters: ContactParameters
) -> None:
    """Put a ball like the tip's at each corner, and let it and the surface collide.

    Args:
        spec: with the tip in it.
        tip_geom: the tip's ball.
        half_width: half the side of the square, m.
        surface_geom: what is touched.
        parameters: of the whole contact.
    """
    tip = spec.geom(tip_geom)
    for index, (y, z) in enumerate(CORNERS):
        name = f"{tip_geom}_{index}"
        tip.parent.add_geom(
            name=name,
            type=tip.type,
            size=tip.size,
            pos=[tip.pos[0], tip.pos[1] + y * half_width, tip.pos[2] + z * half_width],
            mass=0.0,
            contype=0,
            conaffinity=0,
            rgba=tip.rgba,
        )
        add_contact_pair(spec, name, surface_geom, parameters, _pair(index))
    # What holds the balls, only to be looked at: behind their middles, so that they are what touches.
    thick = 0.5 * tip.size[0]
    tip.parent.add_geom(
        name=f"{tip_geom}_plate",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[thick, half_width, half_width],
        pos=[tip.pos[0] - thick, tip.pos[1], tip.pos[2]],
        mass=0.0,
        contype=0,
        conaffinity=0,
        group=1,
        rgba=_PLATE,
    )


def tune_foot(model: mujoco.MjModel, parameters: ContactParameters) -> None:
    """Write the solver parameters of all five pairs, each with its share of the contact's."""
    mass = effective_mass(model, PAIR_NAME)
    share = dataclasses.replace(
        parameters,
        stiffness=parameters.stiffness / BALLS,
        damping=parameters.normal_damping(mass) / BALLS,
        adhesion=parameters.adhesion / BALLS,
    )
    for name in (PAIR_NAME, *(_pair(index) for index in range(len(CORNERS)))):
        tune_contact_pair(model, share, name)


def _pair(index: int) -> str:
    return f"{PAIR_NAME}_{index}"
