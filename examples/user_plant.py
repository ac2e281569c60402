"""A simulator of one's own, with a loop like Gazebo's: forces onto links and joints, a step, poses read back.

The engine here is MuJoCo, as every installation has it, but used as a stranger would: its own servos, rotors
and contact pair are left out, it gets forces alone. Any engine that can do the same flies like this.
"""

import mujoco
import numpy as np

import skylimb
from skylimb import Beginning, Drive


class Stranger:
    name = "stranger"

    def start(self, beginning: Beginning) -> dict[str, np.ndarray]:
        spec = mujoco.MjSpec.from_string(beginning.scene)
        for part in [*spec.actuators, *spec.pairs, *spec.sensors]:
            spec.delete(part)
        self.model = spec.compile()
        self.model.opt.timestep = beginning.step
        self.data, self.robot, self.touch = mujoco.MjData(self.model), beginning.robot, beginning.touch
        joints = [*self.robot.shape_joints, *self.robot.vectoring_joints]
        self.angles = [self.model.joint(name).qposadr[0] for name in joints]
        self.rates = [self.model.joint(name).dofadr[0] for name in joints]
        truth, data = beginning.truth, self.data
        data.qpos[:7] = np.concatenate([truth["root_position"], truth["root_quaternion"]])
        data.qpos[self.angles] = np.concatenate([truth["joint_angles"], truth["vectoring_angles"]])
        return self.truth(np.zeros(3), np.zeros(3))

    def step(self, drive: Drive) -> dict[str, np.ndarray]:
        model, data = self.model, self.data
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        data.qfrc_applied[:] = 0.0
        data.qfrc_applied[:3], data.qfrc_applied[3:6] = drive.force, drive.torque
        servos = drive.servo_torques(data.qpos[self.angles], data.qvel[self.rates])
        data.qfrc_applied[self.rates] = servos + drive.joint_torques
        for rotor, thrust in zip(self.robot.rotors, drive.thrusts, strict=True):
            site = data.site(f"thrust_{rotor.name}")
            along, link = site.xmat.reshape(3, 3)[:, 2], model.site_bodyid[site.id]
            self.push(link, thrust * along, site.xpos, rotor.drag_torque_coefficient * thrust * along)
        tip, velocity = data.site("tip").xpos.copy(), np.zeros(6)
        site = model.site("tip").id
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_SITE, site, velocity, 0)
        force, point = self.touch(tip, velocity[3:], data.time)
        self.push(model.site_bodyid[site], force, point, np.zeros(3))
        mujoco.mj_step(model, data)
        return self.truth(force, point)

    def push(self, link: int, force: np.ndarray, point: np.ndarray, torque: np.ndarray) -> None:
        mujoco.mj_applyFT(self.model, self.data, force, torque, point, link, self.data.qfrc_applied)

    def truth(self, force: np.ndarray, point: np.ndarray) -> dict[str, np.ndarray]:
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
            "contact_point": point,
        }


if __name__ == "__main__":
    short = {"trajectory.shape": "hold", "trajectory.duration": 1.0}
    run = skylimb.run("paper", controller="hybrid", set=short, plant=Stranger())
    print(f"{run.status}: {run.metrics['contact_force_normal_mean']:.2f} N in touch")
