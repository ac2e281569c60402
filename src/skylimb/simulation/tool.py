"""The tool at the tip: the pen's ball alone, a foot, or a peg.

A foot is four balls around the tip's own, in the plane across the tool's x axis, so that the tip can lie
flat on a surface and carry a torque. Each of the five touches by a pair of its own, with a fifth of the
surface's stiffness and damping: together they are as stiff as the tip alone would be. Pressed flat with N
they give a torque of up to half_width N about an edge, and they slide at mu N whatever the torque.

A peg is a round bar with a round end, which may touch the walls of a hole in several places. It stands in the
place of the tip's ball, its end as far out as the ball's. Each wall touches it by a pair of its own with the
surface's stiffness; the engine gives a bar on a flat wall two touches, one near either end.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import mujoco
import numpy as np

from skylimb.base.rotations import quaternion_from_rotation
from skylimb.robots.description import Tip
from skylimb.simulation.contact import (
    add_contact_pair,
    effective_mass,
    pair_compliance,
    tune_contact_pair,
)
from skylimb.simulation.contact_keys import PAIR_NAME, TIP_GEOM, ContactParameters
from skylimb.simulation.plant_config import Peg

CORNERS = ((1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0))
"""Directions of a foot's corners along the tool's y and z axes."""

BALLS = 1 + len(CORNERS)
"""How many of a foot's share the load."""

PEG_GEOM = "tip_peg"
_PLATE = (0.35, 0.37, 0.40, 1.0)


def add_tool(
    spec: mujoco.MjSpec,
    tip: Tip,
    surface_geoms: Sequence[str],
    parameters: ContactParameters,
    *,
    foot: float | None = None,
    peg: Peg | None = None,
) -> None:
    """Put a tool over the tip's ball, and let it and the surface collide; `tune_tool` completes it.

    Args:
        spec: with the tip's ball in it.
        tip: of the robot's description.
        surface_geoms: all that is touched; a foot and a pen touch the first.
        parameters: of the whole contact.
        foot: half the side of a foot, m.
        peg: radius and length of a peg, m.
    """
    ball, pairs = spec.geom(TIP_GEOM), [(TIP_GEOM, surface_geoms[0])]
    if foot is not None:
        pairs += [(name, surface_geoms[0]) for name in _add_foot(ball, tip, foot)]
    if peg is not None:
        _add_peg(ball, tip, peg)
        pairs = [(PEG_GEOM, geom) for geom in surface_geoms]
    for index, (mine, other) in enumerate(pairs):
        name = PAIR_NAME if index == 0 else f"{PAIR_NAME}_{index}"
        add_contact_pair(spec, mine, other, parameters, name)


def _add_foot(ball: mujoco.MjsGeom, tip: Tip, half_width: float) -> list[str]:
    """Put a ball like the tip's at each corner; their names."""
    names = [f"{TIP_GEOM}_{index}" for index in range(len(CORNERS))]
    for name, (y, z) in zip(names, CORNERS, strict=True):
        ball.parent.add_geom(
            name=name,
            type=ball.type,
            size=ball.size,
            pos=ball.pos + half_width * (tip.R @ (0.0, y, z)),
            mass=0.0,
            contype=0,
            conaffinity=0,
            rgba=ball.rgba,
        )
    # What holds the balls, only to be looked at: behind their middles, so that they are what touches.
    thick = 0.5 * ball.size[0]
    ball.parent.add_geom(
        name=f"{TIP_GEOM}_plate",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[thick, half_width, half_width],
        pos=ball.pos - thick * tip.R[:, 0],
        quat=quaternion_from_rotation(tip.R),
        mass=0.0,
        contype=0,
        conaffinity=0,
        group=1,
        rgba=_PLATE,
    )
    return names


def _add_peg(ball: mujoco.MjsGeom, tip: Tip, peg: Peg) -> None:
    radius, length = peg
    along = tip.along
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


def tune_tool(model: mujoco.MjModel, parameters: ContactParameters, foot: bool = False) -> None:
    """Write the solver parameters of all pairs of the tool; those of a foot share the contact's stiffness.

    Raises:
        ConfigError: when the time step cannot carry the whole contact.
    """
    if foot:
        pair_compliance(model, parameters)  # flat, all of it acts at once
        parameters = dataclasses.replace(
            parameters,
            stiffness=parameters.stiffness / BALLS,
            damping=parameters.normal_damping(effective_mass(model)) / BALLS,
            adhesion=parameters.adhesion / BALLS,
        )
    for pair in range(model.npair):
        tune_contact_pair(model, parameters, model.pair(pair).name)
