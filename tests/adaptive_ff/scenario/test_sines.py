"""Sums of sines on an even grid: those of numpy, one by one."""

import math

import numpy as np
import pytest

from adaptive_ff.scenario.series import CHUNK, sum_of_sines

OMEGAS = 2.0 * math.pi * np.array([0.01, 0.23, 1.0])
PHASES, WEIGHTS = np.array([0.3, 6.1, 2.5]), np.array([1.0, -0.4, 0.25])


@pytest.mark.parametrize("size", [1, 2, 3, 60001, CHUNK + 700])
def test_sum_is_that_of_the_sines_of_the_whole_grid(size):
    time = 0.001 * np.arange(size)
    angles = OMEGAS[:, None] * time + PHASES[:, None]
    found = sum_of_sines(OMEGAS, PHASES, WEIGHTS, time)
    np.testing.assert_allclose(found, WEIGHTS @ np.sin(angles), rtol=0.0, atol=4e-13)
