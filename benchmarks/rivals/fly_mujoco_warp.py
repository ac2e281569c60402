"""One flight with mujoco-warp as the engine, on its CPU device, beside MuJoCo's own.

    python -m venv warp-env
    warp-env/bin/pip install -r benchmarks/rivals/mujoco_warp.txt .
    warp-env/bin/python benchmarks/rivals/fly_mujoco_warp.py

In an environment of its own; nothing of skylimb needs it. The robot, its tip and the surface's pair are the
scene's own, elliptic cone and all, solved by Newton's method; rotors and servos are forces, as for any other
simulator. It prints by how much the two flights differ, and what a step costs. Kernels are launched one by
one here, which a batch on a GPU does once for all of its flights: `--save FOLDER` keeps what
`batch_mujoco_warp.py` flies there.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import mujoco
import mujoco_warp as mjw  # pyright: ignore[reportMissingImports]
import numpy as np
import warp as wp  # pyright: ignore[reportMissingImports]

import skylimb
from skylimb import Beginning, Drive

QUIET = {
    "sensors.latency": 0.0,
    **{
        f"sensors.{name}_noise": 0.0
        for name in ("position", "velocity", "attitude", "angular_velocity", "joint", "vectoring")
    },
}
SHORT = {"trajectory.shape": "hold", "phases.hover": 0.5, "phases.tare": 1.0, "supervisor.on": False}
COMPARED = (("cog_position", 1e3, "mm"), ("joint_angles", 1e3, "mrad"), ("contact_force", 1e3, "mN"))


class Forced:
    """The scene with its contact pair; rotors and servos are forces, which MuJoCo adds up."""

    name = "forced"

    def start(self, beginning: Beginning) -> dict[str, np.ndarray]:
        spec = mujoco.MjSpec.from_string(beginning.scene)
        for part in [*spec.actuators, *spec.sensors]:
            spec.delete(part)
        spec.option.timestep, spec.option.solver = beginning.step, mujoco.mjtSolver.mjSOL_NEWTON
        self.model = model = spec.compile()
        self.scene, self.kept = spec.to_xml(), []
        self.data, self.robot = mujoco.MjData(model), beginning.robot
        joints = [*self.robot.shape_joints, *self.robot.vectoring_joints]
        self.angles = [model.joint(name).qposadr[0] for name in joints]
        self.rates = [model.joint(name).dofadr[0] for name in joints]
        truth, data = beginning.truth, self.data
        data.qpos[:7] = np.concatenate([truth["root_position"], truth["root_quaternion"]])
        data.qpos[self.angles] = np.concatenate([truth["joint_angles"], truth["vectoring_angles"]])
        self.spent, self.steps = 0.0, 0
        self.begin()
        return self.truth(np.zeros(3))

    def step(self, drive: Drive) -> dict[str, np.ndarray]:
        model, data = self.model, self.data
        mujoco.mj_fwdPosition(model, data)
        data.qfrc_applied[:] = 0.0
        data.qfrc_applied[:3], data.qfrc_applied[3:6] = drive.force, drive.torque
        servos = drive.servo_torques(data.qpos[self.angles], data.qvel[self.rates])
        data.qfrc_applied[self.rates] = servos + drive.joint_torques
        for rotor, thrust in zip(self.robot.rotors, drive.thrusts, strict=True):
            site = data.site(f"thrust_{rotor.name}")
            along, link = site.xmat.reshape(3, 3)[:, 2], model.site_bodyid[site.id]
            torque = rotor.drag_torque_coefficient * thrust * along
            mujoco.mj_applyFT(model, data, thrust * along, torque, site.xpos, link, data.qfrc_applied)
        self.kept.append(np.concatenate([data.qpos, data.qvel, data.qfrc_applied]))
        begin = time.perf_counter()
        force = self.go()
        self.spent, self.steps = self.spent + time.perf_counter() - begin, self.steps + 1
        return self.truth(force)

    def begin(self) -> None:
        """Nothing to make ready."""

    def go(self) -> np.ndarray:
        """One step; the contact's force on the robot: all that constraints do to the root's place."""
        mujoco.mj_step(self.model, self.data)
        return self.data.qfrc_constraint[:3].copy()

    def truth(self, force: np.ndarray) -> dict[str, np.ndarray]:
        q, v, n = self.data.qpos, self.data.qvel, len(self.robot.shape_joints)
        return {
            "root_position": q[:3],
            "root_quaternion": q[3:7],
            "root_velocity": v[:3],
            "root_angular_velocity": v[3:6],
            "joint_angles": q[self.angles[:n]],
            "joint_rates": v[self.rates[:n]],
            "vectoring_angles": q[self.angles[n:]],
            "vectoring_rates": v[self.rates[n:]],
            "contact_force": force,
            "contact_point": self.data.site("tip").xpos.copy(),
        }


class Warped(Forced):
    """The same, stepped by mujoco-warp in single precision."""

    name = "warp"

    def begin(self) -> None:
        self.model.opt.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)  # which warp does not know
        mujoco.mj_forward(self.model, self.data)
        self.m = mjw.put_model(self.model)
        mjw.step(self.m, mjw.put_data(self.model, self.data))  # builds the kernels
        self.d = mjw.put_data(self.model, self.data)

    def go(self) -> np.ndarray:
        self.d.qfrc_applied.assign(self.data.qfrc_applied[None].astype(np.float32))
        mjw.step(self.m, self.d)
        self.data.qpos[:], self.data.qvel[:] = self.d.qpos.numpy()[0], self.d.qvel.numpy()[0]
        return self.d.qfrc_constraint.numpy()[0, :3].astype(float)


def main() -> None:
    """Fly both, and say by how much they differ."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--controller", default="following")
    parser.add_argument("--until", type=float, default=12.0, help="s")
    parser.add_argument("--save", type=Path, help="keep MuJoCo's scene, states and forces in this folder")
    options = parser.parse_args()
    wp.init()
    asked = {**QUIET, **SHORT, "stop_at": options.until}
    flown = []
    with wp.ScopedDevice("cpu"):
        for plant in (Forced(), Warped()):
            run = skylimb.run("paper", controller=options.controller, set=asked, plant=plant)
            flown.append(run.log)
            print(f"{plant.name}: {run.status} {run.cause}, {1e6 * plant.spent / plant.steps:.0f} us a step")
            if options.save and plant.name == "forced":
                options.save.mkdir(parents=True, exist_ok=True)
                (options.save / "scene.xml").write_text(plant.scene, encoding="utf-8")
                np.save(options.save / "steps.npy", np.array(plant.kept))
    ours, theirs = flown
    touching = np.linalg.norm(theirs.contact_force.values, axis=1) > 0.0
    print(f"in touch for {touching.mean() * options.until:.1f} s of {options.until:g}")
    for name, scale, unit in COMPARED:
        off = scale * np.linalg.norm(theirs[name].values - ours[name].values, axis=1)
        print(f"{name}: rms {np.sqrt(np.mean(off**2)):.2g}, most {off.max():.2g} {unit}")


if __name__ == "__main__":
    main()
