"""The parts of the estimator that are its own: bounds, the test of the instrument, the hand-over to feedforward."""

import sys

import numpy as np
import pytest
from closed_loops import drive

from adaptive_ff import load_scenario
from adaptive_ff.adaptive.learning.correction import correct_in_place
from adaptive_ff.adaptive.learning.estimator import PEAK_FACTOR
from adaptive_ff.comparison.registry import make_controller
from adaptive_ff.estimation.instruments import AGREEMENT, choose_instrument_in_place, gradients_agree
from adaptive_ff.estimation.resetting import factor_in_place, move_parameter_in_place
from adaptive_ff.friction.bounds import confine_in_place, possible_ranges, torque_model, write_ranges
from adaptive_ff.friction.feedforward import FeedforwardState, exchange_model
from adaptive_ff.friction.model import model_friction
from adaptive_ff.scenario.truth import true_model
from adaptive_ff.simulation.experiment import lay_course
from controllers import PI, hand_over
from plant import Joint

SCENARIO = load_scenario().modified(duration=10.0)


def random_information(seed):
    rows = np.random.default_rng(seed).standard_normal((9, 5))
    return rows.T @ rows


def cholesky(matrix):
    factor = matrix.copy()
    factor_in_place(factor)
    return factor


@pytest.mark.parametrize("index", range(5))
def test_moving_one_parameter_costs_least_fit(index):
    """Oracle: minimum of the quadratic form with one coordinate given, by numpy's solver."""
    information, distance = random_information(index), 0.7
    correction = np.zeros(5)
    move_parameter_in_place(cholesky(information), index, distance, correction, np.empty(5))
    others = [i for i in range(5) if i != index]
    expected = -np.linalg.solve(information[np.ix_(others, others)], information[others, index] * distance)
    assert correction[index] == pytest.approx(distance, rel=1e-12)
    assert np.allclose(correction[others], expected, rtol=1e-9)


def test_correction_keeps_what_the_data_say_of_a_sum():
    """Data that know only Fc + Fs: a correction that would make Fs negative moves Fc instead."""
    scale = make_controller(SCENARIO, "adaptive_unsupervised").parameters.estimator.scale
    direction = np.array([0.0, 1.0, 1.0, 0.0, 0.0])
    information = np.outer(direction, direction) + 1e-6 * np.eye(5)
    estimate = np.array([20.0, 60.0, 10.0, 80.0, 0.02])
    correction = np.array([0.0, 0.0, -20.0, 0.0, 0.0]) / scale
    ranges = np.array([[2.0, 200.0], [0.0, 500.0], [0.0, 500.0], [0.0, 5000.0], [0.0, 0.1]])
    total = estimate[1] + estimate[2] - 20.0
    correct_in_place(scale, estimate, correction, cholesky(information), ranges, np.empty(5))
    assert estimate[2] == 0.0
    assert estimate[1] + estimate[2] == pytest.approx(total, rel=1e-4)


@pytest.mark.parametrize("size", [5, 6, 8])
def test_friction_is_possible_as_far_as_torques_and_speeds_explain_it(size):
    possible, ranges = possible_ranges(20.0, 0.1, size), np.zeros((size, 2))
    before = possible.copy()
    write_ranges(possible, 100.0, 0.2, ranges)
    assert np.array_equal(possible, before)
    expected = [[2.0, 200.0], [0.0, 100.0], [0.0, 100.0], [0.0, 500.0], [0.0, 0.1]]
    expected += [[-100.0, 100.0], [-100.0, 100.0], [-500.0, 500.0]]
    assert ranges == pytest.approx(np.array(expected[:size]))
    estimate = np.full(size, -1e9)
    confine_in_place(estimate, ranges)
    assert np.array_equal(estimate, ranges[:, 0])


def test_largest_torque_seen_bounds_the_friction_that_is_learnt():
    controller = make_controller(SCENARIO, "adaptive")
    drive(controller, lay_course(SCENARIO))
    levels, ranges = controller.state.estimator.levels, controller.state.estimator.scratch.ranges
    assert ranges[1].tolist() == ranges[2].tolist() == [0.0, PEAK_FACTOR * levels.torque]
    assert ranges[3, 1] == PEAK_FACTOR * levels.torque / levels.speed


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_model_of_an_estimate_is_possible_in_either_direction(sign):
    """Asymmetries are not larger than what they are of: viscous friction, and stiction less Coulomb friction."""
    free = torque_model(np.array([20.0, 60.0, 90.0, 80.0, 0.02, 5.0, 20.0 * sign, 30.0 * sign]), 0.02, 0.05, 1.0)
    assert free[7:10] == (5.0, 20.0 * sign, 30.0 * sign)
    held = torque_model(np.array([20.0, 60.0, 70.0, 10.0, 0.02, 5.0, 20.0 * sign, 30.0 * sign]), 0.02, 0.05, 1.0)
    assert held[7:10] == (5.0, 10.0 * sign, 10.0 * sign)
    rising = torque_model(np.array([20.0, 60.0, 50.0, 10.0, 0.02, 5.0, 20.0 * sign, 0.0]), 0.02, 0.05, 1.0)
    assert (rising.stiction, rising.stiction_asymmetry) == (50.0, 10.0 * sign)


@pytest.mark.parametrize(("ratio", "alike"), [(1.0, True), (AGREEMENT[0] - 0.05, False), (AGREEMENT[1] + 0.05, False)])
def test_instrument_must_resemble_the_measured_gradient(ratio, alike):
    model, agreement = np.array([1.0, -0.5, 0.3, 0.2, 0.1]), np.zeros((5, 2))
    instrument = chosen(agreement, model, ratio * model, 0.0)
    assert gradients_agree(agreement, 0.0) is alike
    assert np.array_equal(instrument, model if alike else ratio * model)


def chosen(agreement, model, measured, unexcited):
    """Instrument that is chosen; what is given stays as it is."""
    instrument, given = np.zeros(model.size), (model.copy(), measured.copy())
    choose_instrument_in_place(agreement, model, measured, 0.99, unexcited, instrument)
    assert np.array_equal(given, (model, measured))
    return instrument


def test_asking_whether_gradients_agree_changes_nothing():
    agreement = np.array([[1.0, 1.0], [1e-9, 1e-9]])
    before = agreement.copy()
    assert gradients_agree(agreement, 1e-4)
    assert np.array_equal(agreement, before)


def test_noise_without_excitation_is_no_disagreement():
    generator, agreement, model = np.random.default_rng(0), np.zeros((5, 2)), 1e-6 * np.ones(5)

    def answers(unexcited):
        for noise in 1e-2 * generator.standard_normal((1000, 5)):
            chosen(agreement, model, noise, unexcited)
            yield gradients_agree(agreement, unexcited)

    assert all(answers(1e-5))
    agreement[:] = 0.0
    assert not all(answers(0.0))


def test_instrument_that_does_not_excite_a_parameter_moves_it_no_more():
    agreement, model = np.array([[1.0, 1.0], [1e-9, 1e-9]]), np.array([0.5, 1e-4])
    assert chosen(agreement, model, model.copy(), 1e-4).tolist() == [0.5, 0.0]


def test_exchanged_model_leaves_the_lagged_friction_of_the_new_one():
    old = true_model(SCENARIO)
    new = old._replace(coulomb=40.0, viscous=10.0)
    for reference in (0.2, -0.2):
        sign = np.sign(reference)
        settled = FeedforwardState(sign * model_friction(old, 0.2), reference, True)
        assert exchange_model(settled, old, new, reference, settled.slip, settled.adhesion).friction == pytest.approx(
            sign * model_friction(new, 0.2)
        )
    still = FeedforwardState(5.0, 0.0, True)
    assert exchange_model(still, old, new, 0.0, still.slip, still.adhesion) == still


def test_hand_over_needs_an_integral():
    with_integral, without = PI(10.0, 5.0, 0.01), PI(10.0, 0.0, 0.01)
    assert hand_over(with_integral.parameters, with_integral.state, 3.0).integral == -3.0
    assert hand_over(without.parameters, without.state, 3.0).integral == 0.0


@pytest.mark.parametrize("name", ["adaptive_unsupervised", "adaptive"])
def test_learning_does_not_make_the_torque_jump(name):
    """At the first sample that is learnt from, the output equals that of a controller that does not learn."""
    course = lay_course(SCENARIO)
    learning, frozen = (make_controller(SCENARIO, name) for _ in range(2))
    frozen.enabled = False
    joint, torque = Joint(SCENARIO.joint), None
    for k in range(course.noise.size):
        reference, following = (float(course.reference[i]) for i in course.samples[k : k + 2])
        measured = joint.state.velocity + float(course.noise[k])
        first, second = (
            controller.step(reference, measured, next_reference=following, realised_torque=torque)
            for controller in (learning, frozen)
        )
        if learning.estimates["coulomb"] > 10.0:
            break
        torque = min(max(first, -400.0), 400.0)
        joint.step(torque, SCENARIO.sampling.period)
    else:
        pytest.fail("nothing was learnt")
    assert first == pytest.approx(second, rel=1e-9)
    assert abs(first) > 20.0


@pytest.mark.parametrize("size", [1e1, 1e3, 1e5, 1e8])
def test_one_wild_measurement_is_forgotten(size):
    """Of single wild samples none leaves the joint worse tracked ten seconds later."""
    scenario = load_scenario().modified(duration=30.0)
    course = lay_course(scenario)
    settled = []
    for sample in (700, 1100, 1400, 1650, None):
        noise = course.noise.copy()
        if sample is not None:
            noise[sample] = size * np.sign(course.reference[course.samples[sample]])
        controller = make_controller(scenario, "adaptive")
        record, _ = drive(controller, course._replace(noise=noise))
        assert np.all(np.isfinite(record.torque))
        assert np.all(np.isfinite(record.estimates))
        error = (course.reference - record.velocity)[-10000:]
        settled.append(np.sqrt(np.mean(error**2)))
    assert max(settled[:-1]) <= 1.5 * settled[-1]


@pytest.mark.parametrize("name", ["adaptive", "adaptive_unsupervised", "adaptive_paper"])
def test_steps_neither_leak_nor_lose_the_arrays_of_the_state(name):
    """The compiled step runs without counting references; the arrays must stay the same objects, held as often."""
    controller = make_controller(SCENARIO, name)
    controller.step(0.1, 0.1)
    arrays = [value for value in leaves(controller.state) if isinstance(value, np.ndarray)]
    before = [sys.getrefcount(array) for array in arrays]
    for _ in range(1000):
        controller.step(0.1, 0.1)
    after = [value for value in leaves(controller.state) if isinstance(value, np.ndarray)]
    assert all(new is old for new, old in zip(after, arrays, strict=True))
    del after
    assert [sys.getrefcount(array) for array in arrays] == before


def leaves(state):
    """All values in a nested state."""
    if not hasattr(state, "_fields"):
        return [state]
    return [leaf for field in state for leaf in leaves(field)]
