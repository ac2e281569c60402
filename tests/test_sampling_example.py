"""Sampling control flies its own rollouts: what they predict, the same bits again, and what is refused."""

import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import skylimb
from short_flights import HOLD
from skylimb.base.config import from_mapping
from skylimb.base.errors import ConfigError, UserCodeError
from skylimb.base.rotations import rotation_from_quaternion
from skylimb.control.estimation.records import BodyState
from skylimb.control.planning.smooth_step import quintic
from skylimb.flight.drivers.native import native_available
from skylimb.flight.export import export_c
from skylimb.studies.campaign.frozen import freeze
from skylimb.studies.campaign.spec import CampaignSpec

EXAMPLE = Path(__file__).parents[1] / "examples" / "sampling"
PRESET = str(EXAMPLE / "mppi.toml")
FEW = {"controller.translation.samples": 8.0, "controller.translation.every": 40.0}
SHORT = {**HOLD, "stop_at": 1.8, **FEW}
pytestmark = pytest.mark.skipif(not native_available(), reason="no C compiler")


@pytest.fixture
def rollouts(monkeypatch: pytest.MonkeyPatch) -> Iterator[ModuleType]:
    monkeypatch.syspath_prepend(str(EXAMPLE))
    import rollouts  # pyright: ignore[reportMissingImports]

    yield rollouts
    sys.modules.pop("rollouts")


def test_a_rollout_of_a_hovering_robot_hovers_and_begins_again_to_the_bit(rollouts: ModuleType) -> None:
    robot = skylimb.load_robot("hydrus_xi_quad")
    spring = {"normalized_stiffness": [4.0, 10.0, 10.0], "damping_ratio": [0.9, 0.9, 0.9]}
    model = rollouts.Rollouts(robot, 2, 60, spring, 0.3)
    takeoff = model._takeoff
    start, reference = takeoff.start, takeoff.mission.first
    angles = start.qpos[takeoff.plant.places]
    state = robot.at(angles[:3], angles[3:])
    R_WB = rotation_from_quaternion(start.qpos[3:7])
    R_WC = R_WB @ state.R_root_C
    body = BodyState(start.qpos[:3] + R_WB @ state.cog_root, np.zeros(3), R_WC, np.zeros(3), state)
    begin = rollouts.Begin(body, angles[:3], angles[3:], R_WC @ state.tip_C, -0.3)
    positions = np.tile(body.position, (2, 61, 1))
    positions[1, :, 1] += 0.05 * quintic(np.linspace(0.0, 1.0, 61))[0]
    first = model.fly(begin, reference, positions, 0.0)
    off = first.tip - (body.position + begin.arm)
    assert abs(off[0]).max() < 1e-3
    assert 0.02 < off[1, -1, 1] < 0.05
    assert not first.force.any()
    again = model.fly(begin, reference, positions, 0.0)
    np.testing.assert_array_equal(again.tip, first.tip)


def test_the_same_flight_has_the_same_bits_and_its_plans_move_it() -> None:
    one, other = (skylimb.run("paper", PRESET, set=SHORT).log for _ in range(2))
    for name in one.data_vars:
        np.testing.assert_array_equal(one[name], other[name], err_msg=str(name))
    assert np.abs(one.planned_moves.values[-1, 1:]).max() > 1e-6
    still = skylimb.run("paper", PRESET, set={**SHORT, "controller.translation.samples": 2.0}).log
    assert not still.planned_moves.values.any()  # nothing, and nothing about it: two samples without a move


def test_a_campaign_takes_it_with_what_it_sees_ahead() -> None:
    given = {"experiment": "paper", "controllers": [PRESET], "draws": 2, "seed": 1}
    assert freeze(from_mapping(CampaignSpec, given, "sampling")).names == ("mppi",)


def test_it_is_for_simulation_and_for_walls(tmp_path: Path) -> None:
    controller = skylimb.load_controller(PRESET, skylimb.load_robot("hydrus_xi_quad"))
    with pytest.raises(ConfigError, match=r"mppi\.py"):
        export_c(controller, tmp_path)
    turned = {"contact_axis": [0.0, 1.0, 0.0], "surface.position": [0.0, 1.5, 1.2]}
    with pytest.raises(UserCodeError, match=r"board across W's x axis"):
        skylimb.run("paper", PRESET, set={**SHORT, **turned})
