"""What docs/reports/scores.md says of shipped flights: which are done, and why a hard press is not."""

import re
from pathlib import Path

import pytest

import skylimb

PAGE = (Path(__file__).parents[3] / "docs" / "reports" / "scores.md").read_text(encoding="utf-8")
FORCE = "controller.translation.force"


def told(experiment: str, controller: str) -> str:
    """The cell of the page's table."""
    row = re.search(rf"^\| `{experiment}` \| (.*) \| (.*) \|$", PAGE, re.MULTILINE)
    assert row is not None
    return row[1 if controller == "hybrid" else 2]


@pytest.mark.parametrize(
    ("experiment", "controller"),
    [("paper", "hybrid"), ("paper", "following"), ("friction_patches", "following"), ("push", "hybrid")],
)
def test_the_page_tells_the_verdict(experiment: str, controller: str) -> None:
    run = skylimb.run(experiment, controller)
    words = told(experiment, controller)
    assert words.split(":")[0] == {True: "yes", False: "no", None: "not judged"}[run.done]
    checks = run.metrics["checks"]
    if "touch" in words:
        assert f"touch {100.0 * checks['contact']['value']:.0f} %" in words
    if "drawn" in words:
        assert f"{100.0 * checks['path']['value']:.0f} % drawn" in words
    if "force" in words:
        assert f"force {100.0 * checks['force']['value']:.0f} % off" in words


def test_a_press_of_5_newtons_is_missed_and_says_why() -> None:
    """On 20 degrees friction takes too much of it: the pen lags, is pressed less, and comes off."""
    run = skylimb.run("paper", "following", set={FORCE: 5.0})
    assert run.status == "OK"
    assert run.done is False
    assert run.metrics["force_error_percent"] > 15.0
    limits = run.metrics["force_limits"]
    assert limits["eased_for_lag"]["share"] > 0.2
    assert limits["eased_for_lag"]["error"] < -0.1
    assert sum(limit["error"] for limit in limits.values()) == pytest.approx(run.metrics["force_error_mean"])
    assert "the press was eased while the pen lagged its path" in run.missed[0]


def test_a_press_of_4_newtons_is_kept_and_its_line_is_not() -> None:
    run = skylimb.run("paper", "following", set={FORCE: 4.0})
    assert run.done is False
    assert run.metrics["force_error_percent"] < 3.0
    assert all("of the line" in missed for missed in run.missed)


def test_a_press_of_2_newtons_is_done() -> None:
    run = skylimb.run("paper", "following", set={FORCE: 2.0})
    assert run.done is True
    assert run.metrics["contact_force_normal_mean"] == pytest.approx(2.0, rel=0.02)
