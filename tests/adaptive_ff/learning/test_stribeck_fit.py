import math
import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats
from scipy.optimize import curve_fit, least_squares
from scipy.special import polygamma, psi

from adaptive_ff.learning.stribeck import Points, _inverse_information, fit_stribeck, search
from adaptive_ff.learning.support_points import support_points
from plant import Stribeck, sliding_friction

TRUE = Stribeck(60.0, 90.0, 80.0, 0.05, 1.0)
SPEEDS = np.geomspace(0.005, 0.35, 30)
BOTH = np.concatenate([-SPEEDS[::-1], SPEEDS])


def torque_of(friction, velocity):
    return np.array([math.copysign(sliding_friction(friction, abs(w)), w) for w in velocity])


def noisy(seed, velocity=BOTH, error=0.01, friction=TRUE):
    exact = torque_of(friction, velocity)
    spread = error * np.abs(exact)
    return velocity, exact + spread * np.random.default_rng(seed).standard_normal(velocity.size), spread


@pytest.fixture(scope="module")
def noisy_fit():
    return fit_stribeck(*noisy(1))


@settings(max_examples=25, deadline=None)
@given(st.floats(1.0, 200.0), st.floats(1.1, 3.0), st.floats(1.0, 300.0), st.floats(0.01, 0.15), st.floats(0.6, 3.0))
def test_points_without_error_give_back_the_curve(coulomb, ratio, viscous, stribeck_velocity, shape):
    true = Stribeck(coulomb, ratio * coulomb, viscous, stribeck_velocity, shape)
    speeds = np.geomspace(0.001, 1.0, 25)
    fit = fit_stribeck(speeds, torque_of(true, speeds))
    found = {name: estimate.value for name, estimate in fit.estimates.items()}
    assert found == pytest.approx(true._asdict(), rel=1e-7)
    assert fit.curve(speeds) == pytest.approx(torque_of(true, speeds), rel=1e-9)
    assert fit.determined


def test_offset_of_the_torque_is_told_from_friction_where_both_directions_are_given():
    fit = fit_stribeck(BOTH, torque_of(TRUE, BOTH) - 7.0)
    assert fit.estimates["offset"].value == pytest.approx(-7.0, abs=1e-8)
    assert fit.estimates["coulomb"].value == pytest.approx(60.0, rel=1e-8)
    assert fit.residuals == pytest.approx(np.zeros(60), abs=1e-8)
    true = np.array([*TRUE, -7.0])
    steps = np.diag(1e-5 * true)
    slopes = np.column_stack([(curve(BOTH, *(true + h)) - curve(BOTH, *(true - h))) / 2.0 / sum(h) for h in steps])
    least = 1e-9 * np.max(np.abs(torque_of(TRUE, BOTH) - 7.0))  # rounding: the points have no other error
    assert fit.covariance == pytest.approx(least**2 * np.linalg.inv(slopes.T @ slopes), rel=1e-3, abs=1e-22)
    forward = fit_stribeck(SPEEDS, torque_of(TRUE, SPEEDS))
    assert "offset" not in forward.estimates
    assert forward.residuals == pytest.approx(np.zeros(SPEEDS.size), abs=1e-8)


def test_one_direction_backward_is_as_good_as_forward(noisy_fit):
    velocity, torque, error = noisy(3, SPEEDS)
    forward, backward = fit_stribeck(velocity, torque, error), fit_stribeck(-velocity, -torque, error)
    for name, estimate in forward.estimates.items():
        assert backward.estimates[name] == pytest.approx(estimate, rel=1e-6)
    assert backward.curve([-0.1, 0.0, 0.1]) == pytest.approx(-forward.curve([0.1, 0.0, -0.1]))


def curve(velocity, coulomb, stiction, viscous, stribeck_velocity, shape, offset):
    share = np.exp(-((np.abs(velocity) / stribeck_velocity) ** shape))
    return np.sign(velocity) * (coulomb * (1.0 - share) + stiction * share) + viscous * velocity + offset


def test_estimates_and_covariance_are_those_of_curve_fit(noisy_fit):
    velocity, torque, error = noisy(1)
    start = (50.0, 100.0, 100.0, 0.04, 1.2, 0.0)
    values, covariance = curve_fit(curve, velocity, torque, start, error, method="lm", ftol=1e-13, xtol=1e-13)
    assert [estimate.value for estimate in noisy_fit.estimates.values()] == pytest.approx(values, rel=1e-5, abs=1e-4)
    assert noisy_fit.covariance == pytest.approx(covariance, rel=1e-3, abs=1e-7)
    assert noisy_fit.residuals == pytest.approx(torque - curve(velocity, *values), abs=1e-3)
    assert noisy_fit.scatter == pytest.approx(math.sqrt(np.sum((noisy_fit.residuals / error) ** 2) / 54))


def test_information_is_infinite_for_what_the_columns_do_not_determine():
    first, second = np.random.default_rng(4).standard_normal((2, 20))
    inverse = _inverse_information(np.column_stack([1e3 * first, second, -2.0 * second, 0.0 * first]))
    assert np.isinf(inverse[1:]).all()
    assert np.isinf(inverse[0, 1:]).all()
    off = first - second * (first @ second) / (second @ second)
    assert inverse[0, 0] == pytest.approx(1e-6 / (off @ off), rel=1e-9)


@pytest.mark.parametrize("name", [*TRUE._fields, "offset"])
def test_interval_ends_where_the_sum_of_squares_has_risen_by_students_t(noisy_fit, name):
    velocity, torque, error = noisy(1)
    points = Points(velocity, torque, 1.0 / error, True)
    squares = float(np.sum((noisy_fit.residuals / error) ** 2))
    rise = stats.t.ppf(0.975, 54) ** 2 * squares / 54
    estimate = noisy_fit.estimates[name]
    assert estimate.lower < estimate.value < estimate.upper
    for end in (estimate.lower, estimate.upper):
        held = math.log(end) if name.startswith("stribeck") else end
        there = search(points, (name, held))[1] - squares
        assert math.sqrt(there / rise) == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize("seed", [5, 19, 47])
def test_search_finds_the_lowest_of_several_minima(seed):
    """Oracle: least_squares of scipy from many starts, where no sign is violated."""
    velocity, torque, error = noisy(seed, np.geomspace(0.003, 0.35, 12), 0.1)
    found = search(Points(velocity, torque, 1.0 / error, False))[1]
    for start in ((60.0, 90.0, 80.0, speed, shape) for speed in (0.01, 0.1) for shape in (0.5, 2.0)):
        values = least_squares(
            lambda p: (curve(velocity, *p, 0.0) - torque) / error,
            start,
            bounds=([0.0, 0.0, 0.0, 1e-4, 0.01], [np.inf, np.inf, np.inf, 40.0, 100.0]),
        )
        if values.x[1] >= values.x[0]:
            assert found <= 2.0 * values.cost * (1.0 + 1e-6)


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("velocity", "error", "trials"), [(BOTH, 0.003, 120), (np.geomspace(0.003, 0.35, 12), 0.03, 60)]
)
def test_intervals_hold_the_truth_as_often_as_they_say(velocity, error, trials):
    hits = dict.fromkeys(("stribeck_velocity", "stribeck_shape", "coulomb"), 0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        for seed in range(trials):
            fit = fit_stribeck(*noisy(seed, velocity, error), confidence=0.8)
            for name in hits:
                estimate = fit.estimates[name]
                hits[name] += estimate.lower <= getattr(TRUE, name) <= estimate.upper
    low, high = stats.binom.ppf([1e-4, 1.0 - 1e-4], trials, 0.8)
    for name, count in hits.items():
        assert low <= count <= high, name


@pytest.mark.parametrize(
    ("velocity", "friction"),
    [
        (np.linspace(0.4, 1.0, 30), TRUE),  # no point in the Stribeck range
        (SPEEDS, TRUE._replace(stiction=60.0)),  # no Stribeck peak
        (np.geomspace(0.0002, 0.002, 30), TRUE),  # nothing but it
    ],
)
def test_warns_where_the_points_do_not_tell_the_curve(velocity, friction):
    with pytest.warns(UserWarning, match="do not identify the Stribeck curve"):
        fit = fit_stribeck(*noisy(8, velocity, 0.003, friction))
    assert not fit.determined
    ends = [fit.estimates[name][2:] for name in ("stribeck_velocity", "stribeck_shape", "coulomb")]
    assert any(upper > 10.0 * lower for lower, upper in ends)


@pytest.mark.parametrize("seed", range(8))
def test_friction_stays_possible_on_poor_points(seed):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        fit = fit_stribeck(*noisy(seed, np.geomspace(0.003, 0.35, 12), 0.1))
    found = {name: estimate.value for name, estimate in fit.estimates.items()}
    assert found["stiction"] >= found["coulomb"] >= 0.0
    assert found["viscous"] >= 0.0
    assert min(found["stribeck_velocity"], found["stribeck_shape"]) > 0.0
    for estimate in fit.estimates.values():
        assert estimate.lower <= estimate.value <= estimate.upper


GOOD = (SPEEDS, torque_of(TRUE, SPEEDS), np.ones(30))


def changed(which, place, value):
    arrays = [np.array(array) for array in GOOD]
    arrays[which][place] = value
    return arrays


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (changed(0, 5, 0.0), r"velocity\[5\] = 0 is not allowed: at rest"),
        (changed(2, 6, 0.0), r"standard_error\[6\] = 0 is not allowed: it must be positive"),
        (changed(2, 6, -2.0), r"standard_error\[6\] = -2 is not allowed"),
        ((SPEEDS[:5], GOOD[1][:5]), "5 points at 5 different speeds; there must be at least 6 points"),
        ((np.tile(SPEEDS[:4], 3), np.tile(GOOD[1][:4], 3)), "12 points at 4 different speeds"),
        ((SPEEDS, np.zeros(30)), "torque is 0 N m higher in the direction of motion than against it; it must be"),
        ((BOTH, np.ones(60)), "torque is 0 N m higher in the direction of motion than against it; it must be"),
        ((BOTH, -torque_of(TRUE, BOTH)), "the torque of the drive has the sign of the velocity"),
    ],
)
def test_bad_points_are_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        fit_stribeck(*arguments)


def test_as_few_points_as_the_message_names_are_enough():
    for points in (SPEEDS[::5], np.tile(SPEEDS[::6], 2)):
        found = fit_stribeck(points, torque_of(TRUE, points)).estimates["coulomb"].value
        assert found == pytest.approx(60.0, rel=1e-6)


def test_mean_spread_and_count_are_those_of_each_drive():
    points = support_points([0.1, 0.3, 0.12, 0.32, 0.11], [5.0, 7.0, 6.0, 8.0, 7.0], ["a", "b", "a", "b", "a"])
    assert points.velocity == pytest.approx([0.11, 0.31])
    assert points.torque == pytest.approx([6.0, 7.5])
    assert points.spread == pytest.approx([1.0, np.sqrt(0.5)])
    assert points.count.tolist() == [3, 2]


def test_standard_errors_from_few_readings_scatter_less_than_their_spread():
    torque = torque_of(TRUE, BOTH)[:, np.newaxis] * (1.0 + 0.03 * np.random.default_rng(4).standard_normal((60, 5)))
    points = support_points(np.repeat(BOTH[:, np.newaxis], 5, axis=1), torque)
    true = 0.03 * np.abs(torque.mean(axis=1))
    own, shared = (np.std(np.log(error / true)) for error in (points.spread, points.standard_error))
    assert own > 0.25
    assert shared < 0.15
    assert np.median(points.standard_error * np.sqrt(5.0) / true) == pytest.approx(1.0, abs=0.15)


def shared(spread):
    """Standard deviations that points at rising speeds are taken to have, of three readings of a spread each."""
    velocity = np.repeat(np.geomspace(0.1, 1.0, spread.size)[:, np.newaxis], 3, axis=1)
    return math.sqrt(3.0) * support_points(velocity, 9.0 + np.outer(spread, [-1.0, 0.0, 1.0])).standard_error


def test_spreads_are_drawn_to_their_trend_as_empirical_bayes_of_smyth_does():
    spread = np.array([0.1, 0.4, 0.2, 1.5])
    level, variance = 2.0 * np.log(spread) + np.euler_gamma, shared(spread) ** 2
    slope, constant = np.polyfit(spread**2, variance, 1)
    half = 1.0 / slope - 1.0  # degrees of freedom of the prior, over two
    assert variance == pytest.approx(slope * spread**2 + constant)
    assert polygamma(1, half) == pytest.approx(np.var(level, ddof=1) - math.pi**2 / 6.0)
    assert constant / (1.0 - slope) == pytest.approx(math.exp(level.mean() + psi(half)) / half)
    trend = np.geomspace(0.2, 2.0, 5)  # from five points on a power of the speed
    assert shared(trend) == pytest.approx(trend * math.exp(0.5 * np.euler_gamma))
    assert shared(spread[:1]) == pytest.approx(spread[:1])
