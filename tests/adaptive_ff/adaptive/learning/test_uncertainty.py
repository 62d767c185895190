"""How far the adaptive controller's estimates may be off, as it says itself."""

import math

import numpy as np
import pytest
from closed_loops import SCENARIO, course_along, drive, make

from adaptive_ff import simulate
from adaptive_ff.adaptive.learning.estimator_state import Levels, initial_estimator_state
from adaptive_ff.adaptive.learning.uncertainty import assess
from adaptive_ff.friction.model import ESTIMATED
from adaptive_ff.scenario.truth import true_model

LAG = ESTIMATED.index("friction_lag")


def state_after(estimator, rows, variance, floor, keep):
    """State of an estimator whose instruments were these rows, and whose errors were of this mean square."""
    state, size = initial_estimator_state(estimator), estimator.first.size
    weights = (1.0 - keep) * keep ** np.arange(len(rows) - 1, -1, -1)
    filled = 1.0 - keep ** len(rows)
    data = (rows * weights[:, np.newaxis]).T @ rows
    information = (1.0 - filled) * state.recursion.information + filled * floor * np.eye(size) + data
    agreement = np.column_stack([np.diag(data), np.diag(data)])
    period = -math.log(keep) * estimator.memory
    return state._replace(
        recursion=state.recursion._replace(information=information),
        agreement=agreement,
        levels=Levels(filled * variance, 90.0, 0.3, period * len(rows), 0.0),
    )


@pytest.mark.parametrize("count", [60, 400, 5000])
def test_it_is_the_covariance_of_weighted_least_squares_with_independent_errors(count):
    estimator, period, variance = make("adaptive_unsupervised").parameters.estimator, 0.01, 2e-3
    keep = math.exp(-period / estimator.memory)
    rows = np.random.default_rng(31).standard_normal((count, 5)) * np.array([1.0, 0.8, 0.5, 0.7, 0.6])
    state = state_after(estimator, rows, variance, 4e-4, keep)
    weights = keep ** np.arange(count - 1, -1, -1)
    inverse = np.linalg.inv((rows * weights[:, np.newaxis]).T @ rows)
    covariance = variance * inverse @ ((rows * weights[:, np.newaxis] ** 2).T @ rows) @ inverse
    expected = np.sqrt(np.diag(covariance)) * estimator.scale
    expected[LAG] = math.hypot(expected[LAG], period / math.sqrt(12.0))
    assert assess(estimator, state, period).errors == pytest.approx(expected, rel=0.12)


def test_what_the_data_do_not_tell_is_as_uncertain_as_its_unit():
    """Rows that know two of the parameters as a sum only, and nothing of a third."""
    estimator, period = make("adaptive_unsupervised").parameters.estimator, 0.01
    rows = np.random.default_rng(32).standard_normal((3000, 5))
    rows[:, 2], rows[:, 4] = rows[:, 1], 0.0
    state = state_after(estimator, rows, 1e-3, 2e-4, math.exp(-period / estimator.memory))
    found = assess(estimator, state, period)
    assert found.together[[0, 3]] == pytest.approx(0.0, abs=0.01)
    assert found.together[[1, 2, 4]] == pytest.approx([math.sqrt(0.5), math.sqrt(0.5), 1.0], rel=0.01)
    assert found.alone[[0, 1, 2, 3]] == pytest.approx(0.0, abs=0.01)
    assert found.alone[4] == pytest.approx(1.0, rel=1e-3)
    assert found.shares[[0, 3]] == pytest.approx(1.0, abs=0.01)
    assert found.shares[[1, 2]] == pytest.approx(0.5, abs=0.01)
    assert found.shares[4] == pytest.approx(0.0, abs=0.01)


def test_a_new_controller_is_as_uncertain_as_its_units():
    controller = make("adaptive_unsupervised")
    scale = controller.parameters.estimator.scale
    assert controller.uncertainties == pytest.approx(dict(zip(ESTIMATED, scale, strict=True)))


@pytest.mark.parametrize("noise", [0.002, 0.005])
def test_settled_on_the_built_in_joint_the_truth_is_within_two_uncertainties(noise):
    """They are on the safe side there: see ``python -m benchmarks.confidence``."""
    ratios = []
    for seed in range(201, 209):
        scenario = SCENARIO.modified(seed=seed, sensor={"velocity_noise": noise})
        controller = make("adaptive_unsupervised", scenario)
        simulate(scenario, controller)
        true = true_model(scenario)
        found, uncertain = controller.estimates, controller.uncertainties
        ratios.append([(found[name] - getattr(true, name)) / uncertain[name] for name in ESTIMATED])
    assert np.all(np.abs(ratios) < 2.0)
    assert np.all(np.sqrt(np.mean(np.square(ratios), axis=0)) > 0.1)


def test_more_noise_makes_it_less_sure_and_constant_speed_forgets_all_but_the_sum():
    controllers = {}
    for noise in (0.001, 0.004):
        scenario = SCENARIO.modified(sensor={"velocity_noise": noise})
        controllers[noise] = make("adaptive_unsupervised", scenario)
        simulate(scenario, controllers[noise])
    quiet, loud = (controllers[noise].uncertainties for noise in (0.001, 0.004))
    assert all(loud[name] > 2.0 * quiet[name] for name in ESTIMATED[:4])
    rested = controllers[0.001]
    speed = SCENARIO.reference_velocity()[-1]
    ramp = np.linspace(speed, 0.2, 1001)
    drive(rested, course_along(np.concatenate([ramp, np.full(100_000, 0.2)]), substeps=10, noise=0.001))
    scale = dict(zip(ESTIMATED, rested.parameters.estimator.scale, strict=True))
    assert all(rested.uncertainties[name] > 0.5 * scale[name] for name in ESTIMATED if name != "coulomb")
    row = np.array([1.0, 0.2])  # Coulomb and viscous friction at that speed
    assert abs(row @ [rested.estimates[name] - getattr(SCENARIO.joint, name) for name in ("coulomb", "viscous")]) < 3.0
