import math

import numpy as np
import pytest
from pydantic import ValidationError
from scipy import stats

from plant import Actuator, VelocitySensor, realise_torque


def test_noise_is_white_and_gaussian_with_the_stated_deviation():
    samples = 100_000
    noise = VelocitySensor(velocity_noise=0.002).draw(samples, np.random.default_rng(1))
    assert noise.shape == (samples,)
    assert stats.kstest(noise, "norm", args=(0.0, 0.002)).pvalue > 0.01
    correlations = [np.corrcoef(noise[lag:], noise[:-lag])[0, 1] for lag in (1, 2, 10)]
    assert np.max(np.abs(correlations)) < 4.0 / math.sqrt(samples)


def test_seed_reproduces_the_noise_and_another_seed_does_not():
    sensor = VelocitySensor(velocity_noise=0.002)
    first = sensor.draw(100, np.random.default_rng(7))
    assert np.array_equal(first, sensor.draw(100, np.random.default_rng(7)))
    assert not np.any(first == sensor.draw(100, np.random.default_rng(8)))


def test_noise_level_only_scales_the_noise_of_a_seed():
    quiet = VelocitySensor(velocity_noise=0.001).draw(100, np.random.default_rng(7))
    loud = VelocitySensor(velocity_noise=0.005).draw(100, np.random.default_rng(7))
    assert loud == pytest.approx(5.0 * quiet, rel=1e-14)


def test_noise_free_sensor_uses_up_as_much_randomness_as_a_noisy_one():
    quiet, loud = np.random.default_rng(7), np.random.default_rng(7)
    assert np.all(VelocitySensor().draw(100, quiet) == 0.0)
    VelocitySensor(velocity_noise=0.002).draw(100, loud)
    assert quiet.random() == loud.random()


@pytest.mark.parametrize("value", [-0.001, math.nan, math.inf, "0.002", True, None])
def test_sensor_refuses_a_wrong_noise(value):
    with pytest.raises(ValidationError, match="velocity_noise"):
        VelocitySensor(velocity_noise=value)


def test_sensor_and_actuator_refuse_unknown_fields():
    with pytest.raises(ValidationError, match="noise"):
        VelocitySensor(noise=0.002)
    with pytest.raises(ValidationError, match="limit"):
        Actuator(limit=400.0)


@pytest.mark.parametrize(
    ("command", "realised"),
    [
        (0.0, 0.0),
        (399.9, 399.9),
        (-399.9, -399.9),
        (400.1, 400.0),
        (-400.1, -400.0),
        (1e300, 400.0),
        (-math.inf, -400.0),
    ],
)
def test_torque_limit_cuts_both_ways_and_leaves_the_rest_alone(command, realised):
    assert realise_torque(Actuator(torque_limit=400.0).parameters, command) == realised


@pytest.mark.parametrize("command", [0.0, -1e12, 1e300])
def test_drive_without_a_limit_gives_what_is_asked(command):
    assert realise_torque(Actuator().parameters, command) == command


@pytest.mark.parametrize("value", [0.0, -400.0, math.nan, math.inf, "400", True])
def test_actuator_refuses_a_wrong_limit(value):
    with pytest.raises(ValidationError, match="torque_limit"):
        Actuator(torque_limit=value)
