import numpy as np
import pytest
from scipy.stats import beta, bootstrap

from skylimb.studies.campaign.statistics import (
    Scores,
    compare_paired,
    failure_region,
    parameters_by_information,
    rank,
    success_rate,
)
from skylimb.studies.campaign.statistics.intervals import bootstrap_interval, median
from skylimb.studies.campaign.summary import medians


@pytest.mark.parametrize(("successes", "count"), [(0, 10), (10, 10), (3, 17), (490, 500)])
def test_clopper_pearson_is_the_quantile_of_the_beta_distribution(successes: int, count: int) -> None:
    rate = success_rate(successes, count)
    low = beta.ppf(0.025, successes, count - successes + 1) if successes else 0.0
    high = beta.ppf(0.975, successes + 1, count - successes) if successes < count else 1.0
    assert (rate.low, rate.high) == pytest.approx((low, high), abs=1e-9)


def test_the_rule_of_three() -> None:
    """No failure in n flights: the failure rate is below 1 - 0.025^(1/n)."""
    assert 1.0 - success_rate(100, 100).low == pytest.approx(1.0 - 0.025 ** (1 / 100), abs=1e-9)


def test_bootstrap_intervals_agree_with_scipys() -> None:
    rng = np.random.default_rng(0)
    values = rng.normal(1.0, 2.0, 200)
    low, high = bootstrap_interval(np.mean, values, 0)
    reference = bootstrap(
        (values,), np.mean, method="percentile", n_resamples=20_000, rng=rng
    ).confidence_interval
    assert low == pytest.approx(reference.low, abs=0.03)
    assert high == pytest.approx(reference.high, abs=0.03)


def test_a_bootstrap_interval_of_a_mean_has_the_width_of_theory() -> None:
    values = np.random.default_rng(1).normal(0.0, 1.0, 2000)
    low, high = bootstrap_interval(np.mean, values, 0)
    assert high - low == pytest.approx(2 * 1.96 / np.sqrt(2000), rel=0.08)


def test_a_loss_counts_as_a_loss() -> None:
    first = np.array([1.0, np.inf, np.inf, 1.0, 1.0])
    second = np.array([2.0, 2.0, np.inf, np.inf, 0.5])
    pair = compare_paired(first, second, 0)
    assert (pair.wins, pair.ties, pair.defeats) == (2, 1, 2)
    assert pair.dominance == 0.0
    assert pair.both_finished == 2
    assert pair.standardized == pytest.approx(-0.25 / np.std([-1.0, 0.5], ddof=1))


def test_losses_decide_the_median_where_they_are_the_majority() -> None:
    first, second = np.full(10, np.inf), np.linspace(1.0, 2.0, 10)
    pair = compare_paired(first, second, 0)
    assert pair.median == np.inf
    assert pair.low == pair.high == np.inf
    assert median(np.array([1.0, 2.0, np.inf])) == 2.0
    assert median(np.array([-np.inf, 2.0])) == -np.inf


def test_a_number_that_a_controller_does_not_have_is_no_loss() -> None:
    finished = np.array([[True, True, True], [True, True, False]])
    values = np.array([[0.1, np.nan, 0.2], [0.3, np.nan, np.nan]])
    scores = Scores(
        ("has", "has not", "loses"),
        np.arange(2),
        finished,
        finished,
        {"target_error_u_median": values},
        {},
        {},
    )
    found = medians(scores, "target_error_u_median", 0)
    assert found[0][0] == pytest.approx(0.2)
    assert np.isnan(found[1]).all()
    assert found[2][0] == np.inf


def test_a_verdict_has_its_rate_over_all_draws_and_a_lost_flight_was_not_done() -> None:
    finished = np.array([[True], [True], [True], [False]])
    done = np.array([[1.0], [0.0], [1.0], [np.nan]])
    scores = Scores(("one",), np.arange(4), finished, finished, {"done": done}, {}, {})
    ((rate, low, high),) = medians(scores, "done", 0)
    assert rate == pytest.approx(0.5)
    assert 0.0 < low < 0.1 < 0.9 < high < 1.0


def test_paired_draws_see_what_unpaired_ones_cannot() -> None:
    rng = np.random.default_rng(3)
    draws = rng.normal(0.0, 10.0, 40)
    pair = compare_paired(draws + 0.1 + 0.05 * rng.normal(size=40), draws, 0)
    assert 0.05 < pair.low < 0.1 < pair.high < 0.15


def test_equal_controllers_share_a_rank_and_clear_ones_do_not() -> None:
    rng = np.random.default_rng(4)
    noise = rng.normal(size=(300, 3))
    costs = noise + np.array([0.0, 0.0, 1.5])
    assert rank(costs) == [1, 1, 3]
    costs[:, 0] = np.inf
    assert rank(costs) == [3, 1, 2]


def test_ranks_of_equal_controllers_are_rarely_told_apart() -> None:
    """With 95 % for all comparisons together, at most about one campaign in twenty ranks equals apart."""
    rng = np.random.default_rng(5)
    apart = sum(rank(rng.normal(size=(60, 4))) != [1, 1, 1, 1] for _ in range(60))
    assert apart <= 8


def test_a_region_of_failure_is_found_and_told() -> None:
    rng = np.random.default_rng(6)
    parameters = {"friction": rng.uniform(0.1, 0.8, 400), "slope": rng.choice([-0.3, 0.3], 400),
                  "nothing": rng.normal(size=400)}  # fmt: skip
    failed = (parameters["friction"] > 0.6) & (parameters["slope"] == -0.3)
    region = failure_region(parameters, failed)
    assert region is not None
    assert {condition.parameter for condition in region.conditions} == {"friction", "slope"}
    assert region.failed == failed.sum()
    assert region.failed >= 0.95 * region.draws
    threshold = next(c.value for c in region.conditions if c.parameter == "friction")
    assert threshold == pytest.approx(0.6, abs=0.02)
    assert parameters_by_information(parameters, failed[:, None])[-1] == "nothing"


def test_no_region_is_told_where_there_is_none() -> None:
    rng = np.random.default_rng(7)
    found = [
        failure_region({"a": rng.normal(size=200)}, rng.random(200) < 0.2) is not None for _ in range(40)
    ]
    assert sum(found) <= 4
    assert failure_region({"a": np.arange(10.0)}, np.zeros(10, dtype=bool)) is None


def test_a_bound_that_a_tighter_one_follows_is_said_once() -> None:
    friction = np.linspace(0.0, 1.0, 400)
    failed = (friction > 0.5) | ((friction > 0.4) & (np.arange(400) % 5 > 0))  # all, and most
    region = failure_region({"friction": friction}, failed)
    assert region is not None
    (condition,) = region.conditions
    assert (condition.parameter, condition.sign) == ("friction", ">")
    assert condition.value == pytest.approx(0.5, abs=0.01)
    assert region.draws == int(condition.holds(friction).sum())
