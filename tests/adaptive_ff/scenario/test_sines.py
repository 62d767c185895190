"""Sums of sines on an even grid: those of numpy, one by one."""

import math

import numpy as np
import pytest

from adaptive_ff.scenario.series import CHUNK, add_sine, sum_of_sines

OMEGAS = 2.0 * math.pi * np.array([0.01, 0.23, 1.0])
PHASES, WEIGHTS = np.array([0.3, 6.1, 2.5]), np.array([1.0, -0.4, 0.25])


@pytest.mark.parametrize("size", [1, 2, 3, 60001, CHUNK + 700])
def test_sum_is_that_of_the_sines_of_the_whole_grid(size):
    time = 0.001 * np.arange(size)
    angles = OMEGAS[:, None] * time + PHASES[:, None]
    found = sum_of_sines(OMEGAS, PHASES, WEIGHTS, time)
    np.testing.assert_allclose(found, WEIGHTS @ np.sin(angles), rtol=0.0, atol=4e-13)


def test_sine_is_added_to_the_bit_as_numpy_adds_outer_products():
    generator = np.random.default_rng(1)
    sine, cosine = np.sin(generator.uniform(0.0, 9.0, (2, 13)))
    inner_sine, inner_cosine = np.sin(generator.uniform(0.0, 9.0, (2, 17)))
    table = generator.standard_normal((13, 17))
    expected = table + 0.3 * (np.outer(sine, inner_cosine) + np.outer(cosine, inner_sine))
    add_sine(0.3, sine, cosine, inner_sine, inner_cosine, table)
    np.testing.assert_array_equal(table, expected)
