"""What a law or a cascade is handed in tests."""

import numpy as np

from skylimb.base.rotations import quaternion_from_rotation
from skylimb.control.cascade import Cascade
from skylimb.control.estimation.records import Measurement
from skylimb.control.missions.reference import Reference, zero_reference
from skylimb.control.records import ContactView, TipMove

IN_THE_AIR = ContactView(
    0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, np.zeros(3), TipMove(*np.zeros((4, 3))), 0.0, 0.0
)
"""No contact, known in full."""


def hover(cascade: Cascade) -> tuple[Measurement, Reference]:
    """At rest on the reference, in the nominal posture, with nothing else ahead."""
    family = cascade.family
    q = np.asarray(family.joint_angles(family.theta_nominal))
    psi = np.asarray(cascade.vectoring.angles(family.theta_nominal))
    model = cascade.robot.at(q, psi)
    z3, X, Y = np.zeros(3), np.eye(3)[0], np.eye(3)[1]
    attitude = model.R_root_C.T
    measurement = Measurement(-attitude @ model.cog_root, quaternion_from_rotation(attitude), z3, z3, q, psi)
    reference = zero_reference(len(q), len(psi))._replace(
        heading=model.tip_heading, reach=family.reach_nominal, joint_angles=q, vectoring_angles=psi,
        contact_axis=X, sliding_axis=Y, tip_position=model.tip_C,
    )  # fmt: skip
    return measurement, reference._replace(ahead=(reference,) * len(cascade.needs.preview))
