import math

import numpy as np
import pytest
from scipy import stats

from adaptive_ff.friction.model import ESTIMATED, TorqueModel
from adaptive_ff.learning.batch import _physical_slopes, identify_series, identify_torque_form, slides_one_way
from adaptive_ff.learning.batch_least_squares import fit_least_squares
from adaptive_ff.learning.series import COEFFICIENTS, series_coefficients, write_physical
from plant import JointParameters, JointState, Stribeck, step_joint

JOINT = TorqueModel(20.0, 60.0, 90.0, 80.0, 0.02, 0.05, 1.0)
TRUE = np.array(JOINT[:5])
GIVEN = {"stribeck_velocity": 0.05, "stribeck_shape": 1.0}
PERIOD = 0.01


def regression(rows, noise, seed=3):
    rng = np.random.default_rng(seed)
    matrix = rng.standard_normal((rows, 3)) * [1.0, 20.0, 0.3]
    return matrix, matrix @ [2.0, -0.1, 5.0] + noise * rng.standard_normal(rows)


@pytest.mark.parametrize("confidence", [0.95, 0.6])
def test_slope_its_standard_error_and_interval_are_those_of_linregress_of_scipy(confidence):
    rng = np.random.default_rng(1)
    x = rng.uniform(-2.0, 5.0, 40)
    y = 3.0 * x - 1.0 + rng.standard_normal(40)
    fit = fit_least_squares(np.column_stack([x, np.ones(40)]), y, names=("slope", "offset"), confidence=confidence)
    oracle = stats.linregress(x, y)
    assert fit.values == pytest.approx([oracle.slope, oracle.intercept], rel=1e-12)
    assert fit.standard_errors == pytest.approx([oracle.stderr, oracle.intercept_stderr], rel=1e-12)
    slope = fit.estimate("slope")
    with pytest.raises(ValueError, match=r"name = 'bend' is not known; allowed: .*slope"):
        fit.estimate("bend")
    half = stats.t(38).ppf(0.5 + 0.5 * confidence) * oracle.stderr
    assert (slope.lower, slope.upper) == pytest.approx((oracle.slope - half, oracle.slope + half), rel=1e-12)


def test_nearly_collinear_columns_are_solved_where_the_normal_equations_fail():
    rng = np.random.default_rng(2)
    base = rng.standard_normal((500, 3)) * [1.0, 1.0, 1e6]
    matrix = np.column_stack([base[:, 0], base[:, 0] + 1e-9 * base[:, 1], base[:, 2]])
    wanted = np.array([1.0, 2.0, 3e-6])
    outputs = matrix @ wanted
    fit = fit_least_squares(matrix, outputs)
    assert fit.values == pytest.approx(wanted, rel=1e-5)
    assert np.linalg.cond(matrix / np.linalg.norm(matrix, axis=0)) ** 2 > 1.0 / np.finfo(float).eps


def test_condition_numbers_tell_units_from_collinearity():
    matrix = np.eye(4)[:, :2] * [1.0, 1000.0]
    fit = fit_least_squares(matrix, np.ones(4))
    assert fit.condition_number == pytest.approx(1.0, rel=1e-12)
    angle = 0.1
    oblique = np.array([[1.0, math.cos(angle)], [0.0, math.sin(angle)], [0.0, 0.0]])
    assert fit_least_squares(oblique, np.ones(3)).condition_number == pytest.approx(1.0 / math.tan(angle / 2.0))


def test_covariance_with_correlated_errors_is_that_of_newey_and_west():
    matrix, outputs = regression(40, 1.0)
    fit = fit_least_squares(matrix, outputs, correlated_samples=3)
    distance = np.abs(np.subtract.outer(np.arange(40), np.arange(40)))
    weights = np.maximum(1.0 - distance / 4.0, 0.0)
    inverse = np.linalg.inv(matrix.T @ matrix)
    middle = matrix.T @ (weights * np.outer(fit.residuals, fit.residuals)) @ matrix
    assert fit.covariance == pytest.approx(inverse @ middle @ inverse * 40 / 37, rel=1e-9)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"regressors": np.ones((5, 0))}, r"regressors have shape \(5, 0\)"),
        ({"outputs": np.ones(4)}, r"outputs have shape \(4,\); it must be \(60,\)"),
        ({"regressors": np.full((60, 3), math.nan)}, r"regressors\[0, 0\] = nan .* finite"),
        ({"outputs": np.append(np.ones(59), math.inf)}, r"outputs\[59\] = inf .* finite"),
        ({"regressors": np.eye(3), "outputs": np.ones(3)}, "have 3 rows; there must be more than the 3"),
        ({"regressors": np.eye(60)[:, :3] * [1.0, 0.0, 1.0]}, "regressor of p1 is zero"),
        ({"regressors": np.tile([[1.0, 2.0, 3.0]], (60, 1))}, "rank 1; it must be 3"),
        ({"regressors": np.vander(np.arange(60) % 2 + 1, 3)[:, [2, 2, 0]]}, "rank 2; .*: p[01] cannot be told from"),
        ({"regressors": np.vander(np.arange(60) % 2 + 1, 3)[:, [0, 2, 2]]}, "rank 2; .*: p[12] cannot be told from"),
        ({"names": ("a", "b")}, "has 2 entries; there must be one for each of 3"),
        ({"correlated_samples": 60}, "correlated_samples = 60 .* less than the 60 rows"),
        ({"correlated_samples": -1}, "correlated_samples = -1 .* at least 0"),
    ],
    ids=str,
)
def test_bad_data_are_refused_by_name_value_and_rule(change, message):
    matrix, outputs = regression(60, 0.1)
    with pytest.raises(ValueError, match=message):
        fit_least_squares(**{"regressors": matrix, "outputs": outputs, **change})


def recursion(seed, count=3000, noise=0.0, runs=1):
    """Torques and velocities by (4), written out once more; independent runs side by side."""
    rng = np.random.default_rng(seed)
    torque = 150.0 * rng.standard_normal((count, runs))
    a1, a2, b0, b1, c1, d1 = series_coefficients(JOINT, PERIOD)
    velocity = np.zeros((count, runs))
    for k in range(2, count):
        last = velocity[k - 1]
        share = np.exp(-np.abs(last) / JOINT.stribeck_velocity)
        friction = np.sign(last) * (c1 * (1.0 - share) + d1 * share)
        velocity[k] = a1 * last - a2 * velocity[k - 2] + b0 * torque[k] - b1 * torque[k - 1] - friction
        velocity[k] += noise * rng.standard_normal(runs)
    return torque, velocity


def test_the_series_is_the_equation_of_motion_with_backward_differences():
    torque, velocity = (series[:, 0] for series in recursion(5))
    w, before, earlier = velocity[2:], velocity[1:-1], velocity[:-2]
    second = (w - 2.0 * before + earlier) / PERIOD**2
    slide = np.exp(-np.abs(before) / JOINT.stribeck_velocity)
    friction = np.sign(before) * (JOINT.coulomb * (1.0 - slide) + JOINT.stiction * slide) + JOINT.viscous * w
    inertial = JOINT.inertia * (JOINT.friction_lag * second + (w - before) / PERIOD)
    applied = torque[2:] + JOINT.friction_lag * np.diff(torque)[1:] / PERIOD
    assert inertial + friction == pytest.approx(applied, abs=1e-8 * np.max(np.abs(applied)))  # (2)


def test_series_returns_the_joint_behind_the_recursion():
    torque, velocity = recursion(5)
    found = identify_series(velocity[:, 0], torque[:, 0], PERIOD, **GIVEN)
    assert found.model == pytest.approx(JOINT, rel=1e-6)
    assert [found.physical[name].value for name in ESTIMATED] == pytest.approx(TRUE, rel=1e-6)
    assert found.regression.names == COEFFICIENTS
    assert found.regression.values == pytest.approx(np.array(series_coefficients(JOINT, PERIOD)), rel=1e-8)
    assert found.used.tolist() == [False, False, *[True] * 2998]


def test_standard_errors_of_the_physical_parameters_are_their_scatter():
    torque, velocity = recursion(6, count=1500, noise=1e-3, runs=200)
    found = [identify_series(velocity[:, run], torque[:, run], PERIOD, **GIVEN) for run in range(200)]
    for name in ESTIMATED:
        scatter = np.std([each.physical[name].value for each in found])
        claimed = np.mean([each.physical[name].standard_error for each in found])
        assert claimed == pytest.approx(scatter, rel=0.2)


def test_slopes_of_the_physical_parameters_are_those_of_their_differences():
    coefficients, found = np.array(series_coefficients(JOINT, PERIOD)), np.empty((2, 5))
    slopes = _physical_slopes(coefficients, PERIOD)
    for place, step in enumerate(1e-6 * coefficients):
        for row, sign in zip(found, (1.0, -1.0), strict=True):
            assert write_physical(coefficients + sign * step * (np.arange(6) == place), PERIOD, row)
        assert slopes[:, place] == pytest.approx((found[0] - found[1]) / (2.0 * step), rel=1e-6, abs=1e-6)


def test_three_samples_above_the_slowest_speed_and_of_one_sign_slide_one_way():
    velocity = np.array([0.2, 0.1, 0.3, 0.05, 0.1, 0.1, 0.1, -0.1, -0.2, -0.1, 0.0, 0.1, -0.1, 0.1, 0.1, 0.2, -0.3])
    wanted = [k > 1 and (min(s := velocity[k - 2 : k + 1]) >= 0.1 or max(s) <= -0.1) for k in range(velocity.size)]
    assert slides_one_way(velocity, 0.1).tolist() == wanted
    assert np.flatnonzero(wanted).tolist() == [2, 6, 9, 15]
    assert not slides_one_way(np.zeros(5), 0.0).any()


@pytest.fixture(scope="module")
def jittered_log():
    """A joint that reverses under held torques, sampled at uneven times, on a fine solver."""
    rng = np.random.default_rng(7)
    steps = rng.integers(6, 15, 1500)  # of 1 ms
    time = np.concatenate([[0.0], 1e-3 * np.cumsum(steps)])
    torque = 130.0 * np.sin(2.0 * np.pi * 0.7 * time) + 90.0 * np.sin(2.0 * np.pi * 1.9 * time + 1.0)
    friction = Stribeck(60.0, 90.0, 80.0, 0.05, 1.0)
    joint = JointParameters(20.0, friction, friction, 0.0, 0.02)
    state, velocity = JointState(0.0, 0.0, 0.0), [0.0]
    for held, count in zip(torque[1:], steps, strict=True):
        for _ in range(4 * count):
            state = step_joint(joint, state, held, 2.5e-4)
        velocity.append(state.velocity)
    return time, np.array(velocity), torque


GATE = {"filter_pole": 60.0, "slowest": 0.01, "hold": 0.05}


def test_torque_form_returns_the_joint_from_jittered_samples(jittered_log):
    time, velocity, torque = jittered_log
    assert np.count_nonzero(np.diff(np.sign(velocity))) > 20
    found = identify_torque_form(time, velocity, torque, **GIVEN, **GATE)
    assert [found.physical[name].value for name in ESTIMATED[:4]] == pytest.approx(TRUE[:4], rel=0.02)
    assert found.model.friction_lag == pytest.approx(0.02, rel=0.1)
    assert found.regression.estimate("inertia_lag").value == pytest.approx(0.4, rel=0.1)
    assert found.model[5:7] == (0.05, 1.0)
    assert not any(found.model[7:])


def test_standard_errors_of_the_torque_form_are_its_scatter_under_noise_of_the_torque(jittered_log):
    time, velocity, torque = jittered_log
    rng = np.random.default_rng(8)
    noisy = (torque + 20.0 * rng.standard_normal(time.size) for _ in range(60))
    found = [identify_torque_form(time, velocity, each, **GIVEN, **GATE) for each in noisy]
    for name in ("inertia", "coulomb", "viscous"):
        scatter = np.std([each.physical[name].value for each in found])
        claimed = np.mean([each.physical[name].standard_error for each in found])
        assert claimed == pytest.approx(scatter, rel=0.4)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"time": np.zeros(1501)}, r"time\[1\] = 0.0 s .* later than the one before"),
        ({"time": np.append(np.arange(1500.0), 7.0)}, r"time\[1500\] = 7.0 s .* later than the one before"),
        ({"torque": np.ones((1501, 1))}, r"torque has shape \(1501, 1\); it must be a series of three samples"),
        ({"time": [0.0, 1.0]}, r"time has shape \(2,\); it must be a series of three samples at least"),
        ({"velocity": np.ones(1500)}, "velocity has 1500 samples; it must have 1501, as time"),
        ({"hold": -1.0}, "hold = -1.0 .* zero or more"),
        ({"slowest": math.nan}, "slowest = nan .* zero or more"),
        ({"slowest": 50.0}, "slowest = 50 rad/s .* let 0 samples through; there must be more than"),
    ],
    ids=str,
)
def test_torque_form_refuses_bad_input_by_name_value_and_rule(jittered_log, change, message):
    given = dict(zip(("time", "velocity", "torque"), jittered_log, strict=True))
    with pytest.raises(ValueError, match=message):
        identify_torque_form(**{**given, **GIVEN, **GATE, **change})


@pytest.mark.parametrize(
    ("use", "message"),
    [
        (np.ones(9), r"use has shape \(9,\) and type float64; it must be \(3000,\) and bool"),
        (np.zeros(3000, dtype=bool), "have 0 rows; there must be more than the 6"),
    ],
)
def test_series_refuses_other_samples_than_it_has(use, message):
    torque, velocity = recursion(5)
    with pytest.raises(ValueError, match=message):
        identify_series(velocity[:, 0], torque[:, 0], PERIOD, use=use, **GIVEN)
