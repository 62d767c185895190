"""Convergence of the rigid joint's step in the solver period, against a solution from event to event.

Sliding motion without a stop is in ``test_step.py``. Without friction lag the step is of first order through stops and
breakaways, too. With a lag the joint bounces about zero velocity before it rests: there only means converge with first
order, single velocities with about the square root.
"""

import math

import numpy as np
import pytest
from stepped_joint import motion, run

from plant import JointParameters, JointState, Stribeck

STRIBECK = Stribeck(60.0, 90.0, 80.0, 0.05, 1.0)
PERIODS = (1e-3, 5e-4, 2.5e-4, 1.25e-4)
GRID = 1e-3


def velocities(joint, torques, period):
    return run(joint, JointState(0.0, 0.0, 0.0), torques, period)[:, 0]


def sines(*waves):
    """Torque, and its slope, that is a sum of sines of amplitudes (N m) and frequencies (Hz)."""

    def torque(time):
        return sum(size * np.sin(2.0 * math.pi * frequency * time) for size, frequency in waves)

    def slope(time):
        return sum(
            size * 2.0 * math.pi * frequency * math.cos(2.0 * math.pi * frequency * time) for size, frequency in waves
        )

    return torque, slope


def beside_the_exact_motion(lag, duration, *waves):
    """Exact velocities on a grid, and for each period those of the step there."""
    joint = JointParameters(20.0, STRIBECK, STRIBECK, 0.0, lag)
    torque, slope = sines(*waves)
    grid = GRID * np.arange(round(duration / GRID))
    exact = motion(joint, torque, slope, duration, grid)
    own = [
        velocities(joint, torque(h * np.arange(1, round(duration / h) + 1)), h)[: -1 : round(GRID / h)] for h in PERIODS
    ]
    assert np.mean(np.abs(exact) < 1e-6) > 0.05  # it rests
    assert np.ptp(np.sign(exact)) == 2.0
    return exact, own


def test_without_lag_every_velocity_converges_with_first_order_through_stops_and_breakaways():
    exact, own = beside_the_exact_motion(0.0, 2.0, (120.0, 1.0))
    errors = [np.max(np.abs(velocity - exact)) for velocity in own]
    assert errors[0] < 3e-3
    assert np.log2(np.divide(errors[:-1], errors[1:])) == pytest.approx(1.0, abs=0.05)


def test_with_lag_means_converge_with_first_order_and_single_velocities_slower():
    exact, own = beside_the_exact_motion(0.02, 2.0, (110.0, 0.5), (20.0, 1.7))
    size = math.sqrt(np.mean(np.square(exact)))
    means = [math.sqrt(np.mean(np.square(velocity))) / size - 1.0 for velocity in own]
    assert abs(means[0]) < 1e-3
    assert np.log2(np.divide(means[:-1], means[1:])) == pytest.approx(1.0, abs=0.1)
    errors = [np.max(np.abs(velocity - exact)) for velocity in own]
    assert errors[0] < 0.015
    order = math.log2(errors[0] / errors[-1]) / 3.0
    assert 0.3 < order < 0.8  # about one half; first order would be a model without bounces
