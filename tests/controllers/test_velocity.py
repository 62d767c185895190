import math

import numpy as np
import pytest
from velocity_runs import ESTIMATORS, ON_POSITIONS, PERIOD, RESOLUTION, estimate, run_compiled

from controllers import VELOCITY_ESTIMATORS, difference_velocity, low_pass_lag, low_pass_velocity

every = pytest.mark.parametrize("block", ESTIMATORS.values(), ids=ESTIMATORS)
on_positions = pytest.mark.parametrize("block", ON_POSITIONS.values(), ids=ON_POSITIONS)


def encoder(position):
    return RESOLUTION * np.round(np.asarray(position) / RESOLUTION)


def test_every_estimator_is_tested():
    assert {type(block) for block in ESTIMATORS.values()} == set(VELOCITY_ESTIMATORS)


@every
def test_compiled_run_is_plain_python_bit_for_bit(block):
    generator = np.random.default_rng(1)
    dt = PERIOD * generator.uniform(0.5, 1.5, 3000)
    measured = encoder(0.3 * np.sin(4.0 * np.cumsum(dt)))
    measured[generator.integers(1, 3000, 100)] = math.nan
    found, state = estimate(block, measured, dt=dt, velocity=1.2)
    again, same_state = estimate(block, measured, dt=dt, velocity=1.2, run=run_compiled)
    assert np.array_equal(found, again, equal_nan=True)
    assert state == same_state
    assert np.count_nonzero(np.isfinite(found)) > 2850


@on_positions
@pytest.mark.parametrize("velocity", [0.0, 0.35, -2.0])
def test_constant_velocity_is_exact_from_the_first_sample_whatever_the_periods(block, velocity):
    dt = PERIOD * np.random.default_rng(2).uniform(0.5, 1.5, 500)
    dt[0] = PERIOD
    position = 0.7 + velocity * (np.cumsum(dt) - dt[0])
    found, _ = estimate(block, position, dt=dt, velocity=velocity)
    assert found == pytest.approx(np.full(500, velocity), abs=1e-10)


@on_positions
@pytest.mark.parametrize("lost", [math.nan, math.inf, -math.inf], ids=str)
def test_lost_positions_are_passed_on_and_spoil_nothing(block, lost):
    position = 0.35 * PERIOD * np.arange(400)
    gaps = [3, 50, 51, 52, 53, 200]
    measured = position.copy()
    measured[gaps] = lost
    found, _ = estimate(block, measured, velocity=0.35)
    assert np.all(np.isnan(found[gaps]))
    assert np.delete(found, gaps) == pytest.approx(np.full(400 - len(gaps), 0.35), abs=1e-10)


@pytest.mark.parametrize("jitter", [0.0, 0.6])
def test_low_pass_answers_a_step_with_one_exponential_in_real_time(jitter):
    dt = PERIOD * (1.0 + jitter * np.random.default_rng(3).uniform(-1.0, 1.0, 200))
    position = np.concatenate([[0.0], 0.5 * np.cumsum(dt[1:])])
    found, _ = estimate(low_pass_velocity(40.0, PERIOD), position, dt=dt)
    time = np.concatenate([[0.0], np.cumsum(dt[1:])])
    assert found == pytest.approx(0.5 * -np.expm1(-2.0 * math.pi * 40.0 * time), abs=1e-12)


@pytest.mark.parametrize("period", [0.01, 0.002, 0.0005])
def test_lag_is_that_behind_a_joint_that_accelerates_evenly(period):
    time = period * np.arange(4000)
    found, _ = estimate(low_pass_velocity(50.0, period), 0.5 * 3.0 * time**2, dt=np.full(time.size, period))
    assert time[-1] - found[-1] / 3.0 == pytest.approx(low_pass_lag(50.0, period), rel=1e-7)


def quantisation_noise(block, samples=200_000):
    """Noise that the encoder adds: estimate from quantised minus estimate from exact positions."""
    time = PERIOD * np.arange(samples)
    position = 3.0 * time + 0.2 * np.sin(1.3 * time)  # many steps a period
    rounded, _ = estimate(block, encoder(position), velocity=3.26, run=run_compiled)
    exact, _ = estimate(block, position, velocity=3.26, run=run_compiled)
    return (rounded - exact)[1000:]


def test_noise_of_a_difference_is_the_resolution_over_the_period_and_the_root_of_six():
    noise = quantisation_noise(difference_velocity(PERIOD))
    assert np.std(noise) == pytest.approx(RESOLUTION / (PERIOD * math.sqrt(6.0)), rel=0.03)


def test_low_pass_leaves_the_noise_that_its_pole_predicts():
    """White rounding errors through ``(1 - a)(1 - 1/z)/(1 - a/z)``: ``2 (1 - a)^2/(1 + a)`` of the variance of one."""
    noise = quantisation_noise(low_pass_velocity(40.0, PERIOD))
    kept = math.exp(-2.0 * math.pi * 40.0 * PERIOD)
    variance = RESOLUTION**2 / 12.0 / PERIOD**2 * 2.0 * (1.0 - kept) ** 2 / (1.0 + kept)
    assert np.std(noise) == pytest.approx(math.sqrt(variance), rel=0.03)
