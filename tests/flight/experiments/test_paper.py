"""What the paper's experiment must show, on one seed here and on twenty in the slow test."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

import skylimb
from skylimb.analysis.scores.registry import NUMERIC_KEYS
from skylimb.flight.public import PAPER_CONTROLLERS
from skylimb.flight.takeoff import take_off


@pytest.fixture(scope="module")
def runs() -> dict[str, skylimb.Run]:
    return skylimb.compare("paper")


def check(runs: dict[str, skylimb.Run]) -> None:
    """Everybody finishes, off the joint limits and on the board; arm and impedance do what they are for."""
    metrics = {}
    for name, run in runs.items():
        assert run.status == "OK", f"{name}: {run.cause}"
        joints = run.log["joint_angles"].values
        assert np.abs(joints).max() < 1.57
        metrics[name] = run.metrics
        sliding = run.log["phase"].values == 4
        late = np.flatnonzero(sliding)[-200:]
        assert run.log["contact"].values[late].mean() > 0.5

    def away(name: str) -> float:
        return metrics[name]["displacement_median"]

    assert 0.55 <= away("hybrid") / away("impedance") <= 0.75
    assert 0.55 <= away("admittance") / away("pid") <= 0.75
    for name in ("impedance", "hybrid"):
        assert metrics[name]["error_u_median"] < metrics["pid"]["error_u_median"]


def test_one_seed(runs: dict[str, skylimb.Run]) -> None:
    check(runs)


@pytest.mark.slow
def test_twenty_seeds() -> None:
    for seed in range(1, 20):
        check(skylimb.compare("paper", seed=seed))


def test_the_same_seed_gives_the_same_bits(runs: dict[str, skylimb.Run]) -> None:
    again = skylimb.run("paper", controller="hybrid")
    for name, signal in runs["hybrid"].log.data_vars.items():
        np.testing.assert_array_equal(signal.values, again.log[name].values, err_msg=str(name))


def test_another_seed_gives_another_flight(runs: dict[str, skylimb.Run]) -> None:
    other = skylimb.run("paper", controller="hybrid", seed=1)
    assert np.abs(other.log["cog_position"].values - runs["hybrid"].log["cog_position"].values).max() > 1e-6


@pytest.mark.parametrize("controller", PAPER_CONTROLLERS)
def test_half_the_time_step_changes_no_metric(runs: dict[str, skylimb.Run], controller: str) -> None:
    fine = skylimb.run("paper", controller=controller, set={"plant.physics_step": 0.0005})
    for key in NUMERIC_KEYS:
        value = runs[controller].metrics[key]
        if value is None:
            assert fine.metrics[key] is None, key
        else:
            assert fine.metrics[key] == pytest.approx(value, rel=0.02), key


def test_every_documented_signal_is_recorded(runs: dict[str, skylimb.Run]) -> None:
    names = [
        "cog_position",
        "cog_position_reference",
        "external_force_estimate",
        "contact_force",
        "contact",
        "tip_position",
        "reach",
        "joint_angles",
        "vectoring_angles",
        "thrusts",
        "phase",
    ]
    log = runs["hybrid"].log
    for name in names:
        assert {"units", "frame", "long_name", "kind"} <= log[name].attrs.keys()
    touching = log["contact"].values > 0
    assert np.isfinite(log["contact_trace"].values[touching]).all()
    not_always = ("contact_trace", "contact_point")
    assert all(np.isfinite(log[name].values).all() for name in log.data_vars if name not in not_always)


def test_truth_agrees_with_the_physics(runs: dict[str, skylimb.Run]) -> None:
    """Centre of gravity and tip of the log against the engine's own, at random ticks."""
    log = runs["hybrid"].log
    (takeoff,) = take_off("paper", ("hybrid",))
    plant = takeoff.plant
    data = mujoco.MjData(plant.model)
    for k in np.random.default_rng(0).integers(0, log.sizes["time"], 20):
        data.qpos[:] = log["configuration"].values[k]
        mujoco.mj_forward(plant.model, data)
        np.testing.assert_allclose(log["cog_position"].values[k], data.subtree_com[0], atol=1e-9)
        np.testing.assert_allclose(log["tip_position"].values[k], data.site("tip").xpos, atol=1e-9)


def test_the_scene_in_the_log_replays_the_flight(runs: dict[str, skylimb.Run]) -> None:
    log = runs["hybrid"].log
    model = mujoco.MjModel.from_xml_string(log.attrs["scene"])
    data = mujoco.MjData(model)
    data.qpos[:] = log["configuration"].values[4000]
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(log["tip_position"].values[4000], data.site("tip").xpos, atol=1e-5)


def test_velocities_are_the_derivatives_of_positions(runs: dict[str, skylimb.Run]) -> None:
    log = runs["pid"].log
    time = log["time"].values
    for name in ("cog", "tip"):
        slope = np.gradient(log[f"{name}_position"].values, time, axis=0)
        difference = slope - log[f"{name}_velocity"].values
        assert np.sqrt(np.mean(difference[2:-2] ** 2)) < 2e-3


def test_a_runs_own_configuration_flies_it_again(tmp_path: Path) -> None:
    changes = {"surface.friction": 0.2, "controller.shape.stiffness": 25.0, "trajectory.duration": 1.0}
    first = skylimb.run("paper", controller="hybrid", seed=3, set={**changes, "trajectory.shape": "hold"})
    file = tmp_path / "config.toml"
    file.write_text(first.config)
    again = skylimb.run(str(file))
    assert again.controller == "hybrid"
    np.testing.assert_array_equal(again.log["configuration"].values, first.log["configuration"].values)
