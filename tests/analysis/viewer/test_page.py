"""What a report's replay holds: numbers that survive the packing, shapes and poses that are the engine's."""

from __future__ import annotations

import json
import re
from collections.abc import Callable

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from skylimb.analysis.notebook_run import Run
from skylimb.analysis.viewer.packing import LEVELS, packed
from skylimb.analysis.viewer.page import viewer_html
from skylimb.analysis.viewer.payload import RATE, viewer_payload
from skylimb.analysis.viewer.shapes import body_poses, shapes, thrust_sites
from skylimb.base.errors import OutputError
from unpacking import unpacked

SCENE = """
<mujoco>
  <worldbody>
    <geom name="floor" type="plane" size="4 4 .1"/>
    <geom name="hidden" type="box" size="1 1 1" group="4"/>
    <geom name="invisible" type="box" size="1 1 1" rgba="0 0 0 0"/>
    <body name="link" pos="0 0 1">
      <joint name="turn" axis="0 0 1"/>
      <geom type="capsule" size=".02 .3" pos=".1 0 0" rgba=".2 .4 .6 1"/>
      <site name="rotor" pos="0 .1 0" quat="0.7071067811865476 0.7071067811865476 0 0"/>
    </body>
  </worldbody>
  <actuator>
    <general name="rotor" site="rotor" gear="0 0 1 0 0 0" ctrlrange="0 30" ctrllimited="true"/>
  </actuator>
</mujoco>
"""

numbers = st.floats(-1e6, 1e6) | st.just(np.nan)


@pytest.fixture(scope="module")
def run(make_run: Callable[[], Run]) -> Run:
    return make_run()


@pytest.fixture
def model() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(SCENE)


@given(arrays(float, st.tuples(st.integers(0, 30), st.integers(1, 4)), elements=numbers))
def test_packed_numbers_come_back_within_half_a_step(values: np.ndarray) -> None:
    back = unpacked(json.loads(json.dumps(packed(values), allow_nan=False)))
    assert np.array_equal(np.isnan(back), np.isnan(values))
    for column, found in zip(values.T, back.T, strict=True):
        known = np.isfinite(column)
        if known.any():
            room = 0.5 * np.ptp(column[known]) / LEVELS + 1e-8 * np.abs(column[known]).max()
            assert np.abs(found - column)[known].max() <= room + 1e-300


def test_shapes_are_those_that_the_engine_shows(model: mujoco.MjModel) -> None:
    floor, link = shapes(model)
    assert (floor["kind"], floor["body"]) == ("plane", 0)
    assert (link["kind"], link["body"], link["position"]) == ("capsule", 1, [0.1, 0.0, 0.0])
    assert link["size"][:2] == [0.02, 0.3]
    assert link["colour"] == pytest.approx([0.2, 0.4, 0.6, 1.0])


def test_a_rotor_pushes_along_its_site(model: mujoco.MjModel) -> None:
    (rotor,) = thrust_sites(model)
    assert rotor["body"] == 1
    assert rotor["position"] == [0.0, 0.1, 0.0]
    assert rotor["direction"] == pytest.approx([0.0, -1.0, 0.0], abs=1e-6)
    assert rotor["most"] == 30.0


def test_poses_are_the_engines_and_turn_without_a_jump(model: mujoco.MjModel) -> None:
    angles = np.linspace(0.0, 4.0 * np.pi, 200)
    poses = body_poses(model, angles[:, None])
    assert poses.shape == (200, 2, 7)
    np.testing.assert_allclose(poses[:, 1, :3], np.tile([0.0, 0.0, 1.0], (200, 1)))
    np.testing.assert_allclose(np.abs(poses[:, 1, 3]), np.abs(np.cos(0.5 * angles)), atol=1e-12)
    assert np.abs(np.diff(poses[:, 1, 3:], axis=0)).max() < 0.04


def test_a_flight_is_packed_with_its_lines_and_curves(run: Run) -> None:
    (flight,) = json.loads(json.dumps(viewer_payload({"hybrid": run}), allow_nan=False))["flights"]
    times = run.log.time.values
    moments = unpacked(flight["moments"])[:, 0]
    assert np.diff(moments) == pytest.approx(1.0 / RATE, abs=np.diff(times).max())
    poses = unpacked(flight["poses"]).reshape(len(moments), flight["bodies"], 7)
    root = run.log.configuration.values[np.abs(times[:, None] - moments).argmin(axis=0), :3]
    np.testing.assert_allclose(poses[:, 1, :3], root, atol=1e-3)
    since, ends = unpacked(flight["trace"]["since"])[:, 0], unpacked(flight["trace"]["ends"])
    assert np.all(np.diff(since) >= -1e-3)
    assert len(ends) == len(since) > 10
    titles = [panel["title"] for panel in flight["panels"]]
    assert titles[:3] == [f"Centre of gravity along {axis}" for axis in "yzx"]
    signals = unpacked(flight["signals"])
    columns = [curve["column"] for panel in flight["panels"] for curve in panel["curves"]]
    assert sorted(columns) == list(range(1, signals.shape[1]))


def test_the_page_needs_nothing_from_elsewhere(run: Run) -> None:
    page = viewer_html({"hybrid": run, "pid": run})
    assert not re.findall(r"<(?:script|link|img|iframe)[^>]+(?:src|href)=", page)
    assert "</script" not in page.split('id="replay-data">')[1].split("</script>")[0]
    assert len(page) < 4_000_000


def test_a_log_without_a_scene_has_no_replay(run: Run) -> None:
    bare = Run(run.name, run.controller, run.log.drop_attrs(), run.metrics)
    assert viewer_html({"bare": bare}) == ""
    with pytest.raises(OutputError, match="recorded without its scene"):
        bare.show()


def test_a_flight_that_drew_nothing_is_packed() -> None:
    for nothing in (np.array([]), np.zeros((0, 3))):
        assert unpacked(packed(nothing)).shape == (0, nothing.shape[1] if nothing.ndim == 2 else 1)


def test_events_are_packed_with_where_a_push_acts(run: Run, make_event, happening) -> None:
    def flight(log):
        return viewer_payload({"hybrid": Run("hybrid", "hybrid", log, {})})["flights"][0]

    assert (flight(run.log)["events"], flight(run.log)["cog"]) == ([], None)
    force, none = [0.0, 2.0, 0.0], [0.0, 0.0, 0.0]
    on_link = make_event(time=3.0, force=force, point=[0.3, 0.0, 0.0])
    change, turn = make_event("gain", 2.0, 0.5, "a to 2"), make_event(time=4.0, force=none, link="")
    packed_flight = flight(happening(run.log, on_link, change, turn))
    assert packed_flight["cog"] is None  # nobody pushes there with a force
    first, second, third = packed_flight["events"]
    assert first == {**change, "number": 1, "push": None}
    assert third["push"] is None
    assert second["push"] == {"force": force, "link": "link4", "body": 4, "point": [0.3, 0.0, 0.0]}
    central = flight(happening(run.log, make_event(force=force, link="", point=none)))
    assert central["events"][0]["push"]["body"] is None
    moments, cog = unpacked(central["moments"])[:, 0], unpacked(central["cog"])
    expected = [np.interp(moments, run.log.time, column) for column in run.log.cog_position.values.T]
    np.testing.assert_allclose(cog, np.transpose(expected), atol=1e-3)
