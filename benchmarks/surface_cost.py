"""Cost of a physics step on every surface against the flat board, with the paper's robot touching it.

Boards of the same slope stand beside the surfaces whose touch is not level, so that the part of the shape
shows.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np

import skylimb
from skylimb.simulation.plant import build_plant
from skylimb.simulation.plant_config import PlantConfig
from skylimb.simulation.surfaces import (
    Board,
    Corrugated,
    Cylinder,
    HeightMap,
    Pipe,
    Ramp,
    Ridge,
    SineWall,
    Sphere,
    Step,
    Surface,
    surface_from_mapping,
)

OWN = Path(__file__).parents[1] / "examples" / "surfaces"
RELIEF = tuple(tuple(float(np.sin(0.9 * i) * np.cos(0.7 * j)) for j in range(12)) for i in range(12))
SURFACES: dict[str, Surface] = {
    "board": Board(),
    "board, 27.6 deg": Board(slope=0.4818),
    "board, 45 deg": Board(slope=0.7854),
    "moving board": Board(advance_distance=0.1),
    "cylinder": Cylinder(),
    "hollow cylinder": Cylinder(concave=True, size=(1.4, 2.0)),
    "sphere": Sphere(),
    "pipe": Pipe(),
    "sine (27.6 deg)": SineWall(),
    "corrugated (36.7 deg)": Corrugated(),
    "step (45 deg)": Step(),
    "ridge": Ridge(),
    "ramp (14 deg)": Ramp(),
    "height map": HeightMap(heights=RELIEF, size=(1.2, 1.2), relief=0.03),
    "own saddle": surface_from_mapping({"kind": str(OWN / "saddle.py")}),
    "own torus": surface_from_mapping({"kind": str(OWN / "torus.py")}),
}


def touching(surface: Surface) -> tuple[mujoco.MjModel, mujoco.MjData, np.ndarray]:
    """The robot with its tip pressed half a millimetre into the surface's origin, without gravity."""
    model = build_plant(skylimb.load_robot("hydrus_xi_quad"), surface, PlantConfig(), 0.005).model
    model.opt.gravity[:] = 0.0
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    start = int(model.jnt_qposadr[model.joint("root").id])
    wanted = surface.to_world(np.zeros(3)) - 0.0035 * np.asarray(surface.contact_axis)
    data.qpos[start : start + 3] += wanted - data.site("tip").xpos
    mujoco.mj_forward(model, data)
    if data.ncon != 1:
        raise RuntimeError(f"the tip touches surface '{surface.kind}' {data.ncon} times")
    return model, data, data.qpos.copy()


def thread_seconds(work: Callable[[], None]) -> float:
    """Processor time of a piece of work, s: what else runs on the machine has little part in it."""
    start = time.thread_time()
    work()
    return time.thread_time() - start


def measure(repeats: int = 15) -> dict[str, float]:
    """Best time of a step, us, by surface; they take turns, so that a busy machine harms all alike."""
    scenes = {name: touching(surface) for name, surface in SURFACES.items()}
    best = dict.fromkeys(scenes, float("inf"))
    for _ in range(repeats):
        for name, (model, data, pose) in scenes.items():

            def press(
                model: mujoco.MjModel = model, data: mujoco.MjData = data, pose: np.ndarray = pose
            ) -> None:
                for _ in range(20):
                    data.qpos[:], data.qvel[:] = pose, 0.0
                    mujoco.mj_step(model, data, nstep=20)

            best[name] = min(best[name], thread_seconds(press) / 400 * 1e6)
    return best


if __name__ == "__main__":
    times = measure()
    for name, micros in times.items():
        print(f"{name:24s} {micros:6.2f} us a step  {100 * (micros / times['board'] - 1):+6.1f} %")
