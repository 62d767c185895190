"""Series on even grids: sums of sines, and what straight lines through the samples of one lose of it."""

import math

import numpy as np
import pytest

from adaptive_ff.scenario.series import CHUNK, size_and_lost_fraction, sum_of_sines
from adaptive_ff.scenario.tables import Sampling

OMEGAS = 2.0 * math.pi * np.array([0.01, 0.23, 1.0])
PHASES, WEIGHTS = np.array([0.3, 6.1, 2.5]), np.array([1.0, -0.4, 0.25])


@pytest.mark.parametrize("size", [1, 2, 3, 60001, CHUNK + 700])
def test_sum_is_that_of_the_sines_of_the_whole_grid(size):
    time = 0.001 * np.arange(size)
    angles = OMEGAS[:, None] * time + PHASES[:, None]
    found = sum_of_sines(OMEGAS, PHASES, WEIGHTS, time)
    np.testing.assert_allclose(found, WEIGHTS @ np.sin(angles), rtol=0.0, atol=4e-13)


def lost_by_interpolation(series, steps):
    """The same by numpy's interpolation of the whole series."""
    lost = series - np.interp(np.arange(series.size), steps, series[steps])
    return math.sqrt(np.mean(lost**2) / np.mean(series**2))


@pytest.mark.parametrize("period", [0.001, 0.002, 0.01, 0.3])
@pytest.mark.parametrize("jitter", [0.0, 0.9])
@pytest.mark.parametrize("length", [3.0, 1.2e-3 * CHUNK])
def test_size_and_lost_fraction_are_those_of_an_interpolation(period, jitter, length):
    steps = Sampling(period=period, jitter=jitter).steps(length, 0.001)
    series = np.random.default_rng(1).standard_normal(steps[-1] + 1).cumsum() + 5.0
    size, lost = size_and_lost_fraction(series, steps)
    assert size == pytest.approx(math.sqrt(np.mean(series**2)), rel=1e-12)
    assert lost == pytest.approx(lost_by_interpolation(series, steps), rel=1e-9, abs=1e-15)


def test_straight_line_loses_nothing_and_a_wave_that_is_zero_at_every_sample_all():
    steps = 10 * np.arange(41)
    assert size_and_lost_fraction(0.5 * np.arange(401.0), steps)[1] < 1e-15
    assert size_and_lost_fraction(np.sin(0.1 * math.pi * np.arange(401)), steps)[1] == pytest.approx(1.0, rel=1e-12)
    assert size_and_lost_fraction(np.zeros(401), steps) == (0.0, 0.0)
