import math

import numpy as np
import pytest
from scipy import stats

from plant import Actuator, Sensor
from plant.actuator import realise_torque, ripple_torque
from plant.sensor import encoder_reading, measured_angle, measured_speed


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
    ("fields", "commands", "given"),
    [
        ({}, (1e9, -1e9), (1e9, -1e9)),
        ({"torque_limit": 50.0}, (70.0, 50.0, 7.0, -70.0), (50.0, 50.0, 7.0, -50.0)),
        ({"torque_resolution": 0.5}, (7.3, 7.2, -7.2, 1e9), (7.5, 7.0, -7.0, 1e9)),
        ({"torque_resolution": 3.0, "torque_limit": 50.0}, (70.0, -70.0, 4.0), (48.0, -48.0, 3.0)),
        ({"torque_resolution": 50.0, "torque_limit": 50.0}, (30.0, 20.0), (50.0, 0.0)),
        ({"rate_limit": 200.0}, (70.0, 11.0, -70.0), (12.0, 11.0, 8.0)),  # within 10 ms of 10 N m
        ({"rate_limit": 200.0, "torque_limit": 11.5, "torque_resolution": 1.0}, (70.0, 8.6), (11.0, 9.0)),
    ],
)
def test_drive_gives_what_slope_limit_and_resolution_leave_of_a_command(fields, commands, given):
    drive = Actuator(**fields).parameters
    assert tuple(realise_torque(drive, command, 10.0, 0.01) for command in commands) == given


def test_ripple_and_measured_angle_are_sines():
    drive = Actuator(ripple_amplitude=2.0, ripple_period=0.1).parameters
    assert [ripple_torque(drive, angle) for angle in (0.0, 0.025, -0.025)] == pytest.approx([0.0, 2.0, -2.0])
    ripple, plain = Sensor(ripple_amplitude=0.01, ripple_period=0.5).angle_ripple, Sensor().angle_ripple
    assert measured_angle(ripple, 0.625) == pytest.approx(0.635)
    slope = (measured_angle(ripple, 0.3 + 1e-6) - measured_angle(ripple, 0.3 - 1e-6)) / 2e-6
    assert measured_speed(ripple, 0.3, 1.5) == pytest.approx(1.5 * slope, rel=1e-6)
    assert (measured_angle(plain, 0.3), measured_speed(plain, 0.3, 1.5)) == (0.3, 1.5)
    assert [encoder_reading(0.2, angle) for angle in (0.31, -0.31)] == pytest.approx([0.4, -0.4])
