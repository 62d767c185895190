"""What feedback-error learning claims, and the choices made here."""

import itertools

import numpy as np
import pytest
from closed_loops import SCENARIO, build_setup, drive
from plan_inputs import plan_inputs

from adaptive_ff.baselines.feedback_learning import FeedbackErrorLearning
from adaptive_ff.friction.feedforward import FeedforwardState, step_feedforward
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
    state, expected = FeedforwardState(), []
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


@pytest.mark.parametrize("wrong", [{"lags": []}, {"lags": [-0.1]}, {"lags": [0.02, 0.01]}], ids=str)
def test_wrong_values_are_refused_by_name(wrong):
    with pytest.raises(ValueError, match=f"{next(iter(wrong))} = "):
        FeedbackErrorLearning(*GAINS, 0.01, **{**ASSUMED, **wrong})
