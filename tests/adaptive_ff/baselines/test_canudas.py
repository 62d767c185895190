"""What the scheme of Canudas, Astrom and Braun claims, and the choices made here."""

import math

import numpy as np
import pytest
from closed_loops import SCENARIO

from adaptive_ff.baselines import CanudasController, CanudasMeasuredController
from adaptive_ff.baselines.canudas import INITIAL_COVARIANCE, friction_along

GAINS = SCENARIO.feedback.gains
PERIOD = 0.01
TRUE = np.array([17.0, 40.0, 65.0, 90.0, 50.0])
"""Inertia, Coulomb friction forwards and backwards, viscous friction forwards and backwards."""


def discrete_friction(velocity):
    _, forwards, backwards, slope_forwards, slope_backwards = TRUE
    return forwards + slope_forwards * velocity if velocity > 0.0 else -backwards + slope_backwards * velocity


def discrete_joint(steps, seed, noise=0.0):
    """A joint that is the assumed discrete model, under a torque that drives it forth and back; uneven periods."""
    rng = np.random.default_rng(seed)
    durations = PERIOD * rng.uniform(0.7, 1.3, steps)
    velocity, torque = np.zeros(steps + 1), np.zeros(steps)
    velocity[0] = 0.2
    wanted = 0.3 * np.cos(0.04 * np.arange(steps + 1)) + 0.05 * rng.standard_normal(steps + 1)
    for k in range(steps):
        torque[k] = 600.0 * (wanted[k] - velocity[k])
        velocity[k + 1] = velocity[k] + durations[k] / TRUE[0] * (torque[k] - discrete_friction(velocity[k]))
    return velocity + noise * rng.standard_normal(steps + 1), torque, durations


def watch_joint(controller, velocity, torque, durations):
    controller.step(0.0, velocity[0])
    for k in range(torque.size):
        controller.step(0.0, velocity[k + 1], realised_torque=torque[k], dt=durations[k])
    return controller


def estimates_of(controller):
    return np.array(list(controller.estimates.values()))


@pytest.mark.parametrize("controller", [CanudasController, CanudasMeasuredController])
def test_friction_of_each_direction_is_identified_from_the_discrete_model(controller):
    joint = controller(*GAINS, PERIOD, inertia=20.0, dead_zone=0.01, memory=3.0)
    watch_joint(joint, *discrete_joint(4000, seed=1))
    assert estimates_of(joint) == pytest.approx(TRUE, rel=1e-6)


def test_it_is_one_weighted_batch_solution_with_the_fading_prior():
    """Oracle: numpy's least squares on the unscaled equations in the joint's mobility and frictions over inertia."""
    dead_zone, memory, inertia = 0.02, 8.0, 20.0
    velocity, torque, durations = discrete_joint(1500, seed=2, noise=0.002)
    joint = CanudasController(*GAINS, PERIOD, inertia=inertia, dead_zone=dead_zone, memory=memory)
    watch_joint(joint, velocity, torque, durations)
    rows, outputs, ages = [], [], []
    for k in range(torque.size):
        start, end = velocity[k], velocity[k + 1]
        if min(abs(start), abs(end)) < dead_zone or start * end < 0.0:
            continue
        forwards = float(start > 0.0)
        backwards = 1.0 - forwards
        row = [torque[k], -forwards, backwards, -start * forwards, -start * backwards]
        rows.append(durations[k] * np.array(row))
        outputs.append(end - start)
        ages = [*(age + durations[k] for age in ages), 0.0]
    unit = GAINS[0] * dead_zone
    size = np.array([1.0, unit, unit, 0.2 * GAINS[0], 0.2 * GAINS[0]]) / inertia  # of each coefficient
    weights = np.exp(-0.5 * np.array(ages) / memory) * GAINS[0] / unit
    fading = math.exp(-0.5 * ages[0] / memory) / math.sqrt(INITIAL_COVARIANCE)  # not forgotten at the first equation
    prior = fading * np.diag(1.0 / size)
    first = np.array([1.0 / inertia, 0.0, 0.0, 0.0, 0.0])
    matrix = np.vstack([weights[:, np.newaxis] * np.array(rows), prior])
    found = np.linalg.lstsq(matrix, np.append(weights * np.array(outputs), prior @ first), rcond=None)[0]
    expected = np.append(1.0 / found[0], found[1:] / found[0])
    assert estimates_of(joint) == pytest.approx(expected, rel=1e-9)
    assert np.max(np.abs(estimates_of(joint) / TRUE - 1.0)) > 1e-3  # the noise is in both


@pytest.mark.parametrize(
    ("start", "end"), [(0.1, 0.3), (-0.2, -0.1), (0.1, -0.3), (-0.05, 0.2), (0.0, 0.2), (0.0, 0.0)]
)
def test_friction_along_a_period_is_its_mean(start, end):
    moments = (np.arange(20_000) + 0.5) / 20_000
    velocity = start + (end - start) * moments
    expected = np.mean([discrete_friction(value) if value != 0.0 else 0.0 for value in velocity])
    assert friction_along(TRUE, start, end) == pytest.approx(expected, abs=0.02)
