"""Controllers with an observer: what they have in common, and what single ones add."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from inertia_loops import GAINS, INERTIA, OBSERVING, PERIOD, make_observing, response, run_inertia, z_transform

from controllers import SuperTwisting
from controllers.observers.inertia_observer import double_pole_gains
from controllers.observers.super_twisting import FIRST, SECOND, twisted

observing = pytest.mark.parametrize("name", OBSERVING)
REST = np.zeros(600)


def q_filter(controller, bandwidth):
    """From a load to its estimate of the next sample: one pole, two equal ones, or those of the settled gains."""
    z, kept, found = z_transform(), math.exp(-2.0 * math.pi * bandwidth * PERIOD), controller.parameters
    if type(controller).__name__ != "KalmanDisturbance":
        poles = 1 if type(controller).__name__ == "DisturbanceObserver" else 2
        return ((1.0 - kept) * z / (z - kept)) ** poles
    corrected = PERIOD / INERTIA * found.disturbance_gain
    return corrected * z**2 / ((z - 1) * (z - (1.0 - found.velocity_gain)) + corrected * z)


@observing
def test_estimate_is_the_load_behind_the_q_filter_and_a_period(name):
    controller = make_observing(name, 6.0)
    reference, load = np.array([[1.0], [40.0]]) * np.random.default_rng(4).standard_normal((2, 500))
    _, disturbance = run_inertia(controller, reference, load=load)
    assert disturbance == pytest.approx(response(q_filter(controller, 6.0) / z_transform(), load), abs=1e-7)


@pytest.mark.parametrize("name", ["DisturbanceObserver", "KalmanDisturbance"])
def test_loads_reach_the_velocity_through_one_minus_q_as_umeno_and_hori_have_it(name):
    """``w/d = -P (1 - Q/z)/(1 + P C)``: the loop of the PI alone, times what the observer leaves."""
    z, controller = z_transform(), make_observing(name, 6.0)
    feedback, inertia = GAINS[0] + GAINS[1] * PERIOD * z / (z - 1), PERIOD / INERTIA / (z - 1)
    load = 40.0 * np.random.default_rng(3).standard_normal(500)
    velocity, _ = run_inertia(controller, np.zeros(500), load=load)
    left = 1 - q_filter(controller, 6.0) / z
    assert np.max(np.abs(velocity)) > 0.05
    assert velocity == pytest.approx(response(-inertia * left / (1 + inertia * feedback), load), abs=1e-9)


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


def test_estimate_of_a_constant_load_approaches_it_exponentially_whatever_the_periods():
    """Ohnishi's first-order filter: ``d (1 - exp(-g t))`` at any time, jittered or after gaps."""
    generator = np.random.default_rng(6)
    dt = PERIOD * generator.uniform(0.3, 1.7, 60)
    gaps = np.where(generator.uniform(size=60) < 0.2, math.nan, 0.0)
    gaps[0] = 0.0
    _, disturbance = run_inertia(
        make_observing("DisturbanceObserver", 6.0), np.zeros(60), load=25.0, dt=dt, disturbance=gaps
    )
    time = np.concatenate([[0.0], np.cumsum(dt)[:-1]])
    valid = np.isfinite(gaps)
    assert np.count_nonzero(~valid) > 5
    expected = 25.0 * -np.expm1(-2.0 * math.pi * 6.0 * time)
    assert disturbance[valid] == pytest.approx(expected[valid], rel=1e-9)


def test_wrong_inertia_shows_as_a_disturbance_while_the_joint_accelerates():
    """20 % more inertia than assumed: the missing torque is ``0.2 Jn dw/dt``."""
    controller = make_observing("DisturbanceObserver", 6.0)
    ramp = 0.02 * np.arange(1500)
    velocity, disturbance = run_inertia(controller, ramp, inertia=1.2 * INERTIA)
    assert disturbance[-1] == pytest.approx(0.2 * INERTIA * 0.02 / PERIOD, rel=1e-6)
    assert velocity[-1] == pytest.approx(ramp[-1], abs=1e-6)


BANDWIDTH = 8.0
KEPT = math.exp(-2.0 * math.pi * BANDWIDTH * PERIOD)


def test_both_poles_are_where_gao_and_miklosovic_put_them():
    """Error dynamics ``(I - L c) F`` of a current observer of velocity and disturbance."""
    transition = np.array([[1.0, -PERIOD / INERTIA], [0.0, 1.0]])
    velocity_gain, disturbance_gain = double_pole_gains(INERTIA, 2.0 * math.pi * BANDWIDTH, PERIOD)
    polynomial = np.poly((np.eye(2) - [[velocity_gain, 0.0], [-disturbance_gain, 0.0]]) @ transition)
    assert polynomial == pytest.approx([1.0, -2.0 * KEPT, KEPT**2], rel=1e-12)


def test_load_that_rises_steadily_leaves_the_offset_that_two_poles_predict():
    """An observer with a constant disturbance as its model lags behind a ramp by ``(1 + b)/(1 - b)`` periods."""
    slope = 0.3  # N m a period
    load = slope * np.arange(1500)
    velocity, disturbance = run_inertia(make_observing("ExtendedState", BANDWIDTH), np.zeros(1500), load=load)
    lag = slope * (1.0 + KEPT) / (1.0 - KEPT)
    assert load[-1] - disturbance[-1] == pytest.approx(lag, rel=1e-9)
    # the torque must be the load: Kp (0 - observed velocity) + estimate = load
    observed = -lag / GAINS[0]
    velocity_gain, disturbance_gain = double_pole_gains(INERTIA, 2.0 * math.pi * BANDWIDTH, PERIOD)
    innovation = -slope / disturbance_gain
    assert velocity[-1] == pytest.approx(observed + (1.0 - velocity_gain) * innovation, rel=1e-9)


def test_plant_becomes_an_integrator_so_steps_of_the_reference_are_followed_by_one_pole():
    """Gao: with the total disturbance cancelled, the loop is ``wc/(s + wc)``; sampled, ``1 - wc Ts``."""
    controller = make_observing("ExtendedState", BANDWIDTH)
    reference = np.full(60, 0.3)
    velocity, disturbance = run_inertia(controller, reference)
    pole = 1.0 - GAINS[0] * PERIOD / INERTIA
    assert velocity == pytest.approx(0.3 * (1.0 - pole ** np.arange(60)), abs=1e-12)
    assert np.max(np.abs(disturbance)) < 1e-10


@given(st.floats(-1.0, 1.0), st.floats(1e-3, 1e4), st.floats(1e-4, 0.1))
def test_implicit_step_solves_its_inclusion(error, bound, duration):
    after, sign = twisted(error, bound, duration)
    left = after + duration * FIRST * math.sqrt(bound * abs(after)) * math.copysign(1.0, after)
    left += duration**2 * SECOND * bound * sign
    assert left == pytest.approx(error, abs=1e-9 * max(abs(error), duration**2 * bound))
    assert abs(sign) <= 1.0
    if after != 0.0:
        assert sign == math.copysign(1.0, after)


def test_disturbance_within_the_bound_is_found_exactly_after_a_finite_time():
    # d = 20 + 30 t, |dd/dt| = 30 < J L = 200; only the sample's own delay is left: the mean over a period
    inertia, period = 20.0, 0.001
    controller = SuperTwisting(0.0, 0.0, period, inertia=inertia, bound=10.0).run_uncompiled()
    velocity, torque = 0.0, controller.step(0.0, 0.0, next_reference=0.0)
    for k in range(3000):
        disturbance = 20.0 + 30.0 * (k + 0.5) * period
        velocity += period / inertia * (torque - disturbance)
        torque = controller.step(0.0, velocity, next_reference=0.0)
        if k > 2000:
            assert controller.disturbance == pytest.approx(disturbance, abs=0.5)
    assert abs(velocity) < 2.0
