"""What a robot can do, in lines for a reader and in tables for a program."""

from __future__ import annotations

from typing import Any

import numpy as np

from skylimb.robots.equilibrium_results import Held, NotHeld
from skylimb.studies.planning.feasible_wrench import FeasibleWrench
from skylimb.studies.planning.zonotope import Polytope

_MOST_CORNERS = 12
"""Rotors up to which the corners of all wrenches are worked out."""


def summary(feasible: FeasibleWrench) -> dict[str, str]:
    """What it can do, a line each: name and value with unit."""
    state, torques, level = feasible.state, feasible.hover_torques, feasible.level_forces
    low, high = feasible.robot.thrust_limits()
    rank, thrusts = feasible.wrenches.dimension, state.hover_thrusts
    actuated = "all six directions" if rank == 6 else f"{rank} of six directions; it tilts for the others"
    lines = {
        "joint angles, rad": _listed(feasible.joint_angles, 3),
        "vectoring angles, rad": _listed(feasible.vectoring_angles, 3) or "none",
        "hover thrusts, N": f"{_listed(thrusts, 1)} of {low.min():g} .. {high.max():g}",
        "rotors give, angles held": actuated,
        "FCTmin, N m": f"{feasible.fct_min:.2f} (about any axis; thrusts from 0, any force)",
        "FCFmin, N": f"{feasible.fcf_min:.2f} (beside the weight, any way; thrusts from 0, any torque)",
    }
    if torques is not None:
        least = max(torques.margin(np.zeros(3)), 0.0)
        lines["torque about any axis in hover, N m"] = f"{least:.2f}"
        lines["volume of the torques in hover"] = f"{torques.volume:.4g} {_unit('N m', torques.dimension)}"
    if level is not None:
        least = max(level.margin(np.zeros(3)), 0.0)
        lines["force in any direction while level, N"] = f"{least:.2f}"
        lines["volume of the forces while level"] = f"{level.volume:.4g} {_unit('N', level.dimension)}"
    lines["volume of the wrenches"] = (
        f"{feasible.volume:.4g} {_unit('N', rank)} (torques over {feasible.length:.3f} m)"
    )
    return lines


def as_tables(feasible: FeasibleWrench) -> dict[str, Any]:
    """All of it as plain tables: numbers, corners and faces (outward normal and offset) of every set."""
    sets = {
        "hover_torques": feasible.hover_torques,
        "level_forces": feasible.level_forces,
        "level_pushes": feasible.level_pushes,
    }
    wrenches = feasible.wrenches
    few = feasible.robot.n_rotors <= _MOST_CORNERS
    return {
        "robot": feasible.robot.name,
        "joint_angles": feasible.joint_angles.tolist(),
        "vectoring_angles": feasible.vectoring_angles.tolist(),
        "hover_thrusts": feasible.state.hover_thrusts.tolist(),
        "allocation": feasible.state.allocation_C.tolist(),
        "fct_min": feasible.fct_min,
        "fcf_min": feasible.fcf_min,
        "length": feasible.length,
        "wrenches": {
            "dimension": wrenches.dimension,
            "volume": feasible.volume,
            "axes": wrenches.axes.tolist(),
            "normals": wrenches.normals.tolist(),
            "offsets": wrenches.offsets.tolist(),
            "vertices": wrenches.vertices.tolist() if few else [],
        },
        **{name: None if one is None else _slice_tables(one) for name, one in sets.items()},
    }


def push_tables(direction: np.ndarray, found: dict[str, Held | NotHeld]) -> dict[str, Any]:
    """The greatest pushes along a direction, by what was asked: N, and what ends each; null where none is.

    What then missed says whether a limit is in the way, or the search itself came to no end.
    """
    return {
        "direction": direction.tolist(),
        **{
            name: {
                "force": one.force if one else None,
                "ends": str(one.limit) if one.limit is not None else None,
                "missed": None if one else str(one),
                "vectoring_angles": one.vectoring_angles.tolist() if one else None,
            }
            for name, one in found.items()
        },
    }


def _slice_tables(one: Polytope) -> dict[str, Any]:
    return {
        "dimension": one.dimension,
        "volume": one.volume,
        "origin": one.origin.tolist(),
        "axes": one.axes.tolist(),
        "normals": one.normals.tolist(),
        "offsets": one.offsets.tolist(),
        "vertices": one.vertices.tolist(),
    }


def _listed(values: np.ndarray, digits: int) -> str:
    return ", ".join(f"{value:.{digits}f}" for value in values)


def _unit(unit: str, power: int) -> str:
    if power == 1:
        return unit
    return f"({unit})^{power}" if " " in unit else f"{unit}^{power}"
