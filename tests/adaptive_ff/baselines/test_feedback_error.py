"""What feedback-error learning claims, and the choices made here."""

import itertools
import math

import numpy as np
import pytest
from closed_loops import SCENARIO, build_setup, drive
from plan_inputs import plan_inputs

from adaptive_ff.baselines.feedback_learning import FeedbackErrorLearning
from adaptive_ff.friction.feedforward import initial_feedforward_state, step_feedforward
from adaptive_ff.scenario.truth import true_model

GAINS = SCENARIO.feedback.gains
ASSUMED = {"inertia": 20.0, "stribeck_velocity": 0.05}
RESPONSE = 20.0 / GAINS[0]


def with_lags(lags, period=0.01, **others):
    return FeedbackErrorLearning(*GAINS, period, **{**ASSUMED, "lags": lags, **others})


def teach(controller, model, lag=0):
    """Give a controller the weights that make its inverse model the given one; ``lag`` is the place of its lag."""
    controller.state.weights[:3] = model.inertia, model.viscous, 0.0
    controller.state.weights[3 + 2 * lag : 5 + 2 * lag] = model.coulomb, model.stiction


def quiet(**joint):
    """The built-in joint sampled at 1 kHz without noise."""
    return SCENARIO.modified(duration=120.0, sampling={"period": 0.001}, sensor={"velocity_noise": 0.0}, joint=joint)


def test_with_the_true_weights_its_feedforward_is_that_of_the_model():
    """Oracle: the model. The lag acts on viscous friction there, which leaves ``sigma tau dw_ref/dt``."""
    setup, model = build_setup(SCENARIO.modified(duration=6.0)), true_model(SCENARIO)._replace(viscous=0.0)
    learning = with_lags([model.friction_lag / 2.0, model.friction_lag])
    teach(learning, model, lag=1)
    learning.enabled = False
    found, _ = drive(learning, setup)
    state, expected = initial_feedforward_state(), []
    for reference, following in itertools.pairwise(setup.reference[setup.samples]):
        torque, state = step_feedforward(model, state, plan_inputs(reference, following), 0.01)
        expected.append(torque)
    assert found.feedforward[: len(expected)] == pytest.approx(expected, abs=1e-9)
    assert np.ptp(found.feedforward) > 100.0


def test_it_converges_to_the_inverse_model_of_a_joint_without_lag_and_the_feedback_torque_vanishes():
    scenario = quiet(friction_lag=0.0)
    setup, learning = build_setup(scenario), with_lags([0.0], period=0.001, rate=0.15 / RESPONSE)
    record, _ = drive(learning, setup)
    joint = scenario.joint
    found = learning.estimates
    assert found["inertia"] == pytest.approx(joint.inertia, rel=0.05)
    assert found["coulomb"] == pytest.approx(joint.coulomb, rel=0.03)
    assert found["stiction"] == pytest.approx(joint.stiction, rel=0.03)
    assert found["viscous"] == pytest.approx(joint.viscous, rel=0.1)
    assert found["friction_lag"] == 0.0
    assert abs(found["offset"]) < 1.0
    feedback = record.torque - record.feedforward
    early, late = (np.sqrt(np.mean(feedback[part] ** 2)) for part in (slice(0, 5000), slice(-20_000, None)))
    assert late < 0.05 * early


def test_a_mixture_of_lags_stands_for_the_one_in_between():
    """The built-in lag is 20 ms; the features have 8 and 40 ms."""
    mixture = {"lags": [0.5 * RESPONSE, 2.5 * RESPONSE], "period": 0.001, "rate": 0.15 / RESPONSE}
    setup, learning = build_setup(quiet()), with_lags(**mixture)
    drive(learning, setup)
    assert learning.estimates["friction_lag"] == pytest.approx(0.02, rel=0.2)
    rough, _ = drive(with_lags([0.0], period=0.001), setup)
    fine, _ = drive(with_lags(**mixture), setup)
    errors = [np.sqrt(np.mean((setup.reference - record.velocity)[60_000:] ** 2)) for record in (rough, fine)]
    assert errors[1] < 0.5 * errors[0]


@pytest.mark.parametrize("rate", [0.5, 20.0])
@pytest.mark.parametrize("reference", [0.02, -0.3])
def test_learning_hands_over_the_feedback_torque_at_its_rate(rate, reference):
    """From one sample to the next at a constant reference, the inverse model takes over ``1 - exp(-rate dt)`` of it."""
    learning = with_lags([0.0], rate=rate)
    learning.step(reference, reference, next_reference=reference)
    before = learning.state.weights.copy()
    learning.step(reference, 0.8 * reference, next_reference=reference, dt=0.02)
    proportional, integral = GAINS
    feedback = (proportional + integral * 0.02) * 0.2 * reference
    gained = (learning.state.weights - before) @ learning.state.row
    assert gained == pytest.approx(-math.expm1(-rate * 0.02) * feedback, rel=1e-12)


def test_the_feedback_torque_is_laid_to_the_features_of_the_period_that_it_answers_to():
    """The reference reverses between two samples; the error at the second comes from the motion before."""
    learning = with_lags([0.0])
    learning.step(0.1, 0.1, next_reference=0.1)
    learning.step(-0.1, -0.2, next_reference=-0.1)  # positive feedback torque
    assert min(learning.estimates["coulomb"], learning.estimates["stiction"], learning.estimates["viscous"]) > 0.0


@pytest.mark.parametrize(
    "pause",
    [
        {"velocity": math.nan},
        {"reference": 0.0},
        {"realised_torque": 5.0},
    ],
    ids=str,
)
def test_it_pauses_where_the_feedback_torque_is_no_error_of_the_model(pause):
    learning = with_lags([0.0])
    for _ in range(3):
        command = learning.step(0.1, 0.05, next_reference=0.1)
    before = learning.state.weights.copy()
    sample = {"reference": 0.1, "velocity": 0.05, "realised_torque": command, **pause}
    learning.step(**sample)
    assert np.array_equal(learning.state.weights, before)
    learning.step(0.1, 0.05)
    learning.step(0.1, 0.05)
    assert not np.array_equal(learning.state.weights, before)


def test_inertia_stays_within_what_all_controllers_believe():
    learning = with_lags([0.0], rate=1e3)
    for k in range(400):
        learning.step(0.1 + 0.05 * (k % 2), -1.0 if k % 2 else 1.0, next_reference=0.1 + 0.05 * ((k + 1) % 2))
        assert 2.0 <= learning.estimates["inertia"] <= 200.0
    assert learning.estimates["inertia"] in (2.0, 200.0)


@pytest.mark.parametrize(
    "wrong",
    [{"lags": []}, {"lags": [-0.1]}, {"lags": [0.02, 0.01]}],
    ids=str,
)
def test_wrong_values_are_refused_by_name(wrong):
    with pytest.raises(ValueError, match=f"{next(iter(wrong))} = "):
        FeedbackErrorLearning(*GAINS, 0.01, **{**ASSUMED, **wrong})
