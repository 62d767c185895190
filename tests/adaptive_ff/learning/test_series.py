"""The series of the paper, and its recursive least squares."""

import math

import numpy as np
import pytest
from filterpy.kalman import FadingKalmanFilter
from hypothesis import given
from hypothesis import strategies as st

from adaptive_ff.friction.model import TorqueModel
from adaptive_ff.learning.rls import begin_anew_in_place, initial_rls_state, update_rls_in_place
from adaptive_ff.learning.series import series_coefficients, series_regressors, write_physical
from benchmarks.paper.misprints import coefficients_of, in_other_unit_of_time

JOINT = TorqueModel(20.0, 60.0, 90.0, 80.0, 0.02, 0.05, 1.0)
PERIOD = 0.01
FIELDS = dict.fromkeys(("coulomb", "stiction", "viscous"), st.floats(0.1, 200.0))
FIELDS |= {"inertia": st.floats(0.1, 100.0), "friction_lag": st.floats(1e-3, 0.2)}
FIELDS |= {"stribeck_velocity": st.floats(0.01, 1.0), "stribeck_shape": st.floats(0.5, 2.0)}
MODELS = st.builds(TorqueModel, **FIELDS)
PERIODS = st.floats(1e-3, 0.05)


@given(MODELS, PERIODS)
def test_misprint_of_a1_a_joint_without_friction_keeps_its_velocity_only_with_the_corrected_one(model, period):
    free = model._replace(coulomb=0.0, stiction=0.0, viscous=0.0)
    found = series_coefficients(free, period)
    assert found.a1 - found.a2 == pytest.approx(1.0, rel=1e-12)
    a1, a2, *_ = coefficients_of(free, period, "all as printed")
    assert a1 - a2 == pytest.approx(period / (period + free.friction_lag), rel=1e-9)
    assert a1 - a2 < 0.99


@given(MODELS, PERIODS, st.sampled_from([1e-3, 60.0]))
def test_misprints_of_b0_and_b1_their_ratio_depends_on_the_unit_of_time_only_as_printed(model, period, seconds):
    other = in_other_unit_of_time(model, seconds), period / seconds
    found, again = series_coefficients(model, period), series_coefficients(*other)
    assert again.b1 / again.b0 == pytest.approx(found.b1 / found.b0, rel=1e-12)
    assert found.b1 / found.b0 == pytest.approx(model.friction_lag / (model.friction_lag + period), rel=1e-12)
    (_, _, b0, b1, *_), (_, _, b0_again, b1_again, *_) = (
        coefficients_of(*one, "all as printed") for one in ((model, period), other)
    )
    assert b1 / b0 == pytest.approx(model.friction_lag / (1.0 + model.friction_lag), rel=1e-12)
    assert abs(math.log((b1 / b0) / (b1_again / b0_again))) > 0.5


@given(MODELS, PERIODS, st.sampled_from([1e-3, 60.0]))
def test_all_coefficients_scale_as_their_units_say(model, period, seconds):
    found = np.array(series_coefficients(model, period))
    again = np.array(series_coefficients(in_other_unit_of_time(model, seconds), period / seconds))
    velocity_per_torque = np.array([1.0, 1.0, seconds, seconds, seconds, seconds])
    assert again == pytest.approx(found * velocity_per_torque, rel=1e-11)


@given(MODELS, PERIODS)
def test_physical_parameters_come_back(model, period):
    row = np.full(5, math.nan)
    assert write_physical(np.array(series_coefficients(model, period)), period, row)
    names = ("inertia", "coulomb", "stiction", "viscous", "friction_lag")
    # sigma is a small difference of a1 and a2: rounding is amplified by J/(sigma Ts)
    amplified = {"viscous": 1e-14 * (1.0 + model.inertia * (model.friction_lag + period) / (model.viscous * period**2))}
    for name, value in zip(names, row, strict=True):
        assert value == pytest.approx(getattr(model, name), rel=max(1e-10, amplified.get(name, 0.0)))


def test_regressors_are_odd_and_without_friction_at_rest():
    torque, velocity = np.array([3.0, 5.0, 8.0]), np.array([0.02, -0.03, 0.0])

    def regressors(torque, velocity):
        row = np.empty(6)
        last = (velocity[1], velocity[0]), (torque[2], torque[1])
        series_regressors(row, *last, JOINT.stribeck_velocity, JOINT.stribeck_shape)
        return row

    row = regressors(torque, velocity)
    assert row == pytest.approx([-0.03, -0.02, 8.0, -5.0, 1.0 - math.exp(-0.6), math.exp(-0.6)], rel=1e-12)
    assert regressors(-torque, -velocity) == pytest.approx(-row, rel=1e-15)
    assert not np.any(regressors(torque, np.zeros(3))[[0, 1, 4, 5]])


IMPOSSIBLE = [{"b0": 1e-3, "b1": 1e-3}, {"b0": 0.0, "b1": 0.0}, {"b0": -1e-3}]
IMPOSSIBLE += [{"b0": math.nan}, {"a1": math.nan}, {"c1": math.inf}, {"d1": math.nan}]


@pytest.mark.parametrize("wrong", IMPOSSIBLE, ids=str)
def test_coefficients_that_no_joint_has_are_refused_and_the_row_is_left(wrong):
    coefficients = series_coefficients(JOINT, PERIOD)._replace(**wrong)
    row = np.arange(5.0)
    assert not write_physical(np.array(coefficients), PERIOD, row)
    assert row.tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]


SIZE = 6
TRUE = np.array([1.6, 0.7, 2e-2, 1e-2, -0.5, 0.3])


def exciting_data(steps, seed, noise=0.05):
    rng = np.random.default_rng(seed)
    rows = rng.standard_normal((steps, SIZE)) * np.array([1.0, 1.0, 5.0, 5.0, 1.0, 1.0])
    return rows, rows @ TRUE + noise * rng.standard_normal(steps)


def rows_near(found, expected, tolerance):
    """Whether each step's numbers are those of the oracle, by the norm of their difference."""
    found, expected = found.reshape(len(found), -1), expected.reshape(len(expected), -1)
    return np.linalg.norm(found - expected, axis=1) <= tolerance * np.linalg.norm(expected, axis=1)


@pytest.mark.parametrize(("forgetting_factor", "prior"), [(0.998, 1e4), (0.99, 100.0), (1.0, 1.0)])
def test_it_is_the_fading_memory_kalman_filter_of_filterpy(forgetting_factor, prior):
    """At each of 2000 steps: prediction error, estimate and covariance; compared at the end, which is quick."""
    steps = 2000
    rows, outputs = exciting_data(steps, seed=8)
    state = initial_rls_state(np.zeros(SIZE), prior * np.eye(SIZE))
    with pytest.warns(DeprecationWarning, match="KalmanFilter class"):
        kalman = FadingKalmanFilter(forgetting_factor**-0.5, dim_x=SIZE, dim_z=1)  # alpha^2 = 1/lambda
    kalman.P, kalman.F, kalman.Q = prior * np.eye(SIZE), np.eye(SIZE), np.zeros((SIZE, SIZE))
    kalman.R = np.eye(1)
    errors, estimates, covariances = np.empty((2, steps)), np.empty((2, steps, SIZE)), np.empty((2, steps, SIZE, SIZE))
    for k in range(steps):
        errors[0, k] = update_rls_in_place(state, rows[k], outputs[k], forgetting_factor)
        estimates[0, k], covariances[0, k] = state.estimate, state.covariance
        kalman.predict()  # the division by lambda comes before the update
        kalman.H = rows[k : k + 1]
        kalman.update(outputs[k])
        errors[1, k], estimates[1, k], covariances[1, k] = kalman.y[0, 0], kalman.x[:, 0], kalman.P
    assert np.all(np.abs(errors[0] - errors[1]) <= np.maximum(1e-6 * np.abs(errors[1]), 1e-9))
    assert np.all(rows_near(*estimates, 1e-9))
    assert np.all(rows_near(*covariances, 1e-9))


@pytest.mark.parametrize(("forgetting_factor", "prior"), [(0.995, 1e4), (0.9, 10.0), (1.0, 1.0)])
@pytest.mark.parametrize("steps", [3, 60, 1500])
def test_it_is_one_weighted_batch_solution_with_the_fading_prior(forgetting_factor, prior, steps):
    rows, outputs = exciting_data(steps, seed=9)
    start = np.array([1.0, 0.0, 0.1, 0.0, 0.0, 1.0])
    state = initial_rls_state(start, prior * np.eye(SIZE))
    for row, output in zip(rows, outputs, strict=True):
        update_rls_in_place(state, row, output, forgetting_factor)
    weights = forgetting_factor ** np.arange(steps - 1, -1, -1)
    fading = forgetting_factor**steps / prior * np.eye(SIZE)
    information = rows.T @ (weights[:, np.newaxis] * rows) + fading
    expected = np.linalg.solve(information, rows.T @ (weights * outputs) + fading @ start)
    assert rows_near(state.estimate[np.newaxis], expected[np.newaxis], 1e-8)
    assert rows_near(state.covariance[np.newaxis], np.linalg.inv(information)[np.newaxis], 1e-8)


def test_covariance_stays_exactly_symmetric_and_positive_definite():
    rows, outputs = exciting_data(3000, seed=10)
    rows[:, 1] = rows[:, 0] + 1e-3 * rows[:, 1]  # nearly collinear
    state = initial_rls_state(np.zeros(SIZE), 1e4 * np.eye(SIZE))
    for row, output in zip(rows, outputs, strict=True):
        update_rls_in_place(state, row, output, 0.99)
        assert np.array_equal(state.covariance, state.covariance.T)
    assert np.min(np.linalg.eigvalsh(state.covariance)) > 0.0


def test_one_update_is_that_of_11_to_13_by_hand():
    state = initial_rls_state(np.array([1.0, 2.0]), np.eye(2))
    error = update_rls_in_place(state, np.array([3.0, 1.0]), 7.0, 0.5)
    assert error == 2.0  # of the prediction before the update
    assert state.gain == pytest.approx([3.0 / 10.5, 1.0 / 10.5], rel=1e-14)
    assert state.estimate == pytest.approx([1.0 + 3.0 / 10.5 * 2.0, 2.0 + 1.0 / 10.5 * 2.0], rel=1e-14)
    assert state.covariance == pytest.approx(2.0 * np.array([[1.5, -3.0], [-3.0, 9.5]]) / 10.5, rel=1e-14)


@pytest.mark.parametrize("lost", ["estimate", "covariance"])
def test_it_begins_anew_where_a_number_is_lost_and_only_there(lost):
    state = initial_rls_state(np.array([1.0, 2.0]), 3.0 * np.eye(2))
    update_rls_in_place(state, np.array([3.0, 1.0]), 7.0, 0.5)
    assert not begin_anew_in_place(state, 5.0)
    getattr(state, lost).flat[-1] = np.nan
    assert begin_anew_in_place(state, 5.0)
    assert [part.tolist() for part in state] == [[0.0, 0.0], [[5.0, 0.0], [0.0, 5.0]], [0.0, 0.0]]
