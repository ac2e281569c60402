"""What is found of a robot, and how well it is known to be found."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

import skylimb
from skylimb.robots.model import Robot
from skylimb.studies.calibration.estimate import estimate
from skylimb.studies.calibration.fit import HUBER, Fit, robust_weights
from skylimb.studies.calibration.levels import USUAL_NOISE
from skylimb.studies.calibration.parameters import centers, slices, spreads
from skylimb.studies.calibration.public import calibration_from
from skylimb.studies.calibration.record import Record, record_of
from skylimb.studies.calibration.result import Calibration, true_values


def test_everything_is_found_within_its_interval(made: Calibration) -> None:
    found = made.estimate
    assert made.truth is not None
    error = np.abs(found.value - made.truth)
    assert np.all(error < 4.0 * found.deviation)
    # As a physical size: 0.15 degrees, 1.5 mm, 0.5 %, 5 ms, 2 ms.
    at = slices_of(found)
    assert error[at["attitude_misalignment"]].max() < 0.0026
    assert error[at["cog_offset"]].max() < 0.0015
    assert error[at["rotor_scale"]].max() < 0.005
    assert error[at["rotor_lag"]].max() < 0.005
    assert error[at["latency"]].max() < 0.002
    assert found.shown.all()


def slices_of(found) -> dict[str, slice]:
    """Where each parameter stands."""

    return slices(found.parameters)


def test_what_is_left_is_white_and_of_the_noises_size(made: Calibration) -> None:
    left = made.estimate.after
    assert np.sqrt(np.mean(left**2, axis=0)) == pytest.approx(np.ones(6), abs=0.1)
    for lag in (1, 3, 10):
        colour = np.mean(left[lag:] * left[:-lag], axis=0)
        assert np.abs(colour).max() < 4.0 / np.sqrt(len(left))
    assert np.sqrt(np.mean(made.estimate.before**2)) > 3.0


def test_derivatives_are_exact(record: Record) -> None:
    fit = cut(record, 800, 1200)
    theta = centers(fit.parameters) + 0.1 * spreads(fit.parameters)
    (steps,) = fit.steps(theta)
    assert fit.steps(theta.copy())[0].middle is steps.middle  # what noise does not change is not made again
    start = fit.predictor.start(steps, theta)
    known = fit.predictor.filtered(steps, theta, USUAL_NOISE, start)
    here = fit.predictor.predict(steps, theta, start, known)
    assert np.allclose(here.residuals, known.residuals, atol=1e-9)
    for index, size in enumerate(1e-4 * spreads(fit.parameters)):
        residuals = []
        for side in (1.0, -1.0):
            beside = theta.copy()
            beside[index] += side * size
            residuals.append(fit.predictor.predict(fit.steps(beside)[0], beside, start, known).residuals)
        numeric = (residuals[0] - residuals[1]) / (2.0 * size)
        exact = here.by_parameters[:, :, index]
        assert np.abs(exact - numeric).max() < 2e-3 * np.abs(exact).max()


def test_whole_derivatives_are_those_of_the_likelihood(record: Record, made: Calibration) -> None:
    """Gains that are held leave out 2 % of them here, and much more of a record in which joints rest."""
    fit, theta = cut(record, 0, 150), made.estimate.value
    noise = made.estimate.noise._replace(position=1.2e-3, attitude=1.2e-3)  # no residual is Huber's then
    predicted, growth = fit.whole(theta, noise)
    assert max(np.abs(one.residuals).max() for one in predicted) < HUBER
    for index in range(3):
        way = 1e-4 * np.eye(len(theta))[index]
        high, low = (fit.likelihood(fit.filtered(theta + side * way, noise)) for side in (1.0, -1.0))
        slope = sum(2.0 * np.sum(one.by_parameters[:, :, index] * one.residuals) for one in predicted)
        assert slope + growth[index] == pytest.approx((high - low) / 2e-4, rel=2e-3)


def test_the_first_frame_tells_nothing(record: Record, made: Calibration) -> None:
    """The state begins with it: where it was off by rounding it counted, and a likelihood jumped by 70."""
    fit, estimate = cut(record, 0, 100), made.estimate
    ways = 0.1 * np.random.default_rng(0).standard_normal((20, len(estimate.value))) * estimate.deviation
    for way in ways:
        (known,) = fit.filtered(estimate.value + way, estimate.noise)
        (predicted,) = fit.predicted(estimate.value + way, [known])
        assert not known.residuals[0].any()
        assert not predicted.by_parameters[0].any()
        assert len(fit.used([known])) == np.count_nonzero(fit.steps(estimate.value)[0].fresh) - 1


def cut(record: Record, begin: int, end: int) -> Fit:
    """A fit to some ticks of a record."""
    first = record.pieces[0][0]
    return Fit(Record(**{**vars(record), "pieces": ((first + begin, first + end),)}))


def test_frames_that_cannot_be_true_are_left_out(flown: skylimb.Run, made: Calibration, robot: Robot) -> None:
    place = flown.log["root_position_measured"]
    values = place.values.copy()
    # A frame is held for two ticks; of every other wild one, the second tick shows the truth again.
    values[400:600:20] += [0.3, -0.2, 0.5]
    values[401:600:40] += [0.3, -0.2, 0.5]
    values[1000:1060] = np.nan
    log = flown.log.assign(root_position_measured=(place.dims, values, place.attrs))
    found = estimate(record_of(dataclasses.replace(flown, log=log), robot))
    assert len(made.estimate.times) - 50 <= len(found.times) <= len(made.estimate.times) - 40
    assert np.all(np.abs(found.value - made.estimate.value) < 2.0 * made.estimate.deviation)


def test_a_flight_that_never_turns_does_not_tell_wind_from_a_tilted_sensor(
    short: dict[str, Any], otherwise: dict[str, Any], robot: Robot
) -> None:
    still = {**short, **otherwise, "posture.waypoints": [], "trajectory.duration": 8.0}
    still |= {"excitation.x": [], "excitation.y": [], "excitation.heading": []}
    still["excitation.z"] = [[0.03, 0.25, 0.0]]
    flown = skylimb.run("calibration", set=still)
    # The first seconds, in which the robot finds its place, show a little; so would a long flight.
    settled = dataclasses.replace(flown, log=flown.log.isel(time=slice(1000, 2050)))
    made = calibration_from(settled, robot)
    at = slices_of(made.estimate)["lean"]
    assert not made.estimate.shown[at].any()
    assert np.all(made.estimate.deviation[at] < 0.01)
    assert "lean x, lean y" in made.verdict.partition("it does not show ")[2]
    # Nor does it know the heading well: the joints rest.
    assert made.estimate.deviation[slices_of(made.estimate)["attitude_misalignment"]][2] > 0.008
    assert made.truth is not None
    assert np.all(np.abs(made.estimate.value - made.truth) < 4.0 * made.estimate.deviation)


def test_intervals_hold_though_nobody_knows_how_thrusts_go_between_two_ticks(
    short: dict[str, Any], otherwise: dict[str, Any]
) -> None:
    """At 50 Hz rotor scales were 5.5 standard deviations off, lag 9.5, latency 7."""
    made = skylimb.calibrate("calibration", seed=4, set={**short, **otherwise, "controller_rate": 50.0})
    assert made.truth is not None
    beside = np.abs(made.estimate.value - made.truth) / made.estimate.deviation
    assert beside.max() < 3.0, dict(zip(made.estimate.labels, beside.round(1), strict=True))
    at = slices_of(made.estimate)
    # It is still as good as wanted, and the interval says that the way is unknown, not that nothing is.
    assert 1e-4 < made.estimate.deviation[at["rotor_lag"]][0] < 2e-3
    assert made.estimate.shown[:-1].all()  # gravity is known to a few mm/s^2, and used by nobody


def test_thrusts_between_two_ticks_by_either_way(record: Record) -> None:
    """Both agree at the ticks; between them the roots' way is below the chord of its decay."""
    piece, lag = (record.pieces[0][0], record.pieces[0][0] + 200), 0.05
    one, other = (record.steps(piece, lag, 0.0, chord) for chord in (False, True))
    roots, _ = record.roots(lag)
    ticks = np.arange(*piece, record.stride)
    left, parts = np.exp(-record.dt / lag), (np.arange(400) + 0.5) / 400.0
    for k, tick in enumerate(ticks[:20]):
        means = []
        for at in range(tick, tick + record.stride):
            aim = np.sqrt(record.command[at])
            decay = np.exp(-parts * record.dt / lag)[:, None]
            square = (1.0 + left) * decay - left
            away = roots[at] - aim
            means.append((aim**2 + 2.0 * aim * away * decay + away**2 * square).mean(axis=0))
        assert other.thrusts[k] == pytest.approx(np.mean(means, axis=0), abs=1e-6)
    assert np.all(other.thrusts >= one.thrusts - 1e-9)
    assert np.max(other.thrusts - one.thrusts) > 1e-5


KEYS = (
    "plant.rotor_scale",
    "plant.cog_offset",
    "plant.mass_scale",
    "plant.rotor_lag",
    "sensors.attitude_misalignment",
    "sensors.latency",
)


@pytest.mark.slow
@pytest.mark.parametrize("key", KEYS)
def test_each_alone_is_found_and_nothing_else(
    key: str, short: dict[str, Any], otherwise: dict[str, Any], robot: Robot
) -> None:
    flown = skylimb.run("calibration", seed=5, set={**short, key: otherwise[key]})
    found, true = estimate(record_of(flown, robot)), true_values(flown, robot)
    assert true is not None
    assert np.all(np.abs(found.value - true) < 4.0 * found.deviation)


@pytest.mark.slow
def test_intervals_cover_the_truth(short: dict[str, Any], otherwise: dict[str, Any], robot: Robot) -> None:
    scores = []
    for seed in range(30):
        flown = skylimb.run("calibration", seed=seed, set={**short, **otherwise})
        found, true = estimate(record_of(flown, robot)), true_values(flown, robot)
        scores.append((found.value - true) / found.deviation)
    spread = np.sqrt(np.mean(np.square(scores), axis=0))
    assert np.all(spread < 1.5)
    assert np.mean(np.abs(scores) < 1.96) > 0.9


def test_a_residual_beyond_the_bound_pulls_no_more_than_one_at_it() -> None:
    usual = np.random.default_rng(1).normal(size=2000)
    outliers, missing = np.array([10.0, -100.0, 1000.0]), np.zeros(3000)
    for scale in (1.0, 5.0):  # as good as its noise says, and five times worse
        residuals = scale * np.concatenate([usual, outliers, missing])
        weights, deviation = robust_weights(residuals)
        assert deviation == pytest.approx(scale, rel=0.03)
        pull = np.abs(weights * residuals)
        bound = pull[2000:2003]
        np.testing.assert_allclose(bound, bound[0])
        assert bound[0] == pytest.approx(3.0 * deviation)
        inside = np.abs(residuals) < 0.99 * bound[0]
        assert inside.sum() > 4500
        assert (weights[inside] == 1.0).all()
        assert (pull <= bound[0] * (1.0 + 1e-12)).all()
    assert robust_weights(1e-3 * usual)[1] == 1.0  # better than its noise says is no reason to doubt frames


@pytest.mark.slow
def test_unknown_torques_do_not_stand_in_for_the_height_of_the_centre_of_gravity(robot: Robot) -> None:
    """A robot that hardly leans: a search that begins with large torques alone ended 88 mm beside."""
    changes = {
        "plant.rotor_scale": [0.98686, 0.98387, 0.99252, 1.01999],
        "plant.thrust_scale": 0.9994,
        "plant.mass_scale": 1.0072,
        "plant.cog_offset": [0.00068, 0.00566, 0.00186],
        "sensors.attitude_misalignment": [-0.01621, 0.00906, 0.01723],
        "sensors.latency": 0.0102,
    }
    made = calibration_from(skylimb.run("free_flight", "hybrid", seed=638196, set=changes), robot)
    found = made.estimate.value[slices_of(made.estimate)["cog_offset"]]
    np.testing.assert_allclose(found, changes["plant.cog_offset"], atol=5e-4)
