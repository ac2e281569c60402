"""The plant over one control period, linearised by differences of the engine's own steps."""

from __future__ import annotations

import copy
import dataclasses
from collections.abc import Callable
from functools import partial

import mujoco
import numpy as np

from skylimb.base.errors import ConfigError
from skylimb.simulation.contact import tune_contact_pair
from skylimb.simulation.robot_bodies import TIP_SITE
from skylimb.simulation.surfaces.geom import GEOM
from skylimb.studies.verification.stability.point import OperatingPoint

STEP = 1e-8
"""Of the finite differences."""

_PUSH = 1e-3
"""N, of the same."""


def plant_transition(point: OperatingPoint) -> tuple[np.ndarray, np.ndarray]:
    """A and B of d x[k+1] = A d x[k] + B d u[k], with x the tangent (position, velocity, activation).

    The engine's own `mjd_transitionFD` declines models whose sensors keep a history, as ours does, so its
    steps are differenced here, the same way.

    Args:
        point: the state.

    Returns:
        A, (n, n) with n = 2 nv + na, and B, (n, nu + nv).
    """
    model, nv, nu = point.plant.model, int(point.plant.model.nv), int(point.plant.model.nu)
    size = 2 * nv + int(model.na)

    def move(direction: np.ndarray, data: mujoco.MjData, step: float) -> None:
        mujoco.mj_integratePos(model, data.qpos, step * direction[:nv], 1.0)
        data.qvel[:] += step * direction[nv : 2 * nv]
        data.act[:] += step * direction[2 * nv : size]
        data.ctrl[:] += step * direction[size : size + nu]
        data.qfrc_applied[:] += step * direction[size + nu :]

    both = np.stack([_slope(point, partial(move, row), STEP) for row in np.eye(size + nu + nv)], axis=1)
    return both[:, :size], both[:, size:]


def push_response(point: OperatingPoint, axes: np.ndarray) -> np.ndarray:
    """Derivative of the tangent state over one control period by a force on the tip, held over it, (n, k).

    Args:
        point: the state.
        axes: directions of the force, W, (k, 3).
    """
    model = point.plant.model
    site = model.site(TIP_SITE).id
    body = int(model.site_bodyid[site])

    def push(axis: np.ndarray, data: mujoco.MjData, step: float) -> None:
        lever = data.site_xpos[site] - data.xipos[body]
        data.xfrc_applied[body] += step * np.concatenate([axis, np.cross(lever, axis)])

    return np.stack([_slope(point, partial(push, axis), _PUSH) for axis in np.asarray(axes)], axis=1)


def _slope(
    point: OperatingPoint,
    change: Callable[[mujoco.MjData, float], None],
    step: float,
) -> np.ndarray:
    """Derivative of the tangent state over one control period by what `change` does in steps, (n,)."""
    ends = []
    for signed in (step, -step):
        data = point.data()
        data.ctrl[:], data.qfrc_applied[:] = np.split(point.controls, [int(point.plant.model.nu)])
        change(data, signed)
        mujoco.mj_step(point.plant.model, data, point.plant.substeps)
        ends.append((data.qpos, data.qvel, data.act))
    return tangent_difference(point.plant.model, *ends) / (2.0 * step)


def tangent_difference(
    model: mujoco.MjModel, a: tuple[np.ndarray, ...], b: tuple[np.ndarray, ...]
) -> np.ndarray:
    """How far a state (qpos, and what else is plain numbers) is from another one, in the tangent of b."""
    turned = np.zeros(model.nv)
    mujoco.mj_differentiatePos(model, turned, 1.0, b[0], a[0])
    return np.concatenate([turned, *(one - other for one, other in zip(a[1:], b[1:], strict=True))])


def tangent_map(model: mujoco.MjModel, qpos: np.ndarray) -> np.ndarray:
    """Derivative of qpos by the tangent of the position, (nq, nv): what a small turn does to a quaternion."""

    def moved(direction: np.ndarray) -> np.ndarray:
        there = qpos.copy()
        mujoco.mj_integratePos(model, there, direction, STEP)
        return there

    return np.stack([moved(row) - moved(-row) for row in np.eye(model.nv)], axis=1) / (2.0 * STEP)


def with_stiffness(point: OperatingPoint, stiffness: float) -> OperatingPoint:
    """The same state on a surface of another stiffness, N/m, which pushes as hard.

    The surface is moved along its normal by the difference of the two indentations, so that the robot and all
    that the controller remembers stay as they are.

    Raises:
        ConfigError: when the pen does not touch, or the physics step cannot carry the stiffness.
    """
    plant = point.plant
    data = point.data()
    if data.ncon == 0 or data.contact[0].dist >= 0.0:
        raise ConfigError("the pen does not touch at this point, so a stiffness has no meaning")
    contact = data.contact[0]
    model = copy.copy(plant.model)
    parameters = plant.surface.contact
    tune_contact_pair(model, dataclasses.replace(parameters, stiffness=stiffness))
    ratio = _pair_stiffness(plant.model) / _pair_stiffness(model)
    away = np.asarray(contact.frame[0:3])  # from the surface to the pen
    # A surface that does not move is part of the world, so its place is in W.
    model.geom_pos[model.geom(GEOM).id] += away * (-contact.dist) * (ratio - 1.0)
    return dataclasses.replace(point, plant=dataclasses.replace(plant, model=model))


def _pair_stiffness(model: mujoco.MjModel) -> float:
    return -float(model.pair_solref[0, 0])
