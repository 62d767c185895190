"""What the scheme of Canudas, Astrom and Braun claims, and the choices made here."""

import math

import numpy as np
import pytest
from closed_loops import SCENARIO, build_setup, drive, make, setup_along

from adaptive_ff.baselines.canudas import (
    INITIAL_COVARIANCE,
    CanudasController,
    CanudasMeasuredController,
    friction_along,
)
from adaptive_ff.comparison.registry import CONTROLLERS

GAINS = SCENARIO.feedback.gains
PERIOD = 0.01
TRUE = np.array([17.0, 40.0, 65.0, 90.0, 50.0])
"""Inertia, Coulomb friction forwards and backwards, viscous friction forwards and backwards."""

DIRECTED = pytest.mark.parametrize("controller", [CanudasController, CanudasMeasuredController])


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


@DIRECTED
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


def test_nothing_is_learnt_in_the_dead_zone_or_across_it():
    joint = CanudasController(*GAINS, PERIOD, inertia=20.0, dead_zone=0.05)
    before = joint.estimates
    for velocity in (0.0, 0.04, 0.06, 0.049, 0.2, -0.2, -0.03):
        joint.step(0.1, velocity, realised_torque=50.0)
    assert joint.estimates == before
    joint.step(0.1, -0.06, realised_torque=50.0)
    joint.step(0.1, -0.07, realised_torque=50.0)
    assert joint.estimates != before


@pytest.mark.parametrize(
    ("start", "end"), [(0.1, 0.3), (-0.2, -0.1), (0.1, -0.3), (-0.05, 0.2), (0.0, 0.2), (0.0, 0.0)]
)
def test_friction_along_a_period_is_its_mean(start, end):
    moments = (np.arange(20_000) + 0.5) / 20_000
    velocity = start + (end - start) * moments
    expected = np.mean([discrete_friction(value) if value != 0.0 else 0.0 for value in velocity])
    assert friction_along(TRUE, start, end) == pytest.approx(expected, abs=0.02)


def feedforward_at(joint, velocity):
    """Friction torque that a joint with known friction compensates at a constant reference of 0.2 rad/s."""
    joint.state.physical[:] = TRUE
    joint.enabled = False
    feedback = joint.parameters
    torque = joint.step(0.2, velocity, next_reference=0.2)
    error = 0.2 - velocity
    return torque - (feedback.feedback.proportional + feedback.feedback.integral * PERIOD) * error


@pytest.mark.parametrize("compensated", [0.0, 0.6, 1.0])
def test_the_stated_share_of_friction_is_fed_forward_along_the_reference(compensated):
    joint = CanudasController(*GAINS, PERIOD, inertia=20.0, dead_zone=0.05, compensated=compensated)
    assert feedforward_at(joint, -0.1) == pytest.approx(compensated * (40.0 + 90.0 * 0.2), abs=1e-9)


@pytest.mark.parametrize(
    ("velocity", "expected"),
    [(0.2, 40.0 + 18.0), (-0.3, -65.0 - 15.0), (0.05, 44.5), (0.02, 0.4 * 44.5), (-0.01, -0.2 * 67.5), (0.0, 0.0)],
)
def test_the_stated_share_of_friction_is_compensated_at_the_measured_velocity(velocity, expected):
    joint = CanudasMeasuredController(*GAINS, PERIOD, inertia=20.0, dead_zone=0.05, compensated=0.6)
    assert feedforward_at(joint, velocity) == pytest.approx(0.6 * expected, abs=1e-9)


def test_compensating_more_friction_than_there_is_keeps_a_joint_moving_and_the_rest_that_is_left_lets_it_rest():
    """The reason for under-compensation; Coulomb friction is overestimated by a quarter here."""
    joint = SCENARIO.joint.model_copy(update={"stiction": 60.0, "friction_lag": 0.0})
    setup = setup_along(np.where(np.arange(20_001) < 100, 0.1, 0.0), joint=joint)

    def fastest(compensated):
        controller = CanudasMeasuredController(60.0, 0.0, 0.001, inertia=20.0, dead_zone=0.002, compensated=compensated)
        controller.state.physical[:] = [20.0, 75.0, 75.0, 80.0, 80.0]
        controller.enabled = False
        record, _ = drive(controller, setup)
        return np.max(np.abs(record.velocity[-10_000:]))

    assert fastest(1.0) == pytest.approx(15.0 / 60.0, rel=0.01)  # what is compensated too much, over the gain
    assert fastest(0.7) == 0.0


def test_covariance_stays_within_that_of_the_start_at_constant_speed():
    setup = setup_along(np.full(200_001, 0.2), noise=0.002, seed=4)
    controller = CanudasController(*GAINS, 0.001, inertia=20.0, dead_zone=0.01, memory=1.0)
    drive(controller, setup)
    assert np.trace(controller.state.recursion.covariance) < 1.01 * 5 * INITIAL_COVARIANCE
    assert np.all(np.isfinite(estimates_of(controller)))


def test_it_follows_a_real_joint_better_than_pi():
    setup = build_setup(SCENARIO)
    errors = {}
    for name in ("pi", "canudas", "canudas_measured"):
        record, _ = drive(make(name), setup)
        errors[name] = np.sqrt(np.mean((setup.reference - record.velocity)[30_000:] ** 2))
    assert errors["canudas"] < 0.7 * errors["pi"]
    assert errors["canudas_measured"] < 0.9 * errors["pi"]


@pytest.mark.parametrize("name", ["canudas", "canudas_measured"])
def test_memory_that_a_scenario_tells_reaches_the_controller(name):
    def memory(scenario):
        return CONTROLLERS[name](scenario).memory

    assert memory(SCENARIO.modified(adaptation={"memory": 7.0})) == 7.0
    assert memory(SCENARIO) == 5.0
