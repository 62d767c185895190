"""What every recursive estimator promises, checked over all of them."""

import json
import math
import platform

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from adaptive_ff.estimation.exponential_resetting import ExponentialResetting
from adaptive_ff.estimation.instrumental_variable import InstrumentalVariable
from adaptive_ff.estimation.kalman_random_walk import KalmanRandomWalk
from adaptive_ff.estimation.least_squares import LeastSquares
from adaptive_ff.estimation.updates import single_update

TRUE = np.array([20.0, 60.0, 0.5])
PERIOD, NOISE = 0.001, 2.0
DEVIATION = np.array([30.0, 100.0, 2.0])
PRIOR = {"first_deviation": DEVIATION, "noise": NOISE}

MAKERS = {
    "least squares": lambda **more: LeastSquares(np.zeros(3), PERIOD, **{**PRIOR, **more}),
    "forgetting": lambda **more: LeastSquares(np.zeros(3), PERIOD, **{**PRIOR, "memory": 2.0, **more}),
    "resetting": lambda **more: ExponentialResetting(np.zeros(3), PERIOD, **{**PRIOR, "memory": 2.0, **more}),
    "instruments": lambda **more: InstrumentalVariable(np.zeros(3), PERIOD, **{**PRIOR, "memory": 2.0, **more}),
    "random walk": lambda **more: KalmanRandomWalk(np.zeros(3), PERIOD, **{**PRIOR, "walk": 0.01 * DEVIATION, **more}),
}

estimators = pytest.mark.parametrize("make", MAKERS.values(), ids=MAKERS)


def data(steps, seed, noise=NOISE):
    """Rows of unequal size, the instruments their clean part, and outputs."""
    rng = np.random.default_rng(seed)
    rows = rng.standard_normal((steps, 3)) * np.array([0.5, 1.0, 40.0])
    return rows, rows @ TRUE + noise * rng.standard_normal(steps)


def instruments_for(estimator, rows):
    return {"instruments": rows} if estimator.takes_instruments else {}


def feed(estimator, rows, outputs, **more):
    return estimator.run(rows, outputs, **instruments_for(estimator, rows), **more)


@estimators
def test_whole_series_is_a_loop_of_update_bit_for_bit(make):
    rows, outputs = data(400, seed=1)
    rows[17, 1], outputs[30] = math.nan, math.inf
    steps = PERIOD * np.random.default_rng(2).uniform(0.5, 2.0, 400)
    whole, single = make(), make()
    result = feed(whole, rows, outputs, dt=steps)
    for k, row in enumerate(rows):
        error = single.update(row, outputs[k], dt=steps[k], **instruments_for(single, row))
        assert error == result.errors[k] or (math.isnan(error) and math.isnan(result.errors[k]))
        assert np.array_equal(single.estimate, result.estimates[k])
    assert single.state_to_json() == whole.state_to_json()
    assert (single.taken, single.rejected) == (398, 2)


@estimators
def test_plain_python_equals_compiled_bit_for_bit(make):
    rows, outputs = data(100, seed=9)
    plain, fast = make(), make()
    feed(fast, rows, outputs)
    for row, output in zip(rows, outputs, strict=True):
        _, plain.state = single_update.py_func(plain.parameters, plain.state, row, row, float(output), PERIOD)
    found, expected = json.loads(fast.state_to_json()), json.loads(plain.state_to_json())
    if platform.machine() in ("x86_64", "AMD64"):
        assert found == expected
    assert fast.estimate == pytest.approx(plain.estimate, rel=1e-12)


@estimators
def test_it_finds_the_parameters_and_says_how_well(make):
    estimator = make()
    feed(estimator, *data(5000, seed=3))
    assert np.all(np.abs(estimator.estimate - TRUE) < 4.0 * estimator.standard_errors)
    assert np.all(estimator.standard_errors < 0.02 * DEVIATION)
    assert estimator.noise == pytest.approx(NOISE, rel=0.1)


@estimators
def test_intervals_hold_the_truth_as_often_as_they_say(make):
    """500 series of 600 equations, the error three times as large as was assumed where that is estimated."""
    inside, assumed = np.zeros(3), 1.0 if make is MAKERS["random walk"] else 1.0 / 3.0
    walk = {"walk": 0.0} if make is MAKERS["random walk"] else {}
    for seed in range(500):
        estimator = make(noise=assumed * NOISE, **walk)
        feed(estimator, *data(600, seed=1000 + seed))
        lower, upper = estimator.interval(0.9).T
        inside += (lower <= TRUE) & (upper >= TRUE)
    assert np.all(np.abs(inside / 500 - 0.9) < 0.045)


@estimators
def test_until_data_say_more_the_covariance_is_that_of_the_first_estimate(make):
    estimator = make()
    assert np.diag(estimator.covariance) == pytest.approx(DEVIATION**2)
    assert estimator.standard_errors == pytest.approx(DEVIATION)
    assert np.mean(estimator.interval(0.5), axis=1) == pytest.approx(np.zeros(3))


@estimators
def test_an_hour_at_1_khz_without_excitation_winds_nothing_up(make):
    """Excited, then at constant speed for an hour (one regressor, the same every time), then excited again."""
    estimator, rng = make(), np.random.default_rng(4)
    feed(estimator, *data(5000, seed=4))
    rows = np.tile([0.5, 1.0, 0.0], (60_000, 1))
    for _ in range(60):
        feed(estimator, rows, rows @ TRUE + NOISE * rng.standard_normal(60_000))
        found = estimator.covariance
        assert np.array_equal(found, found.T)
        assert np.linalg.eigvalsh(found / np.outer(DEVIATION, DEVIATION))[0] > 0.0
        assert np.all(estimator.standard_errors <= DEVIATION * 1.1)
        assert abs(rows[0] @ (estimator.estimate - TRUE)) < NOISE
    feed(estimator, *data(5000, seed=5))
    assert np.all(np.abs(estimator.estimate - TRUE) < 0.03 * DEVIATION)


@estimators
def test_a_long_run_stays_symmetric_and_positive_definite_with_nearly_collinear_regressors(make):
    rows, _ = data(300_000, seed=6)
    rows[:, 2] = 40.0 * rows[:, 0] + 1e-4 * rows[:, 2]
    estimator = make()
    for part in np.split(rows, 10):
        feed(estimator, part, part @ TRUE)
        found = estimator.covariance / np.outer(DEVIATION, DEVIATION)
        assert np.array_equal(found, found.T)
        assert np.linalg.eigvalsh(found)[0] > 0.0
    assert part[0] @ estimator.estimate == pytest.approx(part[0] @ TRUE, rel=0.01)


wild = st.floats(-1e6, 1e6) | st.sampled_from([0.0, math.nan, math.inf, -math.inf, 1e300, 1e-300])


@estimators
@settings(max_examples=60, deadline=None)
@given(arrays(float, st.tuples(st.integers(1, 12), st.just(4)), elements=wild))
@example(np.full((12, 4), 831459.0))  # one direction only, beside which a floor is lost to rounding
def test_wild_numbers_leave_it_finite_and_are_counted(make, table):
    estimator = make()
    feed(estimator, table[:, :3], table[:, 3])
    bad = ~np.all(np.abs(table) <= 1e100, axis=1)
    assert estimator.rejected == np.count_nonzero(bad)
    assert estimator.taken == table.shape[0] - estimator.rejected
    assert np.all(np.isfinite(estimator.estimate))
    assert np.all(np.isfinite(estimator.covariance))
    assert np.array_equal(estimator.covariance, estimator.covariance.T)


@estimators
def test_what_is_not_finite_changes_nothing_else(make):
    estimator = make()
    feed(estimator, *data(50, seed=7))
    before = json.loads(estimator.state_to_json())
    for row, output in (([math.nan, 0.0, 0.0], 1.0), ([1.0, 0.0, 0.0], math.nan), ([1.0, 0.0, 0.0], -math.inf)):
        assert math.isnan(estimator.update(row, output, **instruments_for(estimator, np.ones(3))))
    after = json.loads(estimator.state_to_json())
    assert after["state"]["tally"]["rejected"] == 3
    after["state"]["tally"]["rejected"] = 0
    assert after == before


@estimators
def test_saved_state_goes_on_bit_for_bit_and_reset_makes_it_new(make):
    rows, outputs = data(200, seed=8)
    first, second = make(), make()
    new = first.state_to_json()
    feed(first, rows[:100], outputs[:100])
    second.state_from_json(first.state_to_json())
    assert np.array_equal(feed(first, rows, outputs).estimates, feed(second, rows, outputs).estimates)
    first.reset()
    assert first.state_to_json() == new


@estimators
def test_what_is_handed_out_is_a_copy(make):
    estimator = make()
    estimator.estimate[:] = 5.0
    estimator.covariance[:] = 5.0
    assert estimator.state_to_json() == make().state_to_json()


def test_a_state_of_another_class_is_refused():
    text = MAKERS["least squares"]().state_to_json()
    with pytest.raises(ValueError, match="estimator = 'LeastSquares' is not"):
        MAKERS["resetting"]().state_from_json(text)
    with pytest.raises(ValueError, match="is no saved estimator state"):
        MAKERS["resetting"]().state_from_json("{}")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"noise": 0.0}, "noise = 0.0 is not allowed"),
        ({"memory": -1.0}, "memory = -1.0 is not allowed"),
        ({"memory": math.nan}, "memory = nan is not allowed"),
        ({"first_deviation": [1.0, 0.0, 1.0]}, r"first_deviation = \[1.0, 0.0, 1.0\] is not allowed"),
        ({"first_deviation": [1.0, 1.0]}, r"first_deviation has shape \(2,\); it must be one number, or \(3,\)"),
    ],
)
@pytest.mark.parametrize("name", ["least squares", "resetting", "instruments"])
def test_a_setting_out_of_range_is_refused_by_name(name, change, message):
    with pytest.raises(ValueError, match="^" + message):
        MAKERS[name](**change)


@pytest.mark.parametrize("first", [[], [[1.0]], [math.nan]])
def test_a_first_estimate_must_be_numbers(first):
    with pytest.raises(ValueError, match=r"^first "):
        LeastSquares(first, PERIOD, first_deviation=1.0, noise=1.0)


def test_a_walk_out_of_range_is_refused_by_name():
    with pytest.raises(
        ValueError, match=r"^walk = \[-1.0, -1.0, -1.0\] is not allowed: every one must be not negative"
    ):
        MAKERS["random walk"](walk=-1.0)
    with pytest.raises(ValueError, match=r"^largest_deviation = .* it must be at least first_deviation"):
        MAKERS["random walk"](largest_deviation=1.0)


@estimators
def test_arguments_of_a_wrong_shape_are_refused_by_name(make):
    estimator = make()
    more = instruments_for(estimator, np.ones(3))
    with pytest.raises(ValueError, match=r"^regressors has shape \(2,\); it must be \(3,\)"):
        estimator.update([1.0, 2.0], 1.0, **more)
    with pytest.raises(ValueError, match=r"^dt = 0.0 is not allowed"):
        estimator.update(np.ones(3), 1.0, dt=0.0, **more)
    with pytest.raises(ValueError, match=r"^dt is not allowed"):
        feed(estimator, np.ones((2, 3)), np.ones(2), dt=[0.1, -0.1])
    with pytest.raises(ValueError, match=r"^rows has shape \(2, 3\); it must be \(4, 3\)"):
        feed(estimator, np.ones((2, 3)), np.ones(4))
    with pytest.raises(ValueError, match=r"^confidence = 1.0 is not allowed"):
        estimator.interval(1.0)
    wrong = None if estimator.takes_instruments else np.ones(3)
    with pytest.raises(ValueError, match=r"^instruments are "):
        estimator.update(np.ones(3), 1.0, instruments=wrong)
