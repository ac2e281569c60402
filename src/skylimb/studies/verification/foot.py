"""A foot of five balls: how deep it sinks, how it rocks, when it tips over its edge, and how it slides."""

from __future__ import annotations

import mujoco
import numpy as np

from skylimb.simulation.surfaces import Board
from skylimb.simulation.tool import BALLS, CORNERS
from skylimb.studies.verification.drawing import family, lines
from skylimb.studies.verification.rig import BODY, RADIUS, released, scene, touches
from skylimb.studies.verification.row import Evidence, evidence, sweep

_MASS, _GYRATION, _STIFFNESS = 2.0, 0.1, 5000.0
_HALF_WIDTHS = np.array([0.02, 0.05, 0.1])
_FORCES = np.array([1.0, 3.0, 10.0])
_WIDTHS = [f"h = {1e3 * half:g} mm" for half in _HALF_WIDTHS]


def foot_rocks() -> Evidence:
    """Under N and a torque it sinks in by N / k and turns by T / (4/5 k h^2)."""
    found = 100.0 * sweep(_rocked, _HALF_WIDTHS, _FORCES)
    drawn = [
        *family(_FORCES, found[..., 0], [f"depth over N/k, {width}" for width in _WIDTHS]),
        *family(_FORCES, found[..., 1], [f"turn over T/(4/5 k h²), {width}" for width in _WIDTHS]),
    ]
    return evidence(
        "foot_rocks",
        "A foot of five balls sinks in by F/k and rocks by T / (4/5 k h²).",
        found,
        100.0,
        0.5,
        "% of theory",
        lines(drawn, "force (N)", "% of theory", xscale="log"),
    )


def foot_tips() -> Evidence:
    """It lies flat up to a torque of h N about an edge, and tips beyond."""
    shares = np.array([0.8, 0.9, 0.96, 1.04, 1.1, 1.2])
    turned = sweep(_tipped, _HALF_WIDTHS, shares)
    # The torque at which it tips lies between the last that it bears and the first that it does not.
    limits = [50.0 * (shares[row].min() + shares[~row].max()) for row in turned]
    drawn = family(100.0 * shares, turned.astype(float), _WIDTHS)
    return evidence(
        "foot_tips",
        "A foot tips over its edge at a torque of h N.",
        limits,
        100.0,
        8.0,
        "% of h N",
        lines(drawn, "torque (% of h N)", "tips (0 or 1)"),
        cases=turned.size,
    )


def foot_slides() -> Evidence:
    """Whatever the torque, it slides when it is dragged with mu N."""
    frictions, shares = np.array([0.2, 0.4, 0.7]), np.array([0.0, 0.3, 0.6])
    drags = sweep(_drag, frictions, shares)
    drawn = family(frictions, drags.T, [f"torque {share:g} h N" for share in shares])
    return evidence(
        "foot_slides",
        "Sliding, a foot drags with mu N, whatever torque it carries.",
        100.0 * drags / frictions[:, None],
        100.0,
        0.5,
        "% of mu",
        lines(drawn, "friction", "drag over normal force"),
    )


def _pressed(
    half_width: float, force: float, torque: float, steps: int, friction: float = 0.4
) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """A free body on a foot after some steps under a force (N) along x and a torque (N m) about z.

    It starts before a board at x = 0, as deep as the force presses it in.
    """
    board = Board(position=(0.0, 0.0, 0.0), friction=friction, stiffness=_STIFFNESS, damping_ratio=1.0)
    at = [-RADIUS + force / _STIFFNESS, 0.0, 0.0]
    spec, body, parts = scene(board, _MASS, _GYRATION**2 * _MASS, at)
    body.add_freejoint()
    model, data = released(spec, board, parts, foot=half_width)
    data.body(BODY).xfrc_applied[:] = [force, 0.0, 0.0, 0.0, 0.0, torque]
    mujoco.mj_step(model, data, steps)
    return model, data


def _rocked(half_width: float, force: float) -> tuple[float, float]:
    """Depth over N / k, and turn over T / (4/5 k h^2)."""
    # A fifth of the torque that lifts the far balls, so that all five stay in touch.
    torque = 0.2 * force * half_width * len(CORNERS) / BALLS
    _, data = _pressed(half_width, force, torque, 3000)
    rocking = len(CORNERS) / BALLS * _STIFFNESS * half_width**2
    return (data.qpos[0] + RADIUS) * _STIFFNESS / force, 2.0 * data.qpos[6] * rocking / torque


def _tipped(half_width: float, share: float) -> bool:
    """Whether a share of the torque that tips it has turned it far after 2 s."""
    _, data = _pressed(half_width, 3.0, share * 3.0 * half_width, 2000)
    return abs(2.0 * float(data.qpos[6])) > 0.2


def _drag(friction: float, share: float) -> float:
    """Drag over normal force of a foot that slides at 0.1 m/s with a share of the torque that tips it."""
    half_width, force = 0.05, 3.0
    model, data = _pressed(half_width, force, share * force * half_width, 500, friction)
    drags = []
    for _ in range(40):
        # Its speed is held; the drag turns it slowly, so the look is short.
        data.qvel[2] = 0.1
        mujoco.mj_step(model, data)
        total = np.sum([touch.force for touch in touches(model, data)], axis=0)
        drags.append(abs(total[2]) / abs(total[0]))
    return float(np.mean(drags))
