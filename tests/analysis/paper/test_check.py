"""The paper's numbers and claims, held against runs."""

import pytest

from skylimb.analysis.paper.check import check_claims
from skylimb.analysis.paper.numbers import PUBLISHED, published, published_beside
from skylimb.analysis.recording import Run

NAMES = ("pid", "impedance", "admittance", "hybrid")


def with_scores(make_log, **scores):
    """Runs that score what the paper printed, unless said otherwise."""
    runs = {}
    for name in NAMES:
        numbers = dict(vars(PUBLISHED[name])) | scores.get(name, {})
        runs[name] = Run(name, name, make_log(name, slide=1.0), numbers)
    return runs


def test_the_papers_numbers():
    assert [published(name, "error_u_median") for name in NAMES] == [0.134, 0.079, 0.105, 0.083]
    assert [published(name, "displacement_median") for name in NAMES] == [0.133, 0.137, 0.088, 0.084]
    assert [published(name, "estimated_force_median") for name in NAMES] == [-1.190, -0.453, -0.712, -0.328]
    assert published("pid", "error_v_median") is None
    assert published("mine", "error_u_median") is None


def test_the_paper_agrees_with_itself(make_log):
    claims = check_claims(with_scores(make_log))
    assert len(claims) == 5
    assert all(claim.holds for claim in claims[:4])
    assert claims[1].paper == "impedance 0.137, hybrid 0.084 m (ratio 0.61)"
    assert claims[1].ours.endswith("(ratio 0.61)")
    assert claims[2].paper.endswith("(ratio 0.66)")
    assert claims[4].paper == "shown in a box plot, no number"


@pytest.mark.parametrize(
    ("which", "scores"),
    [
        (0, {"hybrid": {"error_u_median": 0.2}}),
        (1, {"hybrid": {"displacement_median": 0.14}}),
        (2, {"admittance": {"displacement_median": 0.14}}),
        (3, {"hybrid": {"estimated_force_median": -0.5}}),
    ],
)
def test_a_claim_that_does_not_hold_is_not_said_to(make_log, which, scores):
    assert not check_claims(with_scores(make_log, **scores))[which].holds


def test_the_spread_of_the_force_is_measured(make_log):
    runs = with_scores(make_log)
    runs["pid"].log.external_force_estimate[::2, 0] = -3.0
    assert check_claims(runs)[4].holds
    runs["hybrid"].log.external_force_estimate[::2, 0] = -5.0
    assert not check_claims(runs)[4].holds


def test_claims_need_finished_flights(make_log):
    runs = with_scores(make_log)
    runs["pid"] = Run("pid", "pid", make_log("pid", status="FAILED", cause="x", slide=1.0), {})
    assert len(check_claims(runs)) == 1  # only hybrid against impedance is left


def test_claims_are_about_the_papers_configuration_whatever_the_experiment_is_called(make_log):
    runs = with_scores(make_log)
    for run in runs.values():
        run.log.attrs["experiment"] = "mine"
    assert len(check_claims(runs)) == 5
    changed = runs["pid"].log
    changed.attrs |= {
        "experiment": "paper",
        "config": changed.attrs["config"].replace("friction = 0.4", "friction = 0.3"),
    }
    assert [claim.text[:26] for claim in check_claims(runs)] == [
        "The hybrid displaces the b"
    ]  # hybrid against impedance
    assert published_beside(runs["pid"], "error_u_median") is None
    assert published_beside(runs["hybrid"], "error_u_median") == 0.083
