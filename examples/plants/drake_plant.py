"""Drake as a second engine: the robot built link by link, forces on it, and Drake's own step.

    pip install 'skylimb[drake]'
    python examples/plants/drake_plant.py

Rotors are forces of skylimb's, and so is the contact unless Drake's own is asked for; the tree of bodies, its
joints and its integrator are Drake's.
"""

# Drake's type stubs refuse plain arrays.
# pyright: reportArgumentType=false, reportCallIssue=false, reportAttributeAccessIssue=false

import numpy as np
from pydrake.geometry import AddContactMaterial, HalfSpace, ProximityProperties, Sphere
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import (
    AddMultibodyPlantSceneGraph,
    CoulombFriction,
    DiscreteContactApproximation,
    ExternallyAppliedSpatialForce,
    MultibodyPlant,
)
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    RevoluteJoint,
    RigidBody,
    RotationalInertia,
    SpatialInertia,
    WeldJoint,
)
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

import skylimb
from skylimb import Beginning, Drive
from skylimb.robots.description import RobotDescription


def add_robot(plant: MultibodyPlant, robot: RobotDescription) -> None:
    """The robot as Drake's tree, floating at its root."""
    for link in robot.links:
        inertia = link.inertial.inertia
        moments = RotationalInertia(*np.diag(inertia), inertia[0, 1], inertia[0, 2], inertia[1, 2])
        mass, com = link.inertial.mass, link.inertial.com
        plant.AddRigidBody(link.name, SpatialInertia.MakeFromCentralInertia(mass, com, moments))
    for joint in robot.joints:
        parent, child = (plant.GetBodyByName(name) for name in (joint.parent, joint.child))
        place = RigidTransform(RotationMatrix(joint.R), joint.xyz)
        frames = (parent.body_frame(), child.body_frame())
        if joint.kind == "fixed":
            plant.AddJoint(WeldJoint(joint.name, *frames, place))
        else:
            at = plant.AddFrame(FixedOffsetFrame(f"{joint.name}_at", frames[0], place))
            plant.AddJoint(RevoluteJoint(joint.name, at, frames[1], joint.axis, joint.damping))
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, -robot.gravity])


def add_touch(plant: MultibodyPlant, beginning: Beginning) -> None:
    """Drake's own point contact between the tip's ball and a board at rest: a spring, a damper, Coulomb."""
    surface, tip = beginning.surface, beginning.robot.tip
    if surface.kind != "board" or surface.moves:
        raise ValueError("Drake's own contact is here with a board at rest; leave out own_contact")
    materials = ProximityProperties()
    # Two springs in series: each is twice as stiff. Drake damps by the force itself: at 1 N as skylimb does.
    friction = CoulombFriction(surface.friction, surface.friction)
    AddContactMaterial(beginning.touch.damping, 2.0 * surface.stiffness, friction, materials)
    R = surface.R_WS
    outward = np.column_stack((R[:, 1], -R[:, 2], -R[:, 0]))
    board = RigidTransform(RotationMatrix(outward), surface.position)
    plant.RegisterCollisionGeometry(plant.world_body(), board, HalfSpace(), "board", materials)
    ball = RigidTransform(tip.position)
    link = plant.GetBodyByName(tip.link)
    plant.RegisterCollisionGeometry(link, ball, Sphere(tip.radius), "tip", materials)
    plant.set_discrete_contact_approximation(DiscreteContactApproximation.kLagged)


class DrakePlant:
    """The robot in Drake, with skylimb's contact or Drake's own."""

    def __init__(self, own_contact: bool = False) -> None:
        self.own_contact = own_contact
        self.name = "drake, its own contact" if own_contact else "drake"

    def start(self, beginning: Beginning) -> dict[str, np.ndarray]:
        robot, truth = beginning.robot, beginning.truth
        builder = DiagramBuilder()
        self.plant, _ = AddMultibodyPlantSceneGraph(builder, beginning.step)
        self.robot, self.touch = robot, beginning.touch
        add_robot(self.plant, robot)
        if self.own_contact:
            add_touch(self.plant, beginning)
        self.plant.Finalize()
        self.simulator = Simulator(builder.Build())
        self.context = self.plant.GetMyMutableContextFromRoot(self.simulator.get_mutable_context())
        self.root = self.plant.GetBodyByName(robot.root)
        self.tip = self.plant.GetBodyByName(robot.tip.link)
        self.links = [self.plant.GetBodyByName(rotor.link) for rotor in robot.rotors]
        names = [*robot.shape_joints, *robot.vectoring_joints]
        joints = [self.plant.GetJointByName(name) for name in names]
        self.angles = [joint.position_start() for joint in joints]
        self.rates = [joint.velocity_start() for joint in joints]
        q = np.zeros(self.plant.num_positions())
        q[:7] = np.concatenate([truth["root_quaternion"], truth["root_position"]])
        q[self.angles] = np.concatenate([truth["joint_angles"], truth["vectoring_angles"]])
        self.plant.SetPositions(self.context, q)
        self.simulator.Initialize()
        self.step_length = beginning.step
        return self.truth(np.zeros(3), np.zeros(3))

    def step(self, drive: Drive) -> dict[str, np.ndarray]:
        plant, context = self.plant, self.context
        q, v = plant.GetPositions(context), plant.GetVelocities(context)
        torques = np.zeros(plant.num_velocities())
        torques[self.rates] = drive.servo_torques(q[self.angles], v[self.rates]) + drive.joint_torques
        plant.get_applied_generalized_force_input_port().FixValue(context, torques)
        R = self.root.EvalPoseInWorld(context).rotation().matrix()
        forces = [applied(self.root, np.zeros(3), drive.force, R @ drive.torque)]
        for rotor, link, thrust in zip(self.robot.rotors, self.links, drive.thrusts, strict=True):
            along = thrust * (link.EvalPoseInWorld(context).rotation().matrix() @ rotor.R[:, 2])
            forces.append(applied(link, rotor.xyz, along, rotor.drag_torque_coefficient * along))
        force, point = np.zeros(3), np.zeros(3)
        if not self.own_contact:
            X, twist = self.tip.EvalPoseInWorld(context), self.tip.EvalSpatialVelocityInWorld(context)
            arm = X.rotation().matrix() @ self.robot.tip.position
            velocity = twist.translational() + np.cross(twist.rotational(), arm)
            force, point = self.touch(X.translation() + arm, velocity, context.get_time())
            forces.append(applied(self.tip, X.inverse() @ point, force, np.zeros(3)))
        plant.get_applied_spatial_force_input_port().FixValue(context, forces)
        self.simulator.AdvanceTo(context.get_time() + self.step_length)
        if self.own_contact:
            force, point = self.touched()
        return self.truth(force, point)

    def touched(self) -> tuple[np.ndarray, np.ndarray]:
        """What Drake's own contact did to the tip in the last step, N, and where, m."""
        results = self.plant.get_contact_results_output_port().Eval(self.context)
        if results.num_point_pair_contacts() == 0:
            return np.zeros(3), np.zeros(3)
        one = results.point_pair_contact_info(0)
        onto_tip = 1.0 if one.bodyB_index() == self.tip.index() else -1.0
        return onto_tip * one.contact_force(), one.contact_point()

    def truth(self, force: np.ndarray, point: np.ndarray) -> dict[str, np.ndarray]:
        q, v = self.plant.GetPositions(self.context), self.plant.GetVelocities(self.context)
        n, R = len(self.robot.shape_joints), self.root.EvalPoseInWorld(self.context).rotation().matrix()
        return {
            "root_position": q[4:7],
            "root_quaternion": q[:4],
            "root_velocity": v[3:6],
            "root_angular_velocity": R.T @ v[:3],
            "joint_angles": q[self.angles[:n]],
            "joint_rates": v[self.rates[:n]],
            "vectoring_angles": q[self.angles[n:]],
            "vectoring_rates": v[self.rates[n:]],
            "contact_force": force,
            "contact_point": point,
        }


def applied(
    body: RigidBody, place: np.ndarray, force: np.ndarray, torque: np.ndarray
) -> ExternallyAppliedSpatialForce:
    """A force (W) at a place in a body's axes, and a torque (W)."""
    found = ExternallyAppliedSpatialForce()
    found.body_index, found.p_BoBq_B = body.index(), place
    found.F_Bq_W = SpatialForce(torque, force)
    return found


if __name__ == "__main__":
    run = skylimb.run("paper", controller="hybrid", plant=DrakePlant())
    print(f"{run.status}: {run.metrics['contact_force_normal_mean']:.2f} N in touch")
