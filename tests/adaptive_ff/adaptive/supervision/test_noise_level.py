"""The noise of the measured velocity, as the error alone shows it."""

import numpy as np
import pytest

from adaptive_ff.adaptive.supervision.noise_level import (
    RISE,
    SETTLING,
    WINDOW,
    advance_noise,
    hunts,
    initial_noise,
    noise_known,
    usual_deviation,
)

NOISE = 0.002


def course(errors, period, state=None, counts=True):
    """States after each of a series of errors."""
    state, states = initial_noise() if state is None else state, []
    for error in errors:
        state = advance_noise(state, float(error), counts, period)
        states.append(state)
    return states


def white(seconds, period, seed, noise=NOISE):
    return noise * np.random.default_rng(seed).standard_normal(round(seconds / period))


def level(states, period, seconds=5.0):
    """Mean of the standard deviation that is found from some seconds on."""
    return float(np.mean([np.sqrt(state.variance) for state in states[round(seconds / period) :]]))


def within_ten_percent(period, seed):
    return level(course(white(25.0, period, seed), period), period) == pytest.approx(NOISE, rel=0.1)


@pytest.mark.parametrize("seed", [101, 102, 103])
def test_at_1_khz_white_noise_is_found_within_ten_percent(seed):
    assert within_ten_percent(0.001, seed)


@pytest.mark.xfail(strict=True, reason="the minimum of means over 30 samples is some 23 % below the noise")
@pytest.mark.parametrize("seed", [101, 102, 103])
def test_at_100_hz_white_noise_is_found_within_ten_percent(seed):
    assert within_ten_percent(0.01, seed)


def test_the_level_is_in_proportion_to_the_noise():
    small, large = (course(white(5.0, 0.01, 104, noise), 0.01)[-1].variance for noise in (NOISE, 3.0 * NOISE))
    assert large == pytest.approx(9.0 * small, rel=1e-9)


def test_a_ramp_and_a_constant_leave_it_as_it_is():
    errors = white(5.0, 0.001, 105)
    ramp = 0.3 + 2.0 * 0.001 * np.arange(errors.size)
    found, expected = (course(series, 0.001)[-1].variance for series in (errors + ramp, errors))
    # the first two samples see the ramp begin; they have faded but for exp(-5 s / 0.3 s)
    assert found == pytest.approx(expected, rel=1e-2)
    assert course(ramp, 0.001, course(errors, 0.001)[-1])[-1].variance < expected


def test_a_joint_at_rest_shows_no_noise():
    moved = course(white(5.0, 0.01, 106), 0.01)[-1]
    rested = course(white(60.0, 0.01, 107, noise=0.1), 0.01, moved, counts=False)[-1]
    assert (rested.variance, rested.mean, rested.measured) == (moved.variance, moved.mean, moved.measured)


def test_it_is_known_after_three_windows_of_motion_and_not_before():
    states = course(white(2.0, 0.01, 108), 0.01)
    known = [noise_known(state) for state in states]
    assert sum(known) == pytest.approx(len(known) - SETTLING * WINDOW / 0.01, abs=1.0)
    assert known == sorted(known)
    assert [state.variance > 0.0 for state in states] == known


def test_noise_that_grows_is_followed_no_faster_than_the_minimum_rises():
    quiet = course(white(5.0, 0.01, 109), 0.01)[-1]
    louder = np.array([state.variance for state in course(white(10.0, 0.01, 110, 10.0 * NOISE), 0.01, quiet)])
    assert np.all(louder[1:] <= louder[:-1] * (1.0 + 0.01 / RISE) * (1.0 + 1e-12))
    assert louder[-1] == pytest.approx(quiet.variance * np.exp(10.0 / RISE), rel=1e-3)


@pytest.mark.parametrize("begin", [0.2, 5.0], ids=["before the noise is known", "when it is"])
def test_swings_that_grow_from_sample_to_sample_are_hunting_once_they_exceed_the_plan(begin):
    period, peak = 0.01, 0.05
    errors = white(begin + 0.5, period, 108)
    growing = np.arange(errors.size) * period - begin
    errors[growing >= 0.0] += 0.3 * growing[growing >= 0.0] * np.cos(2.4 * np.arange(np.sum(growing >= 0.0)))
    states = course(errors, period)
    found = [hunts(state, peak) for state in states]
    assert not any(found[: round((begin + 0.05) / period)])
    assert found[-1]
    assert not hunts(states[-1], 10.0 * peak)


@pytest.mark.parametrize("seed", range(109, 119))
def test_noise_and_a_slow_error_larger_than_the_plan_are_none(seed):
    errors = white(5.0, 0.01, seed)
    assert not any(hunts(state, 1e-4) for state in course(errors, 0.01))
    slow = 0.2 * np.sin(2.0 * np.pi * 0.5 * 0.01 * np.arange(errors.size))
    assert not any(hunts(state, 1e-3) for state in course(errors + slow, 0.01))


def test_before_anything_is_measured_nothing_hunts():
    assert not hunts(initial_noise(), 0.0)


def test_the_usual_noise_is_the_mean_of_all_and_then_of_the_last_while():
    loud = course(white(5.0, 0.001, 109, 0.01), 0.001)
    assert usual_deviation(loud[-1]) == pytest.approx(0.01, rel=0.05)
    after = course(np.zeros(round(RISE / 0.001)), 0.001, loud[-1])[-1]
    # what is a mean of all falls as time grows, from 5 to 20 s, and then with 20 s
    assert after.usual == pytest.approx(loud[-1].usual * 5.0 / RISE * np.exp(-5.0 / RISE), rel=1e-3)
    assert after.variance < 1e-6 * after.usual
