"""What a campaign of few draws may say, and about how many draws would tell more."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.stats import norm

from skylimb.analysis.figures import style
from skylimb.analysis.scores.axis_names import PAPER
from skylimb.analysis.scores.registry import SCORES
from skylimb.studies.campaign.figures import _running_median, profiles, report_figures
from skylimb.studies.campaign.maps import winner_map
from skylimb.studies.campaign.points import FEW, _apart, points
from skylimb.studies.campaign.report import _pairs, signed
from skylimb.studies.campaign.spec import Bound, CampaignSpec
from skylimb.studies.campaign.statistics import (
    Scores,
    compare_paired,
    draws_needed,
    fewest_draws,
    level_of_pair,
    rank,
    success_rate,
)
from skylimb.studies.campaign.statistics.sign_test import POWER, better
from skylimb.studies.campaign.summary import Summary
from skylimb.studies.campaign.who_wins import draws_needed_for, fails_where, shown_ranks, verdicts

KEY = "error_u_median"
WHAT = "the median |y error| of the CoG to the mission"


def scores_of(values: np.ndarray, names: tuple[str, ...] = ("pid", "hybrid")) -> Scores:
    """Scores of one metric; NaN is a lost flight."""
    finished = np.isfinite(values)
    friction = {"surface.friction": np.linspace(0.2, 0.8, len(values))}
    return Scores(names, np.arange(len(values)), finished, finished, {KEY: values}, friction, {})


def summary_of(scores: Scores) -> Summary:
    ranks = {KEY: rank(scores.cost(KEY))}
    return Summary(scores, {}, {}, {}, ranks, {}, [], [], PAPER)


@pytest.mark.parametrize(("draws", "verdict"), [(2, 0), (5, 0), (6, 1), (40, 1)])
def test_nobody_wins_in_fewer_draws_than_chance_needs(draws: int, verdict: int) -> None:
    """Heads five times in a row happens to every sixteenth pair of equal controllers."""
    first = np.linspace(1.0, 2.0, draws)
    assert better(first, first + 1.0) == verdict
    assert better(first + 1.0, first) == -verdict
    assert better(first, first) == 0


def test_the_fewest_draws_are_those_of_the_sign_test() -> None:
    assert fewest_draws() == 6
    assert fewest_draws(level_of_pair(3)) == 7
    for level in (0.9, 0.95, 0.99, level_of_pair(4)):
        count = fewest_draws(level)
        alike = np.zeros(count)
        assert better(alike, alike + 1.0, level) == 1
        assert better(alike[1:], alike[1:] + 1.0, level) == 0


def test_losses_count_and_equal_draws_do_not() -> None:
    lost = np.full(6, np.inf)
    assert better(np.ones(6), lost) == 1
    assert better(lost, lost) == 0
    assert better(np.r_[np.ones(5), np.ones(20)], np.r_[lost[:5], np.ones(20)]) == 0


def test_the_suggested_number_of_draws_finds_the_difference_about_as_often_as_promised() -> None:
    rng = np.random.default_rng(7)
    differences = rng.normal(0.5, 1.0, 4000)
    count = draws_needed(differences, np.zeros(4000))
    share = norm.cdf(0.5)
    assert count == pytest.approx((1.96 + 0.8416) ** 2 / (4 * (share - 0.5) ** 2), rel=0.15)
    size = int(count)
    found = [better(rng.normal(0.5, 1.0, size), np.zeros(size)) == -1 for _ in range(400)]
    assert np.mean(found) == pytest.approx(POWER, abs=0.08)


def test_the_spread_of_three_draws_is_that_of_a_sample() -> None:
    difference = np.array([0.2, 0.5, 0.8])  # mean 0.5, standard deviation of the sample 0.3
    share = norm.cdf(0.5 / 0.3)
    expected = math.ceil((1.959964 + 0.841621) ** 2 / (4 * (share - 0.5) ** 2))
    assert draws_needed(difference, np.zeros(3)) == expected


def test_what_never_differs_takes_for_ever() -> None:
    assert draws_needed(np.ones(5), np.ones(5)) == math.inf
    assert draws_needed(np.array([1.0, -1.0]), np.zeros(2)) == math.inf


def test_clear_differences_take_the_fewest_draws_and_losses_are_counted() -> None:
    clear = np.array([1.0, 1.1, 1.2])
    assert draws_needed(clear, clear + 5.0 + 0.01 * clear) == 8  # Noether's number for p = 1
    both = draws_needed(np.array([1.0, 1.0]), np.full(2, np.inf))
    assert both == math.ceil((1.959964 + 0.841621) ** 2 / (4 * 0.25**2))  # by Laplace p = 3/4
    half = draws_needed(np.array([1.0, 1.0, 1.0, 1.0]), np.array([np.inf, np.inf, 1.0, 1.0]))
    assert half == pytest.approx(2 * both, abs=2)  # every other draw is a tie


def test_three_draws_give_no_rank_and_say_how_many_would() -> None:
    few = summary_of(scores_of(np.array([[0.114, 0.078], [0.117, 0.080], [0.118, 0.081]])))
    assert verdicts(few, "finishing") == []
    assert shown_ranks(few.ranks[KEY]) == [0, 0]
    assert draws_needed_for(few, KEY) == [f"PID and Hybrid: about 8 draws would tell them apart in {WHAT}"]
    alike = summary_of(scores_of(np.ones((3, 2))))
    assert draws_needed_for(alike, KEY) == [f"PID and Hybrid: no difference in {WHAT}"]
    many = summary_of(scores_of(np.stack([np.linspace(0.1, 0.2, 12), np.linspace(0.3, 0.4, 12)], axis=1)))
    assert shown_ranks(many.ranks[KEY]) == [1, 2]
    assert draws_needed_for(many, KEY) == []


def test_a_large_number_of_draws_is_not_told_to_the_last_one() -> None:
    rng = np.random.default_rng(1)
    values = rng.normal(0.1, 0.01, (6, 2))
    values[:, 1] = values[:, 0] + np.array([1, -1, 1, -1, 1, -0.8]) * 1e-3
    (line,) = draws_needed_for(summary_of(scores_of(values)), KEY)
    number = line.split("about ")[1].split()[0] if "about" in line else "10000"
    assert int(number) % 100 == 0


def test_few_draws_are_drawn_as_points_with_their_numbers() -> None:
    values = np.array([[0.11, 0.08], [0.12, np.nan], [0.13, 0.09]])
    scores = scores_of(values)
    (picture,) = report_figures(scores, KEY, PAPER)
    assert picture.name == "points"
    (ax,) = (ax for ax in points(scores, PAPER).axes if ax.axison)
    drawn = np.concatenate([np.asarray(c.get_offsets()) for c in ax.collections])
    assert {round(float(y), 3) for _, y in drawn} >= {0.11, 0.12, 0.13, 0.08, 0.09}
    assert len(drawn) == 6  # the lost flight has its cross, beyond all others
    assert drawn[:, 1].max() > 0.13
    assert {text.get_text() for text in ax.texts} == {"0", "1", "2"}
    assert "|y error|" in ax.get_ylabel().replace("\n", " ")


def test_draws_that_end_alike_share_a_place() -> None:
    assert _apart([(1.0, 4), (1.01, 2), (2.0, 0)], 0.1) == [(pytest.approx(1.005), "2, 4"), (2.0, "0")]


def test_no_empty_figure_is_drawn() -> None:
    lost = Scores(("pid", "hybrid"), np.arange(3), np.zeros((3, 2), bool), np.zeros((3, 2), bool), {}, {}, {})
    assert report_figures(lost, KEY, PAPER) == []
    assert [picture.name for picture in report_figures(spread(FEW), KEY, PAPER)] == ["profiles", "trends"]


def test_a_difference_that_losses_decide_says_whose_whichever_way_the_metric_is_good() -> None:
    values = np.array([[np.nan, 0.9], [np.nan, 0.8], [np.nan, 0.7]])
    finished = np.isfinite(values)
    scores = Scores(
        ("pid", "hybrid"), np.arange(3), finished, finished,
        {KEY: values, "contact_fraction": values}, {}, {},
    )  # fmt: skip
    costs = {key: scores.cost(key) for key in scores.metrics}
    paired = {
        key: {("pid", "hybrid"): compare_paired(column[:, 0], column[:, 1])} for key, column in costs.items()
    }
    summary = Summary(scores, {}, {}, paired, {}, {}, [], [], PAPER)
    assert [line[4] for line in _pairs(summary, "loss")] == ["first lost (first lost .. first lost)"] * 2


def test_successes_are_no_more_than_flights_that_finished_only_without_bounds() -> None:
    """The first keeps the bounds in all draws, the second in none; both finish all."""
    finished, success = np.ones((8, 2), bool), np.tile([True, False], (8, 1))
    scores = Scores(("pid", "hybrid"), np.arange(8), success, finished, {}, {}, {})
    cost = scores.cost("success")
    summary = Summary(
        scores,
        {
            name: success_rate(int(column.sum()), 8)
            for name, column in zip(scores.controllers, success.T, strict=True)
        },
        {},
        {"success": {("pid", "hybrid"): compare_paired(cost[:, 0], cost[:, 1])}},
        {"success": rank(cost)},
        {"pid": None, "hybrid": None},
        [],
        [],
        PAPER,
    )
    plain = CampaignSpec("paper", ("pid", "hybrid"), draws=8)
    bounded = dataclasses.replace(plain, success={"done": Bound(min=1.0)})
    assert verdicts(summary, plain.aim) == ["PID leads in finishing"]
    assert verdicts(summary, bounded.aim) == ["PID leads in succeeding"]
    assert [_pairs(summary, spec.failure)[0][0] for spec in (plain, bounded)] == [
        "Share of draws with a loss",
        "Share of draws with a failure",
    ]
    assert fails_where(summary, "pid", bounded.failure) == "no failure"
    assert fails_where(summary, "hybrid", bounded.failure) == "all 8 fail"
    nothing = dataclasses.replace(summary, rates={"pid": success_rate(0, 0)})
    assert fails_where(nothing, "pid", bounded.failure) == "nothing was flown"


def test_no_label_of_the_profiles_leaves_the_picture() -> None:
    keys = [KEY, "error_v_median", "displacement_median", "contact_force_normal_std", "tilt_max"]
    values = np.random.default_rng(0).normal(1.0, 0.4, (20, 2))
    values[:6, 0] = np.nan  # lost
    metrics = dict.fromkeys([*keys, "contact_force_normal_peak", "contact_fraction"], values)
    figure = profiles(dataclasses.replace(spread(20, 6), metrics=metrics), PAPER)
    style.png(figure, 170)  # as the report has it
    labels = [ax.xaxis.label.get_window_extent() for ax in figure.axes if ax.get_xlabel()]
    assert len(labels) == len(metrics)
    assert all(label.x0 >= 0.0 and label.x1 <= figure.bbox.x1 for label in labels)


def spread(draws: int, lost: int = 0) -> Scores:
    """Flights over two parameters, some of the first controller's lost."""
    rng = np.random.default_rng(0)
    values = rng.normal(0.1, 0.01, (draws, 2))
    values[:lost, 0] = np.nan
    scores = scores_of(values)
    scores.parameters["approach.depth"] = rng.uniform(0.1, 0.2, draws)
    return scores


def test_maps_need_draws_that_fill_their_cells_and_failures_that_happened() -> None:
    """A cell with a single draw has no winner, and a map of no failure is an empty figure."""
    assert [picture.name for picture in report_figures(spread(31), KEY, PAPER)] == ["profiles", "trends"]
    assert "winners" in {picture.name for picture in report_figures(spread(40), KEY, PAPER)}
    assert "failures" in {picture.name for picture in report_figures(spread(40, lost=3), KEY, PAPER)}
    cells = winner_map(spread(200), KEY, "surface.friction", "approach.depth").axes[0].texts
    assert 16 <= len(cells) <= 25


def test_a_median_along_a_parameter_rests_on_several_flights() -> None:
    x = np.linspace(0.0, 1.0, 9)
    assert _running_median(x, x) == ([], [])
    x = np.linspace(0.0, 1.0, 15)
    assert _running_median(x, x)[0] == pytest.approx([x[2], x[7], x[12]])
    grid = np.repeat([1.0, 2.0], 3)
    assert _running_median(grid, np.arange(6.0)) == ([1.0, 2.0], [1.0, 4.0])


def test_a_number_that_is_zero_as_printed_has_no_sign() -> None:
    assert [signed(value) for value in (-0.001, 0.0, 0.004, -1.5, 1.5, math.nan)] == [
        "0.00",
        "0.00",
        "0.00",
        "−1.50",
        "+1.50",
        "–",
    ]
    assert SCORES[KEY].printed(-1e-5) == "0.000"


def test_few_draws_name_the_controllers_below_each_panel_and_parameters_have_units() -> None:
    scores = scores_of(np.array([[1.0, 2.0], [1.5, 2.5]]))
    labels = points(scores, PAPER).axes[0].get_xticklabels()
    assert [one.get_text() for one in labels] == ["PID", "Hybrid"]
    timed = dataclasses.replace(scores, units={"sensors.latency": "s"})
    assert timed.called("sensors.latency") == "sensors.latency (s)"
    assert timed.called("surface.friction") == "surface.friction"
