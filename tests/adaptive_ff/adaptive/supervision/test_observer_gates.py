"""The gates of the observer: which inertia it takes, and when what it observes is fed back."""

import math

import numpy as np
import pytest
from closed_loops import SCENARIO, begin, course_along, make, run_compiled
from observed_joint import FEEDBACK, INERTIA, NOTHING_SPECIAL, OBSERVER, PERIOD, after, observed

from adaptive_ff.adaptive.supervision.observer import observe
from adaptive_ff.adaptive.supervision.observer_gates import (
    misfit,
    observed_inertia,
    observer_gain,
    short_mean,
    tells_at_once,
)
from adaptive_ff.adaptive.supervision.observer_state import ObserverParameters, initial_observer, start_observer
from adaptive_ff.simulation.experiment import empty_record
from controllers import check_gains


@pytest.mark.parametrize(
    ("identified", "squared", "inertia"),
    [(0.5, 4.0, 0.5), (0.5, 6.0, 0.75), (0.5, 8.0, 1.0), (0.5, 100.0, 1.0), (2.0, 0.0, 1.0), (2.0, 8.0, 1.0)],
)
def test_a_smaller_inertia_is_believed_where_noise_explains_what_the_model_leaves(identified, squared, inertia):
    """The error of the identification is squared, over what the noise makes of the gain; both times their inertia."""
    noise = initial_observer(FEEDBACK).noise
    assert misfit(noise, FEEDBACK, 0.0) == 1.0, "noise is not known"
    known = observed(np.zeros(300), 0.002 * np.random.default_rng(4).standard_normal(301), np.full(301, 0.1))[-1].noise
    unfit = misfit(known, FEEDBACK, squared * FEEDBACK.proportional**2 * known.variance)
    assert observed_inertia(OBSERVER, identified * INERTIA, unfit) == pytest.approx(inertia * INERTIA)


def test_joint_at_rest_and_repeated_values_tell_nothing_of_noise():
    rng = np.random.default_rng(2)
    rested = observed(np.zeros(300), 0.01 * rng.standard_normal(301), np.zeros(301))[-1]
    repeated = observed(np.zeros(300), np.full(301, 0.1), np.linspace(0.1, 0.3, 301))[-1]
    assert rested.noise.measured == repeated.noise.measured == 0.0
    assert observer_gain(OBSERVER, rested, FEEDBACK, INERTIA, 0.0) == 1.0, "while noise is not known all gates are open"


def gain_at_an_error(error, correction=0.0):
    """Gain where a load is observed, and the plan is missed by an error that the residual does not explain."""
    noise = 0.002 * np.random.default_rng(3).standard_normal(401)
    state, gains = start_observer(initial_observer(FEEDBACK), 0.1, 0.1), []
    for sample in range(400):
        velocity = 0.1 + correction - error + noise[sample]
        torque = 60.0 + INERTIA * (velocity - state.velocity) / PERIOD if sample else 60.0
        # a residual that the loop has long made up for: what it would make of it is no error any more
        state = after(OBSERVER, state, torque, 0.1, correction, velocity, False, 1.0, math.inf)
        gains.append(observer_gain(OBSERVER, state, FEEDBACK, INERTIA, 0.0))
    return gains[-1]


def test_error_that_no_residual_explains_opens_the_gate():
    assert gain_at_an_error(0.0) == 0.0
    assert gain_at_an_error(0.01) == 1.0


def test_what_an_outer_loop_asks_for_is_no_error():
    assert gain_at_an_error(0.0, correction=0.05) == 0.0
    assert gain_at_an_error(0.01, correction=0.05) == 1.0


def test_noise_out_of_a_filter_opens_no_gate_where_the_model_fits():
    """Second differences tell too little of it; where the model does not fit, what is left may be an error."""
    observer, feedback = (
        ObserverParameters(65.0, 65.0, INERTIA, 0.0, 0.001),
        check_gains(314.0 * INERTIA, 4000.0 * INERTIA, 0.01),
    )
    white, noise = 0.002 * np.random.default_rng(5).standard_normal(20000), 0.0
    state, gains = start_observer(initial_observer(feedback), 0.1, 0.1), []
    for value in white:
        noise += 0.8 * (value - noise)
        state = observe(observer, state, feedback, 60.0, INERTIA, 0.1, 0.0, 0.1 + noise, 0.001, NOTHING_SPECIAL)
        gains.append([observer_gain(observer, state, feedback, INERTIA, unfit) for unfit in (0.0, 1.0)])
    fit, unfit = np.mean(gains[10000:], axis=0)
    assert unfit > 0.1
    assert fit == 0.0


def run_frozen(reference, load, *, controller, position=None):
    """Let a controller that does not learn move a frictionless joint; observer after each sample, and the end."""
    free = SCENARIO.joint.model_copy(update={"coulomb": 0.0, "stiction": 0.0, "viscous": 0.0, "offset": load})
    course = course_along(reference, joint=free, substeps=10, noise=0.002, seed=int(load))
    record = empty_record(course, len(controller.estimate_names))
    position = begin(course) if position is None else position._replace(sample=0, acting=-1)
    state, observers = controller.state, []
    for sample in range(1, course.noise.size + 1):
        state, position = run_compiled(controller.parameters, state, course, position, sample, record)
        observers.append(state.observer)
    controller.state = state
    return observers, position


@pytest.fixture(scope="module")
def loaded():
    """Observers before and after a load step on a joint that is the inertia which the controller assumes."""
    controller = make("adaptive")
    controller.enabled = False
    reference = SCENARIO.modified(seed=101, duration=20.0).reference_velocity()
    before, position = run_frozen(reference[:10_001], 0.0, controller=controller)
    after, _ = run_frozen(reference[10_000:], 30.0, controller=controller, position=position)
    return before, after


def test_on_a_joint_that_the_model_explains_nothing_is_fed_back(loaded):
    gains = np.array([state.gain for state in loaded[0]])
    assert np.all(gains[200:] == 0.0)


def test_a_load_step_opens_the_gates_within_three_samples(loaded):
    """A short mean alone needs five."""
    turned = 30  # the plan has moved one way for that many samples and more when the load comes
    assert loaded[1][0].one_way > turned * PERIOD
    assert loaded[1][0].gain == 0.0
    assert loaded[1][3].gain == 1.0


def known_friction(friction, held=False):
    return NOTHING_SPECIAL._replace(held=held, friction=friction)


def test_what_is_large_beside_the_friction_tells_of_a_sudden_change():
    assert tells_at_once(20.0, 1.0, False, known_friction(60.0))
    assert tells_at_once(-20.0, 1.0, False, known_friction(60.0))
    assert not tells_at_once(8.0, 1.0, False, known_friction(60.0))


@pytest.mark.parametrize(
    ("one_way", "coloured", "held"),
    [(0.1, False, False), (1.0, True, False), (1.0, False, True)],
    ids=["shortly after a reversal", "coloured noise", "held"],
)
def test_what_may_be_something_else_tells_of_no_sudden_change(one_way, coloured, held):
    assert not tells_at_once(20.0, one_way, coloured, known_friction(60.0, held))


def test_of_a_sudden_change_a_share_counts_at_once():
    assert short_mean(1.0, 100.0, 0.03, 0.0) == pytest.approx(3.97)
    assert short_mean(1.0, 100.0, 0.03, 0.25) == 25.0
    assert short_mean(50.0, 0.0, 0.03, 0.25) == pytest.approx(48.5)


def test_a_load_step_opens_the_gates_until_the_integral_carries_it(loaded):
    gains = np.array([state.gain for state in loaded[1]])
    assert np.all(gains[10:30] == 1.0)
    assert np.all(gains[100:] == 0.0)
    disturbances = np.array([state.disturbance for state in loaded[1]])
    assert np.mean(disturbances[30:]) == pytest.approx(30.0, rel=0.02)
