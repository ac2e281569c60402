import numpy as np
import pytest

import skylimb


@pytest.mark.parametrize("controller", ["pid", "impedance"])
def test_large_deformations_hardly_move_the_robot(controller: str) -> None:
    run = skylimb.run("free_flight", controller=controller)
    assert run.status == "OK", run.cause
    log = run.log
    error = abs(log["cog_position"] - log["cog_position_reference"])
    assert float(np.hypot(error.sel(axis="x"), error.sel(axis="y")).max()) < 0.05
    assert float(error.sel(axis="z").max()) < 0.05
    yaw = log["attitude"].sel(axis="z")
    assert float(np.abs(yaw - yaw[0]).max()) < 0.06
    reached = log["joint_angles_command"].values
    for waypoint in ([0.0, 1.5, 1.5], [1.5, 1.5, 1.5], [0.78, 1.5, 0.78]):
        assert np.abs(reached - waypoint).max(axis=1).min() < 1e-6
