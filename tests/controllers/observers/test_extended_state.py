import math

import numpy as np
import pytest
from inertia_loops import GAINS, INERTIA, PERIOD, make_observing, run_inertia

from controllers.observers.inertia_observer import double_pole_gains

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
