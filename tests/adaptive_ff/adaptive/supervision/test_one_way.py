"""Motion that goes one way for long: the offset is forgotten, friction is not."""

import numpy as np
import pytest
from closed_loops import make

from adaptive_ff import load_scenario
from adaptive_ff.adaptive.supervision.one_way import RATE, left_over, loosen_offset_in_place, note_one_way_in_place
from adaptive_ff.friction.bounds import COULOMB, OFFSET
from adaptive_ff.scenario.library import SCENARIOS
from tests.helpers.judged import judge

SIZE, PERIOD = 6, 0.01


def information_of(one_way, seed=1):
    """Information of motion both ways, and of motion one way to a share."""
    rng = np.random.default_rng(seed)
    rows = rng.standard_normal((200, SIZE))
    rows[:, COULOMB] = np.where(rng.random(200) < 0.5 + 0.5 * one_way, 1.0, -1.0)
    rows[:, OFFSET] = 1.0
    return rows.T @ rows / 200


def loosened(information, duration=PERIOD):
    changed = information.copy()
    loosen_offset_in_place(changed, duration, np.zeros(SIZE))
    return changed


def test_motion_both_ways_loses_nothing():
    before = information_of(0.0)
    assert loosened(before) == pytest.approx(before, abs=1e-3)


def test_covariance_of_the_offset_alone_is_larger_after_motion_one_way():
    """By its own variance as the data leave it, times rate, time and the sixth power of the likeness."""
    before = information_of(0.9)
    difference = np.linalg.inv(loosened(before)) - np.linalg.inv(before)
    alike = before[OFFSET, COULOMB] ** 2 / (before[OFFSET, OFFSET] * before[COULOMB, COULOMB])
    expected = np.zeros((SIZE, SIZE))
    expected[OFFSET, OFFSET] = RATE * PERIOD * alike**3 / before[OFFSET, OFFSET]
    assert difference == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("duration", [PERIOD, 1e3])
def test_information_stays_positive_definite(duration):
    information = information_of(0.98)
    for _ in range(100):
        information = loosened(information, duration)
        information += 1e-6 * np.eye(SIZE)  # the floor
    assert np.linalg.eigvalsh(information)[0] > 0.0


def test_without_information_nothing_happens():
    assert np.array_equal(loosened(np.zeros((SIZE, SIZE))), np.zeros((SIZE, SIZE)))


def test_weight_that_is_not_modelled_is_no_friction():
    weight = load_scenario(SCENARIOS / "gravity_100.toml")
    for seed in (101, 105):
        found = judge(weight.modified(seed=seed, duration=30.0), "adaptive", draws=1)
        assert found.settled > 4.0, "it was 2.8 and 5.6 while half of the weight was taken for friction"


def noisy(state, variance=4e-6):
    noise = state.observer.noise._replace(measured=1e3, variance=variance)
    return state._replace(observer=state.observer._replace(noise=noise))


def test_what_is_left_counts_only_beyond_noise_and_a_hundredth_of_the_friction():
    state = make("adaptive").state
    state.estimator.recursion.estimate[COULOMB] = 50.0
    assert left_over(state.observer.noise, state.estimator, 100.0, 1.0) == 0.0, "the noise is not known"
    state = noisy(state)
    assert left_over(state.observer.noise, state.estimator, 100.0, 1.0) == 1.0
    assert left_over(state.observer.noise, state.estimator, 100.0, 0.3) == 0.3
    assert left_over(state.observer.noise, state.estimator, 0.25, 1.0) == 0.0
    assert left_over(state.observer.noise, state.estimator, 0.375, 1.0) == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("learnt", "share", "changes"), [(100.0, 0.0, True), (0.5, 0.0, False), (100.0, 0.1, False), (0.0, 0.0, False)]
)
def test_the_offset_is_forgotten_once_a_memory_has_been_learnt_and_no_map_is_fed(learnt, share, changes):
    controller = make("adaptive")
    old = controller.state.estimator
    new = old._replace(levels=old.levels._replace(learnt=learnt), friction_map=old.friction_map._replace(share=share))
    new.recursion.information[:] = information_of(0.95)
    before = new.recursion.information.copy()
    note_one_way_in_place(controller.parameters.estimator, old, new, PERIOD)
    assert np.any(new.recursion.information != before) == changes
