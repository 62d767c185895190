import math

import numpy as np
import pytest
from pydantic import ValidationError
from scipy import stats

from plant import (
    Actuator,
    Sensor,
    encoder_reading,
    measured_angle,
    measured_speed,
    realise_torque,
    ripple_torque,
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


def test_a_measured_speed_is_the_slope_of_the_measured_angle():
    ripple, step = Sensor(ripple_amplitude=2e-3, ripple_period=0.05).angle_ripple, 1e-6
    angles = np.linspace(-0.1, 0.1, 41)
    rise = [measured_angle(ripple, angle + step) - measured_angle(ripple, angle - step) for angle in angles]
    speeds = np.array([measured_speed(ripple, angle, 3.0) for angle in angles])
    assert speeds == pytest.approx(3.0 * np.array(rise) / (2.0 * step), rel=1e-6)
    assert np.ptp(speeds) == pytest.approx(2.0 * 3.0 * 2e-3 * 2.0 * np.pi / 0.05, rel=1e-3)


def test_an_angle_without_ripple_is_measured_as_it_is():
    ripple = Sensor().angle_ripple
    assert (measured_angle(ripple, 0.1), measured_speed(ripple, 0.1, 3.0)) == (0.1, 3.0)


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
    assert realise_torque(Actuator(torque_limit=400.0).parameters, command, 0.0, 0.01) == realised


@pytest.mark.parametrize("command", [0.0, -1e12, 1e300])
def test_drive_without_a_limit_gives_what_is_asked(command):
    assert realise_torque(Actuator().parameters, command, 5.0, 0.01) == command


@pytest.mark.parametrize(
    ("command", "realised"), [(0.0, 0.0), (0.9, 0.0), (1.1, 2.0), (-0.9, 0.0), (-3.1, -4.0), (7.4, 6.0), (-99.0, -6.0)]
)
def test_torque_is_rounded_to_the_resolution_and_never_beyond_the_limit(command, realised):
    drive = Actuator(torque_limit=7.0, torque_resolution=2.0).parameters
    assert realise_torque(drive, command, 0.0, 0.01) == realised


def test_rate_limit_holds_the_torque_back_in_proportion_to_the_time():
    drive = Actuator(rate_limit=100.0).parameters
    assert realise_torque(drive, 50.0, 10.0, 0.01) == pytest.approx(11.0, rel=1e-14)
    assert realise_torque(drive, -50.0, 10.0, 0.02) == pytest.approx(8.0, rel=1e-14)
    assert realise_torque(drive, 10.5, 10.0, 0.01) == 10.5


def test_ripple_has_its_amplitude_and_period_and_no_mean():
    drive = Actuator(ripple_amplitude=3.0, ripple_period=0.2).parameters
    torques = np.array([ripple_torque(drive, position) for position in np.arange(0.0, 0.2, 1e-4)])
    assert np.max(torques) == pytest.approx(3.0, rel=1e-6)
    assert np.mean(torques) == pytest.approx(0.0, abs=1e-12)
    assert ripple_torque(drive, 0.05) == pytest.approx(3.0, rel=1e-12)


def test_resolution_beyond_the_limit_is_refused():
    with pytest.raises(ValidationError, match=r"torque_resolution = 500 N m is not allowed: .* at most torque_limit"):
        Actuator(torque_limit=400.0, torque_resolution=500.0)


@pytest.mark.parametrize(("position", "reading"), [(0.0, 0.0), (0.04, 0.0), (0.06, 0.1), (-0.06, -0.1), (12.34, 12.3)])
def test_encoder_gives_the_next_multiple_of_its_resolution(position, reading):
    assert encoder_reading(0.1, position) == pytest.approx(reading, abs=1e-12)


def test_encoder_beside_velocity_noise_is_refused():
    with pytest.raises(ValidationError, match=r"velocity_noise = 0.002 rad/s is not allowed beside encoder_resolution"):
        Sensor(velocity_noise=0.002, encoder_resolution=1e-4)
    with pytest.raises(ValidationError, match="encoder_resolution"):
        Sensor(encoder_resolution=0.0)
