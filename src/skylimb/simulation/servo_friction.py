"""Dry friction of the servo joints, as a damper that saturates.

The engine's own dry friction is a constraint of each joint, so that its solver has work in every step of a
flight. Here the friction is a motor without input on the same joint. Its back-EMF brakes the joint, and its
torque is limited:

    tau = -clip(c w, -F, F),    c = I / T,

with the joint's speed w, its dry friction F, its inertia I and the time T in which the speed of a stuck joint
dies away. A joint is stuck while its speed is below F / c; under a load tau it then creeps at tau / c. The
engine's constraint does the same, because its solver regularizes friction with a damper of that size.
"""

from __future__ import annotations

import mujoco
import numpy as np

_STOP_TIME = 1e-3
"""T, s."""


def add_servo_friction(spec: mujoco.MjSpec, joint: str, torque: float) -> None:
    """Add the dry friction (N m) of a joint; `tune_servo_friction` completes it once compiled."""
    actuator = spec.add_actuator(name=f"{joint}_friction", trntype=mujoco.mjtTrn.mjTRN_JOINT, target=joint)
    actuator.set_to_dcmotor(
        motorconst=[0.0, 1.0],
        resistance=1.0,
        saturation=[torque, 0.0, 0.0],
        ctrlspec=int(mujoco.mjtCtrlInput.mjINPUT_NONE),
    )


def tune_servo_friction(model: mujoco.MjModel) -> None:
    """Write the damping of every friction; call again whenever masses changed (after `mj_setConst`)."""
    motors, dofs = _brakes(model)
    inertia = 1.0 / model.dof_invweight0[dofs]
    # In a longer step a joint that is about to stick would be thrown back.
    damping = inertia / max(_STOP_TIME, float(model.opt.timestep))
    # A motor of resistance 1 whose terminals are joined brakes with its constant squared.
    model.actuator_gainprm[motors, 1] = np.sqrt(damping)


def servo_brakes(model: mujoco.MjModel) -> dict[int, float]:
    """The damping c of every friction, N m s/rad, by its joint's place among the velocities."""
    motors, dofs = _brakes(model)
    return dict(zip(dofs.tolist(), (model.actuator_gainprm[motors, 1] ** 2).tolist(), strict=True))


def _brakes(model: mujoco.MjModel) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of the motors that stand for dry friction, and their joints' places among the velocities."""
    motors = np.flatnonzero(model.actuator_gaintype == int(mujoco.mjtGain.mjGAIN_DCMOTOR))
    return motors, model.jnt_dofadr[model.actuator_trnid[motors, 0]]
