"""What the controllers with an observer have in common."""

import math

import numpy as np
import pytest
from inertia_loops import GAINS, INERTIA, OBSERVING, PERIOD, make_observing, run_inertia

observing = pytest.mark.parametrize("name", OBSERVING)
REST = np.zeros(600)


@observing
@pytest.mark.parametrize("load", [37.0, -5.0])
def test_constant_load_is_removed_exactly_without_an_integral(name, load):
    controller = make_observing(name, 8.0, gains=(GAINS[0], 0.0))
    velocity, disturbance = run_inertia(controller, REST, load=load)
    assert np.max(np.abs(velocity)) > 0.01 * abs(load) / INERTIA
    assert velocity[-1] == pytest.approx(0.0, abs=1e-12)
    assert disturbance[-1] == pytest.approx(load, rel=1e-12)


@observing
def test_known_load_that_is_told_does_not_appear_in_the_estimate(name):
    load = 30.0 + 20.0 * np.sin(0.05 * np.arange(600))
    velocity, disturbance = run_inertia(make_observing(name, 8.0), REST, load=load, known=load)
    assert np.max(np.abs(disturbance)) < 1e-10
    assert np.max(np.abs(velocity)) < 1e-12
    _, untold = run_inertia(make_observing(name, 8.0), REST, load=load)
    assert np.max(np.abs(untold)) > 40.0


@observing
def test_nominal_inertia_follows_any_previewed_reference_without_the_feedback(name):
    reference = np.random.default_rng(1).standard_normal(200)
    controller = make_observing(name, 8.0)
    velocity, disturbance = run_inertia(controller, reference, velocity=reference[0])
    assert velocity == pytest.approx(reference, abs=1e-9)
    assert np.max(np.abs(disturbance)) < 1e-8 * np.max(np.abs(np.diff(reference))) * INERTIA / PERIOD


@observing
def test_without_preview_the_last_slope_is_continued_so_a_ramp_is_followed_exactly(name):
    reference = 0.01 * np.arange(900)
    velocity, _ = run_inertia(make_observing(name, 8.0), reference, preview=False)
    assert velocity[-1] == pytest.approx(reference[-1], rel=1e-11)


@observing
def test_slope_that_is_continued_is_one_in_real_time(name):
    """A ramp at jittered samples, met on the move: torque is the inertia times the slope, so nothing is left to do."""
    dt = PERIOD * np.random.default_rng(3).uniform(0.5, 1.5, 300)
    reference = 0.8 * np.concatenate([[0.0], np.cumsum(dt)[:-1]])
    reference[0] = reference[1]  # at rest for a period, as the first torque is zero
    reference -= reference[0]
    velocity, disturbance = run_inertia(make_observing(name, 8.0), reference, dt=dt, preview=False)
    late = slice(150, None)
    assert velocity[late] == pytest.approx(reference[late], abs=1e-5)
    assert np.max(np.abs(disturbance[late])) < 1e-3


def blocked_then_released(name, tell):
    """A load that the drive cannot carry for 10 s, then none: largest estimate, and largest speed afterwards."""
    load = np.where(np.arange(2000) < 1000, 80.0, 0.0)
    controller = make_observing(name, 8.0)
    velocities, estimates, velocity, realised = [], [], 0.0, None
    for k in range(2000):
        torque = controller.step(0.0, velocity, realised_torque=realised if tell else None)
        realised = min(max(torque, -50.0), 50.0)
        velocity = max(velocity + PERIOD / INERTIA * (realised - load[k]), -0.05 if k < 1000 else -math.inf)
        velocities.append(velocity)
        estimates.append(controller.disturbance)
    return np.max(np.abs(estimates)), np.max(np.abs(velocities[1000:]))


@observing
def test_told_of_the_realised_torque_the_estimate_does_not_wind_up(name):
    """The joint creeps against a stop while the drive saturates; the stop carries part of the load."""
    largest, fastest = blocked_then_released(name, tell=True)
    assert largest < 90.0
    untold_largest, untold_fastest = blocked_then_released(name, tell=False)
    assert untold_largest > 10.0 * largest
    assert untold_fastest > 2.0 * fastest


@observing
@pytest.mark.parametrize("lost", [math.nan, math.inf, -math.inf], ids=str)
def test_lost_measurements_are_counted_and_leave_the_estimate(name, lost):
    controller = make_observing(name, 8.0)
    controller.step(0.0, lost)
    assert controller.disturbance == 0.0
    run_inertia(controller, REST, load=37.0)
    before = controller.disturbance
    for _ in range(3):
        controller.step(0.0, lost, realised_torque=37.0)
        assert controller.disturbance == before
    assert controller.rejected == 4


@observing
def test_constant_load_is_removed_over_jittered_periods_and_gaps(name):
    generator = np.random.default_rng(2)
    dt = PERIOD * generator.uniform(0.5, 1.5, 1500)
    gaps = np.where(generator.uniform(size=1500) < 0.1, math.nan, 0.0)
    _, disturbance = run_inertia(make_observing(name, 4.0), np.zeros(1500), load=37.0, dt=dt, disturbance=gaps)
    assert disturbance[-1] == pytest.approx(37.0, rel=1e-9)


@observing
def test_a_run_in_plain_python_is_the_compiled_one_bit_for_bit(name):
    reference = np.sin(0.1 * np.arange(300))
    gaps = np.where(np.arange(300) % 37 == 5, math.nan, 0.0)
    found = run_inertia(make_observing(name, 8.0), reference, load=12.0, disturbance=gaps)
    plain = run_inertia(make_observing(name, 8.0).run_uncompiled(), reference, load=12.0, disturbance=gaps)
    for series, expected in zip(found, plain, strict=True):
        assert np.array_equal(series, expected, equal_nan=True)
