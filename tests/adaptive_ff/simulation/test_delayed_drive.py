"""Drives with a computation delay: every controller knows how long it is."""

import numpy as np
import pytest
from closed_loops import SCENARIO, build_setup
from nightly import sampled
from unequal_joint import EQUAL, Unequal, rms, unequal_loop

from adaptive_ff.adaptive.controller import AdaptiveController
from adaptive_ff.baselines.model_based import ModelBased
from adaptive_ff.baselines.paper import PaperController
from adaptive_ff.friction.model import ESTIMATED, PER_DIRECTION
from controllers import PI, pi_gains

GAINS, PERIOD = pi_gains(20.0, 5.0), SCENARIO.sampling.period
ASSUMED = {"inertia": 20.0, "stribeck_velocity": 0.05}


def adaptive(delay, parameters=ESTIMATED):
    return AdaptiveController(*GAINS, PERIOD, **ASSUMED, parameters=parameters, delay=delay)


def oracle(delay, joint=EQUAL):
    return ModelBased(*GAINS, PERIOD, joint.model, delay=delay)


@pytest.fixture(scope="module")
def setup():
    return build_setup(SCENARIO.modified(seed=103, duration=40.0))


@pytest.fixture(scope="module")
def short_setup():
    return build_setup(SCENARIO.modified(seed=104, duration=5.0))


def error(controller, setup, delay, joint=EQUAL):
    return rms(unequal_loop(controller, setup, joint, delay=delay)[0], 15.0)


def test_feedforward_that_knows_the_delay_is_better_than_one_that_does_not_and_than_none(setup):
    assumed = error(oracle(1.0), setup, 1.0)
    assert assumed < 0.7 * error(oracle(0.0), setup, 1.0)
    assert assumed < 0.15 * error(PI(*GAINS, PERIOD, delay=1.0), setup, 1.0)
    assert assumed < 1.4 * error(oracle(0.0), setup, 0.0)


@pytest.mark.parametrize("delay", sampled((0.5, 1.0, 1.5), (1.5,)))
def test_adaptive_controller_that_knows_the_delay_is_about_as_good_as_the_oracle(setup, delay):
    expected = error(oracle(delay), setup, delay)
    informed = error(adaptive(delay), setup, delay)
    assert informed < 1.15 * expected
    assert error(adaptive(0.0), setup, delay) > 1.15 * informed  # a longer lag makes up for a part of the delay


def test_adaptive_controller_finds_unequal_directions_behind_a_delay():
    """One reference alone says little: the ratio to the oracle is 0.8 to 1.6, by when the joint reverses."""
    joint, ratios, lags, offsets = Unequal(), [], [], []
    for seed in (103, 104, 105, 106):
        setup = build_setup(SCENARIO.modified(seed=seed, duration=40.0))
        controller = adaptive(1.0, PER_DIRECTION)
        ratios.append(error(controller, setup, 1.0, joint) / error(oracle(1.0, joint), setup, 1.0, joint))
        lags.append(controller.estimates["friction_lag"])
        offsets.append(controller.estimates["offset"])
    assert np.exp(np.mean(np.log(ratios))) < 1.15
    assert np.mean(offsets) == pytest.approx(joint.model.offset, abs=2.0)
    assert np.mean(lags) == pytest.approx(0.02, abs=0.005)


MAKERS = {
    "PI": lambda delay: PI(*GAINS, PERIOD, delay=delay),
    "ModelBased": oracle,
    "PaperController": lambda delay: PaperController(*GAINS, PERIOD, **ASSUMED, delay=delay),
    "AdaptiveController": adaptive,
}
controllers = pytest.mark.parametrize("make", MAKERS.values(), ids=MAKERS)


@controllers
@pytest.mark.parametrize("delay", [0.0, 1.0, 1.5])
def test_torque_that_is_not_told_is_taken_as_what_was_asked_for_in_that_period(make, delay, short_setup):
    _, assumed = unequal_loop(make(delay), short_setup, delay=delay, limit=np.inf)
    _, untold = unequal_loop(make(delay), short_setup, delay=delay, limit=np.inf, tell=False)
    assert untold == pytest.approx(assumed, abs=1e-3)  # rounding, amplified by a large covariance at the start


@controllers
@pytest.mark.parametrize("delay", [0.0, 1.0, 1.5])
def test_load_that_is_told_for_when_the_drive_acts_changes_no_motion(make, delay, short_setup):
    load = 30.0 * np.sin(0.05 * np.arange(short_setup.noise.size))
    free, free_torques = unequal_loop(make(delay), short_setup, delay=delay, limit=np.inf)
    loaded, torques = unequal_loop(make(delay), short_setup, delay=delay, limit=np.inf, known=load)
    assert loaded == pytest.approx(free, abs=1e-6)
    assert torques - load == pytest.approx(free_torques, abs=1e-2)


@controllers
def test_compiled_equals_plain_and_a_saved_state_goes_on(make, short_setup):
    _, expected = unequal_loop(make(1.5).run_uncompiled(), short_setup, delay=1.5)
    controller = make(1.5)
    _, found = unequal_loop(controller, short_setup, delay=1.5)
    assert found == pytest.approx(expected, rel=1e-12)
    other = make(1.5)
    other.state_from_json(controller.state_to_json())
    assert other.step(0.1, 0.09, realised_torque=50.0) == controller.step(0.1, 0.09, realised_torque=50.0)


class Twins:
    """A controller that learns, and one that does not beside it, until the first sample that is learnt from."""

    def __init__(self, delay):
        self.learning, self.frozen = adaptive(delay), adaptive(delay)
        self.frozen.enabled = False
        self.torques = None

    def step(self, *motion, **others):
        torques = [controller.step(*motion, **others) for controller in (self.learning, self.frozen)]
        if self.torques is None and self.learning.estimates["coulomb"] > 10.0:
            self.torques = torques
        return torques[0]


@pytest.mark.parametrize("delay", sampled((1.0, 1.5), (1.5,)))
def test_learning_does_not_make_the_torque_jump_behind_a_delay(delay, short_setup):
    twins = Twins(delay)
    unequal_loop(twins, short_setup, delay=delay)
    assert twins.torques[0] == pytest.approx(twins.torques[1], abs=1.0)
    assert abs(twins.torques[0]) > 10.0
