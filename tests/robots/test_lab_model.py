"""Our model of hydrus_xi against the lab's own compiled one, with the pen, in 100 random postures.

`lab_model.json` is what the lab's `HydrusTiltedRobotModel` (jsk_aerial_robot 85c8fdd) says, its URDF and its
greatest thrust of 35.5 N; vectoring angles are our first plan's.
"""

from __future__ import annotations

import json
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from skylimb.control.planning.control_torque import face_distances
from skylimb.robots.loader import load_robot

LAB = json.loads((Path(__file__).parent / "lab_model.json").read_text(encoding="utf-8"))


def test_mass_place_thrusts_and_torque_are_those_of_the_labs_model() -> None:
    robot, rows = load_robot("hydrus_xi_quad"), ca.SX.sym("rows", 3, 4)
    distances = face_distances(rows, [LAB["thrust_max"]] * 4, 0.0)
    guaranteed = ca.Function("guaranteed", [rows], [ca.mmin(distances)])
    assert len(LAB["postures"]) == 100
    for lab in LAB["postures"]:
        state = robot.at(np.array(lab["joints"]), np.array(lab["vectoring"]))
        torques = state.allocation_C[3:]
        assert state.mass == pytest.approx(lab["mass"], abs=5e-5)
        np.testing.assert_allclose(state.cog_root, lab["cog"], atol=1e-6)
        np.testing.assert_allclose(state.hover_thrusts, lab["hover"], atol=2e-4)
        np.testing.assert_allclose(np.linalg.norm(torques, axis=0), lab["torque"], atol=6e-7)
        assert float(guaranteed(torques)) == pytest.approx(lab["fct_min"], abs=2e-5)
        assert np.arccos(min(1.0, state.R_root_C[2, 2])) == pytest.approx(lab["tilt"], abs=1e-6)
