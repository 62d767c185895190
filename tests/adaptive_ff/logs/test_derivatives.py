"""Filters and differences: gains at single frequencies, polynomials, order of convergence."""

import numpy as np
import pytest

from adaptive_ff.logs.bandwidth import NOISE_SHARE, check_bandwidth, choose_bandwidth, rounding_noise
from adaptive_ff.logs.derivatives import REACH, differentiate, differentiate_twice, lowpass

INNER = slice(REACH, -REACH)


@pytest.mark.parametrize("degree", range(9))
def test_differences_are_exact_for_polynomials_up_to_the_eighth_degree(degree):
    time = np.linspace(-1.0, 1.0, 41)
    curve = np.polynomial.Polynomial.basis(degree)
    once, twice = differentiate(curve(time), 0.05), differentiate_twice(curve(time), 0.05)
    assert once[INNER] == pytest.approx(curve.deriv()(time)[INNER], abs=1e-11)
    assert twice[INNER] == pytest.approx(curve.deriv(2)(time)[INNER], abs=1e-9)


def test_differences_converge_with_the_eighth_order():
    errors = []
    for count in (40, 80):
        time = np.linspace(0.0, 2.0, count + 1)
        period = time[1]
        once, twice = differentiate(np.sin(5.0 * time), period), differentiate_twice(np.sin(5.0 * time), period)
        errors.append(
            [
                np.max(np.abs(once - 5.0 * np.cos(5.0 * time))[INNER]),
                np.max(np.abs(twice + 25.0 * np.sin(5.0 * time))[INNER]),
            ]
        )
    order = np.log2(np.array(errors[0]) / np.array(errors[1]))
    assert order == pytest.approx([8.0, 8.0], abs=0.4)


def test_gain_at_a_tenth_of_the_sampling_frequency_is_as_stated():
    omega = 2.0 * np.pi * 0.1
    phase = omega * np.arange(200)
    once = differentiate(np.sin(phase), 1.0)
    assert np.max(np.abs(once - omega * np.cos(phase))[INNER]) / omega == pytest.approx(3.5e-5, rel=0.02)


@pytest.mark.parametrize("share", [0.2, 1.0, 2.0])
def test_lowpass_has_the_gain_of_its_filter_twice_and_no_delay(share):
    time = 0.001 * np.arange(8000)
    wave = np.cos(2.0 * np.pi * 10.0 * share * (time - 4.0))
    middle = slice(3000, 5001)
    expected = wave / (1.0 + share**8)  # squared gain of a Butterworth filter of the fourth order
    assert lowpass(wave, (10.0,), 0.001)[middle] == pytest.approx(expected[middle], abs=0.01 * max(expected))


def test_band_is_five_times_the_frequency_of_the_motion_and_noise_does_not_widen_it():
    time = 0.001 * np.arange(20000)
    position = np.sin(2.0 * np.pi * 3.0 * time)
    generator = np.random.default_rng(101)
    noisy = position + 1e-4 * generator.standard_normal(time.size)
    for series in (position, noisy):
        assert choose_bandwidth(series, 0.001, is_position=True) == pytest.approx(15.0, rel=0.05)
    velocity = np.cos(2.0 * np.pi * 3.0 * time)
    noisy = velocity + 0.1 * generator.standard_normal(time.size)
    for series in (velocity, noisy):
        assert choose_bandwidth(series, 0.001, is_position=False) == pytest.approx(15.0, rel=0.05)


def test_band_is_narrower_where_noise_of_the_acceleration_would_count():
    """In a band ``f`` white noise of density ``s`` leaves the acceleration ``(2 pi)^2 s f^3 / 3``."""
    time = 0.001 * np.arange(20000)
    generator = np.random.default_rng(101)
    velocity = np.cos(2.0 * np.pi * 3.0 * time) + 0.4 * generator.standard_normal(time.size)
    density, accelerated = 2.0 * 0.001 * 0.4**2, 0.5 * (2.0 * np.pi * 3.0) ** 2
    expected = (NOISE_SHARE * accelerated * 3.0 / (4.0 * np.pi**2 * density)) ** (1.0 / 3.0)
    assert choose_bandwidth(velocity, 0.001, is_position=False) == pytest.approx(expected, rel=0.1)
    counts = 2.0 * np.pi / 4096.0
    position = np.round(np.sin(2.0 * np.pi * 3.0 * time) / counts) * counts
    assert choose_bandwidth(position, 0.001, is_position=True) == pytest.approx(15.0, rel=0.05)


def test_noise_of_a_lattice_is_that_of_rounding():
    generator = np.random.default_rng(101)
    steps = 0.1 * np.round(np.cumsum(generator.normal(0.0, 3.0, 5000)) / 0.1)
    assert rounding_noise(steps, 0.001, is_position=True) == pytest.approx(0.1**2 / 12.0)
    assert rounding_noise(generator.standard_normal(5000), 0.001, is_position=True) == 0.0
    assert rounding_noise(np.zeros(100), 0.001, is_position=True) == 0.0


def test_band_stays_within_its_limits():
    time = 0.01 * np.arange(3000)
    slow, fast = np.sin(2.0 * np.pi * 0.1 * time), np.sin(2.0 * np.pi * 4.0 * time)
    assert choose_bandwidth(fast, 0.01, is_position=True) == 10.0  # a tenth of 100 Hz
    assert choose_bandwidth(slow[::5], 0.05, is_position=True) == 2.0
    assert choose_bandwidth(slow, 0.001, is_position=True) == 10.0
    with pytest.raises(ValueError, match=r"bandwidth = 10.1 Hz is not allowed: .* 10 Hz"):
        check_bandwidth(10.1, 0.01)
