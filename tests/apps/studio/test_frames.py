"""What a page is sent of a moment has the names and the numbers of the log, and of the report's plots."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from skylimb.analysis.scores.signals import contact_axis
from skylimb.analysis.viewer.signals import packed_panels, smoothed
from skylimb.apps.studio.keeping import so_far
from skylimb.apps.studio.session import Session
from unpacking import unpacked

IMPLIED = {
    "cog_position", "cog_position_reference", "reach", "reach_reference", "joint_angles", "vectoring_angles",
    "tip_position", "tip_position_reference", "attitude", "tilt", "phase",
}  # fmt: skip
"""What the report plots and no tick records."""


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Session:
    session = Session("paper", out=tmp_path_factory.mktemp("frames"))
    session.advance(2200)  # it touches by then
    return session


@pytest.mark.parametrize("ticks", [1, 700, 2200])
def test_the_signals_of_a_frame_are_those_of_the_log(session: Session, ticks: int) -> None:
    live, log = session.live, so_far(session.live.flights[0]).log
    scene = live.scene()
    first, end = scene["layout"]["flights"][0]["signals"]
    numbers = live.frame(1.0, False, ticks)[first:end]
    described = {one["name"]: one for one in scene["flights"][0]["signals"]}
    assert described.keys() >= IMPLIED
    assert set(described) - set(map(str, log.data_vars)) == {"configuration_velocity"}
    row = log.isel(time=ticks - 1)
    assert float(row.time) == pytest.approx((ticks - 1) * live.period)
    for name, one in described.items():
        if name in log:
            shown = numbers[one["column"] : one["column"] + len(one["labels"])]
            kept = np.ravel(row[name].values).astype(np.float32)
            np.testing.assert_allclose(shown, kept, rtol=1e-6, atol=1e-9, err_msg=name)


def test_the_pressing_force_is_that_of_the_reports_plot(session: Session) -> None:
    live, log = session.live, so_far(session.live.flights[0]).log
    scene = live.scene()
    (panel,) = (one for one in scene["flights"][0]["panels"] if one["title"] == "Pressing force")
    first = scene["layout"]["flights"][0]["curves"][0]
    toward = contact_axis(log)
    for label, signal in (("true", "contact_force"), ("felt", "external_force_estimate")):
        (curve,) = (one for one in panel["curves"] if one["label"] == label)
        plotted = -smoothed(log, toward.along(log[signal].values))
        for ticks in (600, 2100, 2200):
            shown = live.frame(1.0, False, ticks)[first + curve["column"]]
            assert shown == pytest.approx(plotted[ticks - 1], abs=1e-6)
    assert plotted[-1] > 0.1


def test_around_a_pipe_the_pressing_force_turns_with_the_path(tmp_path: Path) -> None:
    session = Session("pipe_around", out=tmp_path)
    session.advance(2600)  # it presses from the other side than in the middle of its path
    live, log = session.live, so_far(session.live.flights[0]).log
    normal = smoothed(log, log.contact_force_normal.values)
    assert normal[-1] > 0.5
    scene = live.scene()
    (panel,) = (one for one in scene["flights"][0]["panels"] if one["title"] == "Pressing force")
    (curve,) = (one for one in panel["curves"] if one["label"] == "true")
    column = scene["layout"]["flights"][0]["curves"][0] + curve["column"]
    assert live.frame(1.0, False, 2600)[column] == pytest.approx(normal[-1], abs=0.1)
    report = packed_panels(log)
    (panel,) = (one for one in report["panels"] if one["title"] == "Pressing force")
    numbers = unpacked(report["signals"]).reshape(-1, 1 + sum(len(one["curves"]) for one in report["panels"]))
    plotted = numbers[:, panel["curves"][0]["column"]]
    kept = np.interp(numbers[:, 0], log.time.values, normal)
    sliding = numbers[:, 0] > 12.0
    np.testing.assert_allclose(plotted[sliding], kept[sliding], atol=0.1)
