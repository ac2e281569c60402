"""A simulator in a program of its own, in lock-step over UDP; nothing of skylimb is in it.

python examples/plants/udp_simulator.py 9871    and in another window, of Python:
skylimb.run("paper", "hybrid", plant=skylimb.UdpPlant("127.0.0.1:9871"))
"""

import socket
import sys

import msgspec
import mujoco
import numpy as np


def begin(told):
    spec = mujoco.MjSpec.from_string(told["scene"])  # robot and board; an engine of yours builds its own
    for part in [*spec.actuators, *spec.pairs, *spec.sensors]:
        spec.delete(part)
    model, truth = spec.compile(), told["truth"]
    data, model.opt.timestep = mujoco.MjData(model), told["step"]
    angles = [model.joint(name).qposadr[0] for name in told["names"]]
    data.qpos[:7] = truth["root_position"] + truth["root_quaternion"]
    data.qpos[angles] = truth["joint_angles"] + truth["vectoring_angles"]
    return told, model, data, angles, [model.joint(name).dofadr[0] for name in told["names"]]


def step(drive, told, model, data, angles, rates):
    drive, board = ({k: np.array(v) for k, v in one.items()} for one in (drive, told["surface"]))
    mujoco.mj_fwdPosition(model, data)
    mujoco.mj_fwdVelocity(model, data)
    q, v, forces, n = data.qpos, data.qvel, data.qfrc_applied, len(told["truth"]["joint_angles"])
    servos = drive["stiffness"] * (drive["set_points"] - q[angles]) - drive["damping"] * v[rates]
    rubbing = np.clip(drive["brake"] * v[rates], -drive["friction"], drive["friction"])
    forces[:], forces[:3], forces[3:6] = 0.0, drive["force"], drive["torque"]
    forces[rates] = np.clip(servos, -drive["torque_limits"], drive["torque_limits"]) - rubbing
    forces[rates] += drive["joint_torques"]
    for rotor, thrust in zip(told["rotors"], drive["thrusts"], strict=True):
        site = data.site("thrust_" + rotor["name"])
        along, body = thrust * site.xmat.reshape(3, 3)[:, 2], model.site_bodyid[site.id]
        mujoco.mj_applyFT(model, data, along, rotor["drag"] * along, site.xpos, body, forces)
    tip, twist, normal = data.site("tip"), np.zeros(6), board["normal"]
    mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_SITE, tip.id, twist, 0)
    gap, away = normal @ (tip.xpos - board["position"]) - board["tip_radius"], normal @ twist[3:]
    slip, point = twist[3:] - away * normal, tip.xpos.tolist()
    pressed = max(0.0, -board["stiffness"] * gap - board["damping"] * away) if gap < 0.0 else 0.0
    touch = pressed * (normal - board["friction"] * slip / (1e-3 + np.linalg.norm(slip)))
    mujoco.mj_applyFT(model, data, touch, np.zeros(3), tip.xpos, model.site_bodyid[tip.id], forces)
    mujoco.mj_step(model, data)
    said = {"root_position": q[:3], "root_quaternion": q[3:7], "contact_force": touch}
    said |= {"root_velocity": v[:3], "root_angular_velocity": v[3:6], "contact_point": np.array(point)}
    said |= {"joint_angles": q[angles[:n]], "vectoring_angles": q[angles[n:]]}
    said |= {"joint_rates": v[rates[:n]], "vectoring_rates": v[rates[n:]]}
    return {name: value.tolist() for name, value in said.items()}


with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listening:
    listening.bind(("127.0.0.1", int(sys.argv[1])))
    begun, answered, answer, world = 0, -1, b"", ()
    while True:
        data, peer = listening.recvfrom(65535)
        asked = msgspec.msgpack.decode(data)
        if begun <= asked["seq"] < answered:  # of this flight, and late: nobody waits for it
            continue
        if asked["seq"] != answered:  # what is asked twice is answered twice, and stepped once
            begun = asked["seq"] if "start" in asked else begun
            world = begin(asked["start"]) if "start" in asked else world
            truth = step(asked["drive"], *world) if "drive" in asked else asked["start"]["truth"]
            answered = asked["seq"]
            answer = msgspec.msgpack.encode({"seq": answered, "truth": truth})
        listening.sendto(answer, peer)
