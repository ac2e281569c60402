"""A foot of five balls: how deep it sinks, how it rocks, when it tips over its edge, and how it slides."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from skylimb.simulation.contact import add_contact_pair, set_contact_options
from skylimb.simulation.foot import BALLS, CORNERS, add_foot, tune_foot
from skylimb.simulation.surface_bodies import add_surface
from skylimb.simulation.surfaces import Board
from skylimb.studies.verification.drawing import curves
from skylimb.studies.verification.row import Evidence, Row, worst

_MASS, _GYRATION, _RADIUS = 2.0, 0.1, 0.004
_HALF_WIDTHS = np.array([0.02, 0.05, 0.1])
_FORCES = np.array([1.0, 3.0, 10.0])


def foot_rocks() -> Evidence:
    """Under N and a torque it sinks in by N / k and turns by T / (4/5 k h^2)."""
    found = np.empty((2, len(_HALF_WIDTHS), len(_FORCES)))
    for i, half in enumerate(_HALF_WIDTHS):
        for j, force in enumerate(_FORCES):
            board = _board()
            # A fifth of the torque that lifts the far balls, so that all five stay in touch.
            torque = 0.2 * force * half * len(CORNERS) / BALLS
            depth, turn = _at_rest(board, half, force, torque)
            rocking = len(CORNERS) / BALLS * board.stiffness * half**2
            found[:, i, j] = depth * board.stiffness / force, turn * rocking / torque
    measured, expected = worst(100.0 * found, 100.0)

    def draw(axes: Any) -> None:
        for name, values in zip(("depth over N/k", "turn over T/(4/5 k h²)"), found, strict=True):
            for half, row in zip(_HALF_WIDTHS, values, strict=True):
                axes.plot(_FORCES, 100.0 * row, "o-", label=f"{name}, h = {1e3 * half:g} mm")
        axes.set(xlabel="force (N)", ylabel="% of theory", xscale="log")
        axes.legend(fontsize="small")

    claim = "A foot of five balls sinks in by F/k and rocks by T / (4/5 k h²)."
    return Evidence(Row("foot_rocks", claim, measured, expected, 0.5, "% of theory", cases=found.size), draw)


def foot_tips() -> Evidence:
    """It lies flat up to a torque of h N about an edge, and tips beyond."""
    shares = np.array([0.8, 0.9, 0.96, 1.04, 1.1, 1.2])
    turned = np.array(
        [[_tipped(_board(), half, 3.0, share * 3.0 * half) for share in shares] for half in _HALF_WIDTHS]
    )
    # The torque at which it tips lies between the last that it bears and the first that it does not.
    limits = [0.5 * (shares[row].min() + shares[~row].max()) for row in turned]
    measured, expected = worst(100.0 * np.array(limits), 100.0)

    names = [f"h = {1e3 * half:g} mm" for half in _HALF_WIDTHS]
    draw = curves(100.0 * shares, turned.astype(float), names, ("torque (% of h N)", "tips (0 or 1)"))
    claim = "A foot tips over its edge at a torque of h N."
    return Evidence(Row("foot_tips", claim, measured, expected, 8.0, "% of h N", cases=turned.size), draw)


def foot_slides() -> Evidence:
    """Whatever the torque, it slides when it is dragged with mu N."""
    frictions = np.array([0.2, 0.4, 0.7])
    drags = np.array([[_drag(mu, share) for share in (0.0, 0.3, 0.6)] for mu in frictions])
    measured, expected = worst(100.0 * drags / frictions[:, None], 100.0)

    names = [f"torque {share:g} h N" for share in (0.0, 0.3, 0.6)]
    draw = curves(frictions, drags.T, names, ("friction", "drag over normal force"))
    claim = "Sliding, a foot drags with mu N, whatever torque it carries."
    return Evidence(Row("foot_slides", claim, measured, expected, 0.5, "% of mu", cases=drags.size), draw)


def _board(friction: float = 0.4) -> Board:
    """A board at x = 0."""
    return Board(position=(0.0, 0.0, 0.0), friction=friction, stiffness=5000.0, damping_ratio=1.0)


def _rig(board: Board, half_width: float, force: float) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """A free body before a board at x = 0, its foot as deep as `force` presses it in."""
    spec = mujoco.MjSpec()
    set_contact_options(spec, 1e-3)
    spec.option.gravity = [0.0, 0.0, 0.0]
    parts = add_surface(spec, board)
    body = spec.worldbody.add_body(name="body", pos=[-_RADIUS + force / board.stiffness, 0.0, 0.0])
    body.add_freejoint()
    body.explicitinertial = True
    body.mass, body.inertia, body.ipos = _MASS, [_GYRATION**2 * _MASS] * 3, [0.0, 0.0, 0.0]
    body.add_geom(
        name="tip",
        type=mujoco.mjtGeom.mjGEOM_SPHERE,
        size=[_RADIUS, 0.0, 0.0],
        mass=0.0,
        contype=0,
        conaffinity=0,
    )
    add_contact_pair(spec, "tip", parts.geom, board.contact)
    add_foot(spec, "tip", half_width, parts.geom, board.contact)
    model = spec.compile()
    tune_foot(model, board.contact)
    return model, mujoco.MjData(model)


def _at_rest(board: Board, half_width: float, force: float, torque: float) -> tuple[float, float]:
    """Depth (m) and turn about z (rad) under a force along x and a torque about z."""
    model, data = _rig(board, half_width, force)
    data.body("body").xfrc_applied[:] = [force, 0.0, 0.0, 0.0, 0.0, torque]
    mujoco.mj_step(model, data, 3000)
    return float(data.qpos[0]) + _RADIUS, 2.0 * float(data.qpos[6])


def _tipped(board: Board, half_width: float, force: float, torque: float) -> bool:
    """Whether it has turned far after 2 s."""
    model, data = _rig(board, half_width, force)
    data.body("body").xfrc_applied[:] = [force, 0.0, 0.0, 0.0, 0.0, torque]
    mujoco.mj_step(model, data, 2000)
    return abs(2.0 * float(data.qpos[6])) > 0.2


def _drag(friction: float, share: float) -> float:
    """Drag over normal force of a foot that slides at 0.1 m/s with a share of the torque that tips it."""
    half, force = 0.05, 3.0
    board = _board(friction)
    model, data = _rig(board, half, force)
    data.body("body").xfrc_applied[:] = [force, 0.0, 0.0, 0.0, 0.0, share * force * half]
    mujoco.mj_step(model, data, 500)
    drags = []
    for _ in range(40):
        # A hand holds its speed; the drag turns it slowly, so the look is short.
        data.qvel[2] = 0.1
        mujoco.mj_step(model, data)
        total = np.zeros(3)
        for index in range(data.ncon):
            wrench = np.zeros(6)
            mujoco.mj_contactForce(model, data, index, wrench)
            total += data.contact[index].frame.reshape(3, 3).T @ wrench[:3]
        drags.append(abs(total[2]) / abs(total[0]))
    return float(np.mean(drags))
