"""A peg in a chamfered hole: touches in several places that hold each other's balance, and the time step."""

from __future__ import annotations

from functools import cache

import mujoco
import numpy as np

from skylimb.simulation.surfaces import Hole
from skylimb.studies.verification.drawing import family, lines
from skylimb.studies.verification.rig import BODY, released, scene, touches
from skylimb.studies.verification.row import Evidence, evidence, sweep

_MASS, _GYRATION, _RADIUS, _LENGTH = 2.0, 0.1, 0.015, 0.12
_FORCES = np.array([1.0, 3.0, 10.0])
_FRICTIONS = np.array([0.1, 0.3, 0.6])


def peg_sinks() -> Evidence:
    """On the floor of the hole it sinks in by F / k."""
    stiffnesses = np.array([1000.0, 5000.0, 20000.0])
    found = 100.0 * sweep(_depth_on_floor, stiffnesses, _FORCES)
    drawn = family(_FORCES, found, [f"k = {k:g} N/m" for k in stiffnesses])
    return evidence(
        "peg_sinks",
        "On the floor of a hole a peg sinks in by F/k.",
        found,
        100.0,
        0.5,
        "% of F/k",
        lines(drawn, "force (N)", "depth (% of F/k)", xscale="log"),
    )


def peg_balances() -> Evidence:
    """Pushed and turned in the hole it comes to rest on several touches, which hold it."""
    touching, left, _ = _rests().T
    drawn = lines([(touching, 100.0 * left, "o", "")], "touches", "force or torque left over (%)")
    claim = "Pushed and turned in its hole a peg rests on several touches that balance the load."
    return evidence("peg_balances", claim, 100.0 * left, 1.0, 0.0, "% of the load", drawn, bound="below")


def peg_cone() -> Evidence:
    """No touch of those has more friction than mu times its pressure."""
    shares = np.sort(100.0 * _rests()[:, 2])
    drawn = lines(
        [(np.arange(shares.size), shares, "o", "")], "case", "friction of the worst touch (% of mu N)"
    )
    claim = "No touch of a peg in its hole has more friction than mu N."
    return evidence("peg_cone", claim, shares, 100.0, 0.1, "% of mu N", drawn, bound="below")


def peg_chamfer() -> Evidence:
    """Pushed on along the hole's axis, the chamfer of 45 degrees pushes it aside with (1 - mu) / (1 + mu)."""
    found, theory = sweep(_aside, _FRICTIONS), (1.0 - _FRICTIONS) / (1.0 + _FRICTIONS)
    drawn = [(_FRICTIONS, found, "o", "measured"), (_FRICTIONS, theory, "-", "(1 - mu) / (1 + mu)")]
    return evidence(
        "peg_chamfer",
        "A chamfer of 45 degrees pushes a peg aside with (1 - mu) / (1 + mu) of its push.",
        found,
        theory,
        0.01,
        "",
        lines(drawn, "friction", "sideways over axial force"),
    )


def peg_step() -> Evidence:
    """From the chamfer into the hole, down to its floor: where it rests does not depend on the time step."""
    steps = np.array([2e-3, 1e-3, 5e-4, 2.5e-4])
    places = sweep(_inserted, steps, _FORCES)
    far = 1e6 * np.linalg.norm(places[:-1] - places[-1], axis=-1)
    drawn = family(_FORCES, far, [f"{1e3 * step:g} ms" for step in steps[:-1]])
    return evidence(
        "peg_step",
        "A peg that slides down a chamfer into its hole rests there with steps of 0.25 to 2 ms alike.",
        far,
        50.0,
        0.0,
        "µm",
        lines(drawn, "force (N)", "place beside that of 0.25 ms (µm)", xscale="log"),
        bound="below",
    )


@cache
def _rests() -> np.ndarray:
    """What `_rest` finds of random loads in the hole, (n, 3)."""
    rng = np.random.default_rng(3)
    return np.array([_rest(rng, float(friction)) for friction in _FRICTIONS for _ in range(10)])


def _rest(rng: np.random.Generator, friction: float) -> tuple[int, float, float]:
    """Of a peg at rest: its touches, what is left of the load, and the friction of its worst touch.

    The second is the sum of load and contact forces, or torques, as a share of the load; the third is over mu
    times that touch's pressure.
    """
    model, data = _rig(_hole(friction=friction), depth=0.05, damper=1.0)
    force = np.array([rng.uniform(1.0, 5.0), *rng.uniform(-3.0, 3.0, 2)])
    torque = np.array([0.0, *rng.uniform(-0.2, 0.2, 2)])
    data.body(BODY).xfrc_applied[:] = [*force, *torque]
    mujoco.mj_step(model, data, 4000)
    pushes, place = touches(model, data), data.body(BODY).xpos
    # With the damper's share, where it still creeps.
    total = np.concatenate([force, torque]) + data.qfrc_passive
    for push in pushes:
        total += [*push.force, *np.cross(push.point - place, push.force)]
    pushed = float(np.linalg.norm(force))
    turned = float(np.linalg.norm(torque)) + pushed * _RADIUS
    left = max(np.linalg.norm(total[:3]) / pushed, np.linalg.norm(total[3:]) / turned)
    cone = max((push.friction / (friction * push.pressure) for push in pushes), default=np.inf)
    return len(pushes), float(left), cone


def _depth_on_floor(stiffness: float, force: float) -> float:
    """Depth over F / k on the floor."""
    hole = _hole(stiffness=stiffness)
    model, data = _rig(hole, depth=hole.depth)
    data.body(BODY).xfrc_applied[0] = force
    mujoco.mj_step(model, data, 4000)
    return float((data.qpos[0] - hole.depth) * stiffness / force)


def _aside(friction: float) -> float:
    """Sideways over axial force while it slides in on the chamfer, its attitude held."""
    hole = _hole(friction=friction)
    offset = hole.radius - _RADIUS + 0.7 * hole.chamfer
    model, data = _rig(hole, depth=0.0, aside=offset)
    ratios = []
    for k in range(500):
        # It is led down along the slope, 0.5 mm deep in it.
        x = 1e-5 * k
        data.qpos[:3] = [x + _front(hole, offset), offset - x, 0.0]
        data.qpos[3:], data.qvel[:] = [1.0, 0.0, 0.0, 0.0], [0.01, -0.01, 0.0, 0.0, 0.0, 0.0]
        mujoco.mj_forward(model, data)
        total = np.sum([push.force for push in touches(model, data)], axis=0)
        ratios.append(total[1] / total[0])
    return float(np.mean(ratios))


def _front(hole: Hole, offset: float) -> float:
    """Where its front is when its round end presses 0.5 mm into the chamfer, m behind the face."""
    # The round end touches the slope where its own slope is 45 degrees.
    centre = hole.radius + hole.chamfer - offset - _RADIUS * np.sqrt(2.0)
    return float(centre + _RADIUS + 0.5e-3 * np.sqrt(2.0))


def _inserted(timestep: float, force: float) -> np.ndarray:
    """Where it rests on the floor after a push from the chamfer, m, (3,)."""
    hole = _hole(friction=0.2)
    model, data = _rig(hole, depth=-0.005, aside=0.008, timestep=timestep, damper=1.0)
    body = data.body(BODY)
    for _ in range(round(4.0 / timestep)):
        # Springs hold its attitude and, softly, its line.
        turn = 2.0 * data.qpos[4:7]
        body.xfrc_applied[:] = [force, 10.0 * (0.008 - data.qpos[1]), 0.0, *(-5.0 * turn)]
        mujoco.mj_step(model, data)
    return np.array(data.qpos[:3])


def _hole(friction: float = 0.4, stiffness: float = 5000.0) -> Hole:
    return Hole(position=(0.0, 0.0, 0.0), friction=friction, stiffness=stiffness, damping_ratio=1.0)


def _rig(
    hole: Hole, depth: float, aside: float = 0.0, timestep: float = 1e-3, damper: float = 0.0
) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """A free body with a peg along x, its front `depth` (m) behind the hole's face, `aside` of its axis.

    A light damper lets it come to rest: `damper` times 20 N s/m and 0.5 N m s/rad.
    """
    # The body's origin is the peg's front.
    spec, body, parts = scene(
        hole, _MASS, _GYRATION**2 * _MASS, [depth, aside, 0.0], radius=1e-3, timestep=timestep
    )
    body.add_freejoint()
    model, data = released(spec, hole, parts, peg=(_RADIUS, _LENGTH))
    model.dof_damping[:] = np.repeat([20.0, 0.5], 3) * damper
    return model, data
