import math

import numpy as np
import pytest
from pydantic import ValidationError
from scipy import stats

from plant import (
    Actuator,
    Sensor,
)


def test_noise_is_white_and_gaussian_with_the_stated_deviation():
    samples = 100_000
    noise = Sensor(velocity_noise=0.002).draw(samples, np.random.default_rng(1))
    assert noise.shape == (samples,)
    assert stats.kstest(noise / 0.002, "norm").pvalue > 0.01
    correlations = [np.corrcoef(noise[lag:], noise[:-lag])[0, 1] for lag in (1, 2, 10)]
    assert np.max(np.abs(correlations)) < 4.0 / math.sqrt(samples)


def test_seed_reproduces_the_noise_and_another_seed_does_not():
    sensor = Sensor(velocity_noise=0.002)
    first = sensor.draw(100, np.random.default_rng(7))
    assert np.array_equal(first, sensor.draw(100, np.random.default_rng(7)))
    assert not np.any(first == sensor.draw(100, np.random.default_rng(8)))


def test_noise_free_sensor_uses_up_as_much_randomness_as_a_noisy_one():
    quiet, loud = np.random.default_rng(7), np.random.default_rng(7)
    assert np.all(Sensor().draw(100, quiet) == 0.0)
    Sensor(velocity_noise=0.002).draw(100, loud)
    assert quiet.random() == loud.random()


def test_faults_of_a_sensor_come_as_often_as_stated_and_leave_the_noise_as_it_is():
    samples, plain = 100_000, Sensor(velocity_noise=0.002)
    noise = plain.draw(samples, np.random.default_rng(1))
    leaping = Sensor(velocity_noise=0.002, leap=3.0, leap_share=0.01).draw(samples, np.random.default_rng(1)) - noise
    assert np.unique(np.abs(np.round(leaping, 9))).tolist() == [0.0, 3.0]
    assert np.count_nonzero(leaping) == pytest.approx(0.01 * samples, rel=0.1)
    assert abs(np.mean(np.sign(leaping[leaping != 0.0]))) < 0.1
    sensor, generator = Sensor(velocity_noise=0.002, held=5, held_share=0.01), np.random.default_rng(1)
    assert np.array_equal(sensor.draw(samples, generator), noise)
    held = sensor.draw_held(samples, generator)
    assert not np.any(plain.draw_held(samples, generator))
    assert np.mean(held) == pytest.approx(1.0 - 0.99**5, rel=0.1)
    runs = np.diff(np.flatnonzero(np.diff(np.concatenate([[0], held.astype(int), [0]]))))[::2]
    assert np.min(runs[:-1]) == 5
    assert Sensor().is_random is False
    assert all(sensor.is_random for sensor in (plain, Sensor(held=2, held_share=0.1), Sensor(leap=1.0, leap_share=0.1)))


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"leap": 3.0}, "leap = 3 and leap_share = 0 are not allowed: give both or none"),
        ({"held_share": 0.1}, "held = 0 and held_share = 0.1 are not allowed: give both or none"),
        ({"leap": 3.0, "leap_share": 0.1, "encoder_resolution": 1e-4}, "leap = 3 rad/s is not allowed beside encoder"),
        ({"leap": 3.0, "leap_share": 1.0}, "less than 1"),
        ({"held": 2.5, "held_share": 0.1}, "held"),
        ({"ripple_amplitude": 0.02, "ripple_period": 0.1}, "ripple_amplitude = 0.02 rad is not allowed: .*0.0159 rad"),
        ({"ripple_amplitude": 0.001, "ripple_period": 0.0}, "ripple_period"),
    ],
)
def test_faults_that_cannot_be_are_refused(fields, message):
    with pytest.raises(ValidationError, match=message):
        Sensor(**fields)


def test_resolution_beyond_the_limit_is_refused():
    with pytest.raises(ValidationError, match=r"torque_resolution = 500 N m is not allowed: .* at most torque_limit"):
        Actuator(torque_limit=400.0, torque_resolution=500.0)


def test_encoder_beside_velocity_noise_is_refused():
    with pytest.raises(ValidationError, match=r"velocity_noise = 0.002 rad/s is not allowed beside encoder_resolution"):
        Sensor(velocity_noise=0.002, encoder_resolution=1e-4)
    with pytest.raises(ValidationError, match="encoder_resolution"):
        Sensor(encoder_resolution=0.0)
