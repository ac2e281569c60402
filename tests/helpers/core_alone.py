"""The core flies a controller by itself; with `--blocked` no other package can be imported while it does.

Robots, control, missions and the loop need NumPy, CasADi and a reader of configurations. The vehicle is a
stand in which the robot hangs. `make bare` runs this where nothing else is installed.
"""

import sys
from typing import Any

ALLOWED = {"numpy", "casadi", "msgspec", "lazy_loader", "skylimb"}


class Blocked:
    def find_spec(self, name, path=None, target=None):
        top = name.partition(".")[0]
        if not (top in ALLOWED or top in sys.stdlib_module_names or top.startswith("_")):
            raise ModuleNotFoundError(f"{name} is blocked", name=name)


if "--blocked" in sys.argv:
    sys.meta_path.insert(0, Blocked())

import numpy as np

from skylimb.base.rotations import quaternion_from_rotation, rot_z
from skylimb.control.controller import load_controller
from skylimb.control.estimation.records import Measurement
from skylimb.control.loop.loop import Loop
from skylimb.control.loop.terminations import Terminations
from skylimb.control.loop.vehicle import measured_layout
from skylimb.control.missions.configuration import ApproachConfig, MissionConfig, PhaseConfig
from skylimb.control.missions.frame import contact_frame
from skylimb.control.missions.plan import plan_mission
from skylimb.control.missions.posture import posture_plan
from skylimb.control.planning.posture_path import PostureConfig
from skylimb.flight.drivers.free import FreeDriver
from skylimb.flight.realtime.compiled_controller import CompiledController
from skylimb.flight.realtime.guard import GuardedController
from skylimb.robots.loader import load_robot

DT, TICKS = 0.005, 60
robot = load_robot("hydrus_xi_quad")
controller: Any = load_controller("following", robot)
plan = posture_plan(PostureConfig(), robot, controller.needs.vectoring)
config = MissionConfig(PhaseConfig(0.05, 0.05, 0.05, 0.05), ApproachConfig(contact=False))
mission = plan_mission(config, contact_frame((1.0, 0.0, 0.0)), np.array([1.5, 0.0, 1.0]), plan, DT)


class Held:
    """A robot that hangs in a stand where its mission begins."""

    def __init__(self):
        self.layout, first = measured_layout(robot), mission.first
        self.at, z3 = robot.at(first.joint_angles, first.vectoring_angles), np.zeros(3)
        R = rot_z(first.heading - self.at.tip_heading) @ self.at.R_root_C.T
        self.measured = Measurement(
            first.position - R @ self.at.cog_root,
            quaternion_from_rotation(R),
            z3,
            z3,
            first.joint_angles,
            first.vectoring_angles,
        )
        self.command: Any = None

    def measure(self):
        # No sensor shows the same twice.
        seen, named = self.measured, ("position", "velocity", "angular_velocity")
        self.measured = seen._replace(**{name: getattr(seen, name) + 1e-12 for name in named})
        return self.measured

    def record(self, measurement, command):
        return np.hstack([*measurement.entries, *command])

    def apply(self, command):
        self.command = command

    def fault(self):
        return ""


compiled = CompiledController(controller, DT)
thrusts = []
for flown in (controller, compiled, GuardedController(compiled, robot)):
    vehicle = Held()
    loop = Loop(FreeDriver(flown, vehicle, robot, mission, TICKS), mission, Terminations(), TICKS)
    flight = loop.fly()
    assert flight.ticks == TICKS, flight.cause
    thrusts.append(vehicle.command.thrusts)
    lift = vehicle.at.allocation_C[2] @ thrusts[-1]
    assert abs(lift / robot.weight - 1.0) < 0.05, lift
assert np.allclose(thrusts[0], thrusts[1])
assert np.allclose(thrusts[0], thrusts[2])
print("flown")
