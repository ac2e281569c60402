"""Steps a second of the scene in many worlds at once, by mujoco-warp on a GPU.

    warp-env/bin/python benchmarks/rivals/fly_mujoco_warp.py --save out/warp
    warp-env/bin/python benchmarks/rivals/batch_mujoco_warp.py out/warp --worlds 1 256 4096

in the same environment. Each world begins in touch, at the state of the flight that was kept, with rates that
differ by a thousandth between worlds, and is pushed by the forces of that flight, step by step, without a
controller. One CUDA graph holds a step. World 0 has the flight's own rates: how far it goes from MuJoCo's
flight is single precision, the solver's tolerance and what no controller takes back.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import mujoco
import mujoco_warp as mjw  # pyright: ignore[reportMissingImports]
import numpy as np
import warp as wp  # pyright: ignore[reportMissingImports]

LENGTH = 0.25
"""s that are flown, and flown again while the clock runs."""
RATES = 1e-3


@wp.kernel
def push(
    forces: wp.array2d(dtype=float),  # pyright: ignore
    step: wp.array(dtype=int),  # pyright: ignore
    applied: wp.array2d(dtype=float),  # pyright: ignore
):
    """The forces of this step on every world."""
    world, axis = wp.tid()  # pyright: ignore
    applied[world, axis] = forces[step[0] % forces.shape[0], axis]  # pyright: ignore


@wp.kernel
def tick(step: wp.array(dtype=int)):  # pyright: ignore
    step[0] = step[0] + 1


def touched(model: mujoco.MjModel, steps: np.ndarray) -> int:
    """The first step of the longest stay in touch, with time for `LENGTH` behind it."""
    data, touching = mujoco.MjData(model), []
    for row in steps:
        data.qpos[:], data.qvel[:] = row[: model.nq], row[model.nq : model.nq + model.nv]
        mujoco.mj_fwdPosition(model, data)
        touching.append(data.ncon > 0)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], touching, [0]])))
    return int(max(zip(edges[::2], edges[1::2], strict=True), key=lambda pair: pair[1] - pair[0])[0])


def main() -> None:
    """Fly the same stretch in as many worlds as asked, and say what a step costs."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--worlds", type=int, nargs="+", default=[1, 256, 4096])
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()
    model = mujoco.MjModel.from_xml_path(str(options.folder / "scene.xml"))
    model.opt.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)  # which warp does not know
    kept, nq, nv = np.load(options.folder / "steps.npy"), model.nq, model.nv
    first, count = touched(model, kept), round(LENGTH / model.opt.timestep)
    flown = kept[first : first + count + 1]
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = flown[0, :nq], flown[0, nq : nq + nv]
    mujoco.mj_forward(model, data)
    begin = time.perf_counter()
    for row in flown[:-1]:
        data.qfrc_applied[:] = row[nq + nv :]
        mujoco.mj_step(model, data)
    alone = count / (time.perf_counter() - begin)
    print(
        f"MuJoCo, one thread: {alone:,.0f} steps/s; {count} steps of {1e3 * model.opt.timestep:g} ms in touch"
    )
    data.qpos[:], data.qvel[:] = flown[0, :nq], flown[0, nq : nq + nv]
    mujoco.mj_forward(model, data)
    rng = np.random.default_rng(0)
    for worlds in options.worlds:
        m = mjw.put_model(model)
        d = mjw.put_data(model, data, nworld=worlds)
        rates = np.tile(data.qvel, (worlds, 1)) + RATES * rng.standard_normal((worlds, nv)) * (
            np.arange(worlds) > 0
        ).reshape(-1, 1)
        forces = wp.array(flown[:-1, nq + nv :], dtype=float)
        start = wp.array(np.tile(data.qpos, (worlds, 1)), dtype=float), wp.array(rates, dtype=float)
        step = wp.zeros(1, dtype=int)

        def one(m=m, d=d, forces=forces, step=step, worlds=worlds) -> None:
            wp.launch(push, dim=(worlds, nv), inputs=[forces, step], outputs=[d.qfrc_applied])
            mjw.step(m, d)
            wp.launch(tick, dim=1, inputs=[step])

        one()  # builds the kernels
        with wp.ScopedCapture() as capture:
            one()
        took = []
        for _ in range(options.repeats):
            wp.copy(d.qpos, start[0])
            wp.copy(d.qvel, start[1])
            step.zero_()
            wp.synchronize()
            begin = time.perf_counter()
            for _ in range(count):
                wp.capture_launch(capture.graph)
            wp.synchronize()
            took.append(time.perf_counter() - begin)
        places, end = d.qpos.numpy(), flown[-1, :nq]
        off = np.abs(places[0] - end)
        speed = worlds * count / min(took)
        print(
            f"{worlds} worlds: {speed:,.0f} steps/s, {speed / alone:.1f} times one thread of MuJoCo; a step "
            f"{1e6 * min(took) / count:.0f} us; world 0 ends {1e3 * off[:3].max():.2g} mm and "
            f"{1e3 * off[7:].max():.2g} mrad from MuJoCo's; all finite: {bool(np.isfinite(places).all())}; "
            f"spread {1e3 * places[:, :3].std(axis=0).max():.2g} mm",
            flush=True,
        )


if __name__ == "__main__":
    main()
