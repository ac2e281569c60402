import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import skylimb

EXAMPLES = Path(__file__).parents[1] / "examples"

EXPECTED = {
    "stepped": ["touched at", "stopped from outside", "pressed with up to"],
    "run": ["hybrid: OK", "error_u_median", "estimated force while in touch"],
    "user_path": ["OK: the pen is "],
    "user_plant": ["OK: 0.", " N in touch"],
    "user_metric": [" pid: overshoot", " hybrid: overshoot", "rad"],
    "user_controller": ["hybrid: OK", " upright: OK"],
    "user_slope": ["20 degrees, leak as in the paper: OK", "FAILED, lost position", "leak compensated: OK"],
    "user_gains": ["k_a =    8 N/m: OK", "k_a =   32 N/m: OK"],
}


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(path, id=path.stem, marks=[pytest.mark.slow] if path.stem == "user_plant" else [])
        for path in sorted(EXAMPLES.glob("*.py"))
    ],
)
def test_examples_run(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    runpy.run_path(str(path), run_name="__main__")
    out = capsys.readouterr().out
    for line in EXPECTED[path.stem]:
        assert line in out


CORNERS = {
    "trajectory.shape": "lawnmower",
    "trajectory.speed": 0.2,
    "trajectory.length": 0.5,
    "trajectory.strokes": 3,
    "trajectory.feedforward": "velocity",
    "approach.contact": False,
}
"""Strokes that turn by a right angle at once."""


def law(name: str) -> str:
    return str(EXAMPLES / "laws" / f"{name}.toml")


@pytest.mark.parametrize("name", sorted(path.stem for path in (EXAMPLES / "laws").glob("*.toml")))
def test_a_preset_with_an_example_law_flies_the_papers_experiment(name: str) -> None:
    run = skylimb.run("paper", controller=law(name))
    assert run.status == "OK", run.cause
    assert float(run.metrics["contact_force_normal_mean"]) > 0.5


def test_the_saddle_is_followed_all_around() -> None:
    run = skylimb.run(str(EXAMPLES / "surfaces" / "saddle.toml"))
    assert run.status == "OK", run.cause
    touched = run.log.contact_trace.values[run.log.contact.values > 0.0]
    assert np.ptp(touched, axis=0).min() > 0.55
    # By 0.2 (0.3 m)^2 it stands out at the sides, and recedes above and below.
    tip = run.log.tip_position.sel(axis="x").values[run.log.phase.values == 4]
    assert np.ptp(tip) > 0.03


def off_the_path(controller: str, **changes: Any) -> float:
    """Root mean square distance of the centre of gravity from its path while it slides, m."""
    run = skylimb.run("paper", controller=controller, set={**CORNERS, **changes})
    assert run.status == "OK", run.cause
    log = run.log.isel(time=np.flatnonzero(run.log.phase == 4))
    return float(np.sqrt(((log.cog_position - log.cog_position_reference) ** 2).sum("axis").mean()))


def test_a_preview_takes_corners_better() -> None:
    seen = off_the_path(law("preview"))
    assert seen < 0.015
    assert seen < 0.4 * off_the_path(law("preview"), **{"controller.translation.preview": False})
    assert seen < 0.4 * off_the_path("hybrid")


def test_an_extended_state_observer_is_calmer_than_the_papers() -> None:
    def noise(controller: str) -> np.ndarray:
        run = skylimb.run("paper", controller=controller, set=CORNERS)
        log = run.log.isel(time=np.flatnonzero((run.log.phase == 1) & (run.log.time > 4.0)))
        return (log.external_force_estimate + log.external_force_bias).std("time").values

    assert (noise(law("extended_state")) < 0.5 * noise("hybrid")).all()
