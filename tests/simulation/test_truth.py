import numpy as np
import pytest

import skylimb
from skylimb.experiments.run import prepare_flight
from skylimb.simulation import truth
from skylimb.simulation.native import native_available


def test_machine_code_gives_the_same_kinematics_at_any_number_of_ticks() -> None:
    if not native_available():
        pytest.skip("no C compiler here")
    plant, _ = prepare_flight(skylimb.load_experiment("paper"), skylimb.load_robot("hydrus_xi_quad"))
    size = (int(plant.model.nq), int(plant.model.nv))
    functions = [
        truth._kinematics_function(plant.robot, plant.joint_qpos, plant.vectoring_qpos, *size, built)[0]
        for built in (False, True)
    ]
    rng = np.random.default_rng(0)
    for count in (0, 1, 256, 300):
        qpos, qvel, axis = (rng.normal(size=(count, n)) for n in (*size, 3))
        qpos[:, 3:7] /= np.linalg.norm(qpos[:, 3:7], axis=1, keepdims=True)
        slow, built = (truth._over_ticks(function, qpos, qvel, axis) for function in functions)
        assert slow.shape == (count, functions[0].size1_out(0))
        np.testing.assert_allclose(built, slow, rtol=0.0, atol=1e-12)
