"""Sections V-B to V-E of the paper in simulation; seeds from 101 on, which are not among those reported."""

import numpy as np
import pytest
from closed_loops import run_compiled

from adaptive_ff.learning.series import series_coefficients
from adaptive_ff.simulation.experiment import empty_record
from adaptive_ff.simulation.loop import start_position
from adaptive_ff.simulation.metrics import rms
from benchmarks.paper import closed_loop, records, stribeck
from benchmarks.paper.estimators import fit_series, is_possible, physical_series
from benchmarks.paper.experiment import in_words, median_and_range
from benchmarks.paper.figures import figure_07, figure_08, figure_09, figure_10, figure_11, figure_12
from controllers import PI

RESOLUTION = records.TORQUE_CONSTANT * records.CURRENT_STEP


@pytest.fixture(scope="module")
def seen():
    return closed_loop.watch(101)


@pytest.fixture(scope="module")
def fits():
    return [stribeck.fit_stribeck(*stribeck.draw_points(seed)) for seed in range(1001, 1011)]


def test_sampling_time_has_a_mean_of_22_ms_and_a_periodic_pattern_of_outliers_up_to_twice_that():
    durations = np.diff(records.sample_steps(100.0))
    assert np.mean(durations) == pytest.approx(22.0, abs=0.1)
    assert 1.8 < np.max(durations) / np.mean(durations) < 2.0
    outliers = durations > 25
    assert 0.03 < np.mean(outliers) < 0.15
    assert np.unique(durations[outliers]).size > 1
    assert np.array_equal(durations[:-40], durations[40:])
    assert not np.array_equal(durations[:-20], durations[20:])
    assert set(np.diff(records.sample_steps(10.0, uniform=True))) == {22}


def test_torque_has_steps_and_acts_over_the_period_that_follows_its_sample():
    record = records.drive(records.build_robot_setup(102, duration=20.0))
    steps = record.commanded / RESOLUTION
    assert steps == pytest.approx(np.round(steps), abs=1e-9)
    assert np.unique(np.round(steps)).size > 40
    assert np.array_equal(record.acting[1:], record.commanded[:-1])
    assert record.acting[0] == 0.0


def test_loop_is_the_one_of_the_package_where_the_current_is_fine():
    setup = records.build_robot_setup(103, duration=20.0)
    record = records.drive(setup, current_step=1e-12)
    own, block = empty_record(setup, 0), PI(*records.GAINS, records.ROBOT_PERIOD)
    start = start_position(setup)
    run_compiled(block.parameters, block.state, setup, start, setup.noise.size, own)
    assert record.commanded == pytest.approx(own.torque, abs=1e-6)
    assert record.velocity == pytest.approx(own.measured, abs=1e-8)
    assert record.true == pytest.approx(own.velocity, abs=1e-8)


def test_the_true_joint_predicts_the_record_down_to_the_noise():
    quiet = records.drive(records.build_robot_setup(104, duration=20.0, noise=0.0))
    assert np.array_equal(records.predict(records.TRUE, quiet, one_step=False), quiet.velocity)
    noisy = records.drive(records.build_robot_setup(104, duration=60.0))
    free = noisy.velocity - records.predict(records.TRUE, noisy, one_step=False)
    assert rms(free) == pytest.approx(records.NOISE, rel=0.05)
    one_step = noisy.velocity - records.predict(records.TRUE, noisy, one_step=True)
    assert rms(one_step) > 1.2 * records.NOISE  # that of two samples


def test_the_posterior_error_is_the_smaller_and_with_lambda_one_rls_comes_to_the_offline_fit(seen):
    prior, posterior = seen.series.errors["prior"], seen.series.errors["posterior"]
    assert np.all(np.abs(posterior) <= np.abs(prior) + 1e-12)
    assert np.any(prior)
    series = fit_series(seen.record, 1.0, closed_loop.COVARIANCE)
    assert series.coefficients[-1] == pytest.approx(seen.series.offline.values, rel=2e-2)
    late = seen.record.time > 60.0
    assert rms(series.errors["prior"][late]) == pytest.approx(rms(series.errors["offline"][late]), rel=0.05)


@pytest.mark.parametrize("seed", [101, 106, 107])
def test_the_prior_error_is_larger_and_the_posterior_smaller_than_that_of_the_offline_fit(seed):
    one = closed_loop.watch(seed)
    found = closed_loop.ratios(one)
    assert found[closed_loop.PRIOR] > 2.0
    assert found[closed_loop.POSTERIOR] < 0.5
    assert closed_loop.settled_rms(one.record, one.series.errors["posterior"]) < 1e3 * records.NOISE
    long_memory = closed_loop.ratios(one._replace(series=fit_series(one.record, 0.99, closed_loop.COVARIANCE)))
    assert long_memory[closed_loop.PRIOR] == pytest.approx(1.0, abs=0.1)


def test_the_offline_fit_is_spoilt_near_rest_and_not_by_the_sampling(seen):
    fits = seen.series.offline, seen.series.sliding
    deviations = [closed_loop.physical_of(fit.values) / records.TRUTH_VALUES - 1.0 for fit in fits]
    assert deviations[0][0] > 5.0
    assert np.abs(deviations[1]) == pytest.approx(np.zeros(5), abs=1.5)
    assert np.all(np.abs(deviations[1][:4]) < 0.12)
    record = records.drive(records.build_robot_setup(101, uniform=True))
    even = fit_series(record, records.FORGETTING, closed_loop.COVARIANCE)
    assert closed_loop.physical_of(even.offline.values)[0] > 5.0 * records.TRUE.inertia


def test_coefficients_with_a_short_memory_stand_for_no_joint(seen):
    late = seen.record.time > 5.0
    possible = is_possible(physical_series(seen.series.coefficients[late], records.ROBOT_PERIOD))
    assert 0.01 < np.mean(possible) < 0.3
    true = np.array(series_coefficients(records.TRUE, records.ROBOT_PERIOD))
    assert np.all(is_possible(physical_series(true[np.newaxis], records.ROBOT_PERIOD)))
    assert closed_loop.physical_of(true) == pytest.approx(records.TRUTH_VALUES)
    impossible = [[np.nan] * 5, [20.0, 60.0, 90.0, -1.0, 0.02], [-20.0, 60.0, 90.0, 1.0, 0.02]]
    assert not is_possible(np.array(impossible)).any()


def test_the_torque_form_identifies_from_the_same_data_and_helps_where_the_paper_does_harm(seen):
    assert np.all(np.abs(seen.form.estimates[-1][:4] / records.TRUTH_VALUES[:4] - 1.0) < 0.1)
    offline = closed_loop.settled_rms(seen.record, seen.series.errors["offline"])
    assert closed_loop.settled_rms(seen.record, seen.form.errors["online"]) < 0.8 * offline
    found = closed_loop.tracking_errors(seen, 101)
    assert found[closed_loop.FORM] < 0.4 * found[closed_loop.ALONE]
    assert found[closed_loop.ORACLE] < 0.4 * found[closed_loop.ALONE]
    assert found[closed_loop.OFFLINE] > 1.5 * found[closed_loop.ALONE]
    assert found[closed_loop.ONLINE] > 2.5 * found[closed_loop.ALONE]


def test_rows_about_the_data_tell_what_the_record_is_in_words(seen):
    assert median_and_range([3.0, 1.0, 10.0]) == "3.00 (1.00 to 10.00)"
    assert median_and_range([0.26, 0.34], 1) == "0.3 (0.3 to 0.3)"
    assert in_words(1.1 * records.TRUTH_VALUES) == "J +10.0, Fc +10.0, Fs +10.0, sigma +10.0, tau +10.0"
    rows = closed_loop.data_rows(seen.record)
    assert [row.met for row in rows[:2]] == [True, True]
    values = {row.quantity: row.value for row in rows}
    assert values["V-B: largest speed of the reference, deg/s"] == pytest.approx(20.05, abs=0.5)
    assert values["Fig. 7: resolution of the torque K i, N m"] == pytest.approx(RESOLUTION)
    assert not closed_loop.data_rows(records.drive(records.build_robot_setup(101, duration=20.0, uniform=True)))[1].met


def drawn(figure, panel):
    return {str(line.get_label()): np.asarray(line.get_ydata()) for line in figure.axes[panel].lines}


def test_figures_show_the_record_and_the_errors(seen, fits):
    record, series, form = seen
    part = (record.time >= 60.0) & (record.time <= 75.0)
    late = drawn(figure_11(*seen), 1)
    assert late["measured"] == pytest.approx(record.velocity[part])
    assert late["RLS, a-posteriori"] == pytest.approx((record.velocity - series.errors["posterior"])[part])
    ahead = drawn(figure_09(*seen), 1)
    assert ahead["torque form, simulated"] == pytest.approx(1e3 * form.errors["online"][part])
    (whole,) = (lines for lines in drawn(figure_07(record), 1).values() if lines.size == record.time.size)
    assert whole == pytest.approx(record.commanded)
    shown = np.concatenate(list(drawn(figure_10(record), 0).values()))
    assert {21.0, 31.0, 42.0} <= set(np.round(shown, 6))
    inertia = drawn(figure_12(*seen), 1)
    assert inertia["torque form, online"] == pytest.approx(form.estimates[record.time <= 60.0][:, 0])
    points = stribeck.simulate_drives(stribeck.VELOCITIES[::6], 1001)
    fit = stribeck.fit_stribeck(points.velocity, points.torque, points.standard_error)
    cloud = np.concatenate(list(drawn(figure_08(points, fit, fits), 3).values()))
    assert set(np.round([one.stribeck_shape for one in fits], 9)) <= set(np.round(cloud, 9))


def test_drives_at_constant_speed_give_points_of_the_true_curve():
    points = stribeck.simulate_drives(stribeck.VELOCITIES[::5], 1002)
    assert points.velocity == pytest.approx(stribeck.VELOCITIES[::5], abs=2e-3)
    wrong = (points.torque - stribeck.true_friction(points.velocity)) / points.standard_error
    assert np.max(np.abs(wrong)) < 4.0
    relative = points.spread / np.abs(points.torque)
    assert np.all((relative > 0.02) & (relative < 0.07))


def test_the_study_draws_what_it_says(fits):
    velocity, torque, error = stribeck.draw_points(1003)
    assert velocity.size == 60
    assert np.median(error / np.abs(torque)) == pytest.approx(0.003, rel=0.1)
    assert (torque - stribeck.true_friction(velocity)) / error == pytest.approx(np.zeros(60), abs=4.5)
    _, shared, _ = stribeck.draw_points(1003, common=0.03)
    assert rms(shared / stribeck.true_friction(velocity) - 1.0) == pytest.approx(0.03, rel=0.3)
    rows = {row.quantity: row for row in stribeck.study_rows("these", fits, targets=True)}
    errors = [abs(fit.stribeck_velocity / 0.05 - 1.0) for fit in fits]
    assert rows["these: median error of Vs, %"].value == pytest.approx(100.0 * np.median(errors))
    assert rows["these: median error of Vs, %"].met
    shapes = [fit.estimates["stribeck_shape"] for fit in fits]
    held = np.mean([shape.lower <= 1.0 <= shape.upper for shape in shapes])
    assert rows["these: 95 % intervals that hold delta, %"].value == pytest.approx(100.0 * held)
