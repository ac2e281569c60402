import numpy as np
import pytest
from scipy.stats import beta, binom

from skylimb.studies.campaign.statistics import (
    Scores,
    compare_paired,
    failure_region,
    parameters_by_information,
    rank,
    success_rate,
)
from skylimb.studies.campaign.statistics.intervals import dominance_interval, median, median_interval
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


@pytest.mark.parametrize("count", [6, 8, 20, 51])
def test_the_interval_of_a_median_lies_between_values_that_the_binomial_distribution_names(
    count: int,
) -> None:
    """The k-th value lies above the median with the chance of fewer than k heads."""
    low, high = median_interval(np.random.default_rng(1).permutation(count) + 1.0)
    assert (low, high) == (low, count + 1 - low)
    assert binom.cdf(low - 1, count, 0.5) <= 0.025 < binom.cdf(low, count, 0.5)


def test_fewer_than_six_draws_show_the_smallest_and_the_largest() -> None:
    assert median_interval(np.array([3.0])) == (3.0, 3.0)
    assert median_interval(np.array([3.0, np.inf, 1.0, 2.0, 4.0])) == (1.0, np.inf)


@pytest.mark.parametrize("count", [8, 15])
@pytest.mark.parametrize(
    ("won", "lost"), [(0.5, 0.5), (0.8, 0.2), (0.95, 0.05), (0.05, 0.95), (0.3, 0.1), (0.1, 0.0)]
)
def test_the_interval_of_the_dominance_covers(count: int, won: float, lost: float) -> None:
    """Over all that may come of the draws, each by its chance."""
    covered = 0.0
    for wins in range(count + 1):
        for defeats in range(count + 1 - wins):
            low, high = dominance_interval(wins, defeats, count)
            if low <= won - lost <= high:
                chance = binom.pmf(wins, count, won)
                covered += chance * binom.pmf(defeats, count - wins, min(1.0, lost / (1.0 - won)))
    assert covered >= 0.95


def test_a_controller_that_won_all_draws_may_lose_one() -> None:
    low, high = dominance_interval(8, 0, 8)
    assert high == 1.0
    assert 0.1 < low < 0.3
    pair = compare_paired(np.zeros(8), np.ones(8))
    assert (pair.dominance, pair.dominance_low, pair.dominance_high) == (1.0, low, high)


def test_a_loss_counts_as_a_loss() -> None:
    first = np.array([1.0, np.inf, np.inf, 1.0, 1.0])
    second = np.array([2.0, 2.0, np.inf, np.inf, 0.5])
    pair = compare_paired(first, second)
    assert (pair.wins, pair.ties, pair.defeats) == (2, 1, 2)
    assert pair.dominance == 0.0
    assert pair.both_finished == 2
    assert pair.standardized == pytest.approx(-0.25 / np.std([-1.0, 0.5], ddof=1))


def test_losses_decide_the_median_where_they_are_the_majority() -> None:
    first, second = np.full(10, np.inf), np.linspace(1.0, 2.0, 10)
    pair = compare_paired(first, second)
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
    found = medians(scores, "target_error_u_median")
    assert found[0][0] == pytest.approx(0.2)
    assert np.isnan(found[1]).all()
    assert found[2][0] == np.inf


def test_a_verdict_has_its_rate_over_all_draws_and_a_lost_flight_was_not_done() -> None:
    finished = np.array([[True], [True], [True], [False]])
    done = np.array([[1.0], [0.0], [1.0], [np.nan]])
    scores = Scores(("one",), np.arange(4), finished, finished, {"done": done}, {}, {})
    ((rate, low, high),) = medians(scores, "done")
    assert rate == pytest.approx(0.5)
    assert 0.0 < low < 0.1 < 0.9 < high < 1.0


def test_paired_draws_see_what_unpaired_ones_cannot() -> None:
    rng = np.random.default_rng(3)
    draws = rng.normal(0.0, 10.0, 40)
    pair = compare_paired(draws + 0.1 + 0.05 * rng.normal(size=40), draws)
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
    """However many conditions are tried: one campaign in a hundred has a region by chance."""
    rng = np.random.default_rng(7)
    found = 0
    for _ in range(15):
        parameters = {f"p{i}": rng.normal(size=150) for i in range(10)}
        found += failure_region(parameters, rng.random(150) < 0.3) is not None
    assert found <= 1
    assert failure_region({"a": np.arange(10.0)}, np.zeros(10, dtype=bool)) is None
    assert failure_region({}, np.arange(20) % 2 == 0) is None


def test_a_region_by_values_that_are_names_is_found_and_the_same_each_time() -> None:
    rng = np.random.default_rng(8)
    surface = rng.choice(["board", "sine", "step"], 120)
    failed = (surface == "sine") & (rng.random(120) < 0.7)
    first, second = (
        failure_region({"surface": surface, "other": np.arange(120.0)}, failed) for _ in range(2)
    )
    assert first is not None
    assert first == second
    assert str(first.conditions[0]) == "surface = sine"


def test_a_bound_that_a_tighter_one_follows_is_said_once() -> None:
    friction = np.linspace(0.0, 1.0, 400)
    failed = (friction > 0.5) | ((friction > 0.4) & (np.arange(400) % 5 > 0))  # all, and most
    region = failure_region({"friction": friction}, failed)
    assert region is not None
    (condition,) = region.conditions
    assert (condition.parameter, condition.sign) == ("friction", ">")
    assert condition.value == pytest.approx(0.5, abs=0.01)
    assert region.draws == int(condition.holds(friction).sum())
