"""What is bounded in the adaptive controller whatever it is fed: estimates, information, feedforward and its lag.

The inputs are adversarial: references, measurements and torques without any relation to a joint.
"""

import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from adaptive_ff.adaptive.controller import UnsupervisedController
from adaptive_ff.adaptive.learning.estimator import FLOOR, PEAK_FACTOR, SMALLEST_FLOOR
from adaptive_ff.estimation.resetting import initial_resetting_state, update_resetting_in_place
from adaptive_ff.friction.bounds import INERTIA_RANGE, largest_lag
from adaptive_ff.friction.model import ESTIMATED, PER_DIRECTION
from controllers import pi_gains

INERTIA, LIMIT, FASTEST = 20.0, 400.0, 0.5
GAINS = pi_gains(INERTIA, 10.0)
RESPONSE = INERTIA / GAINS[0]

PARTS = st.lists(
    st.tuples(
        st.integers(1, 120),  # samples
        st.floats(-FASTEST, FASTEST),  # reference at the end of the part
        st.sampled_from(["follows", "flipped", "stuck", "noisy", "wild", "lost"]),
        st.sampled_from(["given", "saturated", "flipped", "random", "unknown"]),
        st.sampled_from([0.0, 0.002, 1.0]),
    ),
    min_size=1,
    max_size=12,
)


def measured_velocity(kind, reference, spread, rng):
    return {
        "follows": reference + spread * rng.standard_normal(),
        "flipped": -reference,
        "stuck": 0.0,
        "noisy": reference * (1.0 + spread * rng.standard_normal()),
        "wild": float(rng.choice([1e12, -1e6, 30.0, -3.0, 0.0, reference])),
        "lost": float(rng.choice([math.nan, math.inf, -math.inf])),
    }[kind]


def drive_torque(kind, command, rng):
    given = min(max(command, -LIMIT), LIMIT)
    return {
        "given": given,
        "saturated": math.copysign(LIMIT, command),
        "flipped": -given,
        "random": float(rng.uniform(-LIMIT, LIMIT)),
        "unknown": None,
    }[kind]


def feed(controller, parts, seed, watch):
    """Feed a controller; ``watch(reference, following)`` is called after each sample."""
    rng, reference, torque = np.random.default_rng(seed), 0.0, 0.0
    for samples, target, velocity, drive, spread in parts:
        for following in np.linspace(reference, target, samples + 1)[1:]:
            measured = measured_velocity(velocity, reference, spread, rng)
            realised = drive_torque(drive, torque, rng)
            if realised is None and abs(torque) > LIMIT:
                realised = math.copysign(
                    LIMIT, torque
                )  # a drive that tells nothing must at least not be asked for more
            torque = controller.step(reference, measured, next_reference=following, realised_torque=realised)
            assert math.isfinite(torque)
            watch(reference, following)
            reference = float(following)


def make(parameters, period):
    return UnsupervisedController(
        *GAINS, period=period, inertia=INERTIA, stribeck_velocity=0.05, parameters=parameters, memory=4.0
    )


class Watch:
    """Checks estimates, information and feedforward after every sample against the bounds that the README states."""

    def __init__(self, controller):
        self.controller = controller
        self.friction, self.fastest, self.speed, self.learnt = 0.0, 0.0, 0.0, 0.0

    def __call__(self, reference, following):
        state = self.controller.state  # a copy, so read once
        self.check_estimates(state.estimator)
        self.check_timing(state.timing)
        self.check_feedforward(state.model_torques[0], reference, following)

    def check_estimates(self, state):
        _, peak, speed, learnt, _ = state.levels
        if learnt > self.learnt:  # otherwise the largest speed may grow without the estimates
            self.learnt, self.speed = learnt, speed
        assert peak <= LIMIT * (1.0 + 1e-12)
        torque = PEAK_FACTOR * peak * (1.0 + 1e-9)
        inertia, coulomb, stiction, viscous, lag, *one_sided = state.recursion.estimate
        assert INERTIA / INERTIA_RANGE <= inertia <= INERTIA * INERTIA_RANGE
        assert 0.0 <= coulomb <= torque
        assert 0.0 <= stiction <= torque
        assert 0.0 <= lag <= largest_lag(RESPONSE) * (1.0 + 1e-12)
        assert 0.0 <= viscous * self.speed <= torque
        for value, unit in zip(one_sided, (1.0, 1.0, self.speed), strict=False):
            assert abs(value) * unit <= torque
        information = state.recursion.information
        assert np.array_equal(information, information.T)
        assert np.linalg.eigvalsh(information)[0] >= SMALLEST_FLOOR * 0.5 - 1e-13 * np.max(information)

    def check_timing(self, timing):
        assert 0.0 <= timing.lag <= largest_lag(RESPONSE)
        assert np.all(np.isfinite(timing.evidence))
        assert math.isfinite(timing.slope)

    def check_feedforward(self, model_torque, reference, following):
        """The friction map is bounded; its lag keeps what changes of the estimates left for some time constants."""
        controller = self.controller
        estimates = controller.estimates
        self.fastest = max(self.fastest, abs(reference), abs(following))
        static = estimates["stiction"] + estimates["viscous"] * self.fastest
        if "offset" in estimates:
            static *= 2.0  # what differs by direction is at most as large in the model
        self.friction = max(self.friction, static)
        kept = math.exp(-controller.period / (largest_lag(RESPONSE)))
        bound = INERTIA * INERTIA_RANGE * abs(following - reference) / controller.period
        bound += self.friction * (1.0 + 2.0 / (1.0 - kept)) + abs(estimates.get("offset", 0.0))
        assert abs(model_torque) <= bound * (1.0 + 1e-9) + 1e-9


@pytest.mark.parametrize("parameters", [ESTIMATED, PER_DIRECTION], ids=["symmetric", "per direction"])
@pytest.mark.parametrize("period", [0.01, 0.001])
@settings(max_examples=25)
@example(
    [(100, 0.3, "follows", "given", 0.0), (30, 0.2, "wild", "random", 1.0), (100, -0.3, "follows", "given", 0.0)], 0
)
@given(parts=PARTS, seed=st.integers(0, 10**6))
def test_whatever_it_is_fed_estimates_and_feedforward_stay_within_their_bounds(parameters, period, parts, seed):
    controller = make(parameters, period)
    feed(controller, parts, seed, Watch(controller))


def test_the_inputs_are_wild_enough_to_reach_bounds_and_tame_enough_to_be_learnt_from():
    """Else the test above would show nothing."""
    learnt, at_bound, tuned = 0, 0, 0
    for seed in range(20):
        rng = np.random.default_rng(seed)
        kinds = [(60, rng.uniform(-1.0, 1.0), "noisy", str(rng.choice(["random", "flipped"])), 1.0) for _ in range(10)]
        controller = make(ESTIMATED, 0.01)
        feed(controller, kinds, seed, Watch(controller))
        state = controller.state.estimator
        learnt += state.levels.learnt > 0.5
        at_bound += any(
            value in (0.0, INERTIA * INERTIA_RANGE, INERTIA / INERTIA_RANGE) for value in state.recursion.estimate
        )
        tuned += bool(np.any(controller.state.timing.evidence))
    assert learnt > 10
    assert at_bound > 5
    assert tuned > 5


@settings(max_examples=100)
@given(
    direction=st.lists(st.floats(-1e4, 1e4), min_size=5, max_size=5),
    period=st.sampled_from([0.001, 0.01]),
    usual=st.floats(1e-3, 0.07),
)
def test_an_error_of_the_usual_size_moves_the_estimates_little_in_a_sample(direction, period, usual):
    """At most ``sqrt(period / memory / FLOOR) / 2`` of their units with the information at its floor, less above."""
    keep = math.exp(-period / 4.0)
    floor = FLOOR * usual * usual
    state = initial_resetting_state(np.zeros(5), floor * np.eye(5))
    state.instrument[:] = direction
    update_resetting_in_place(state, floor, keep, usual)
    assert np.linalg.norm(state.gain) <= 0.5 * math.sqrt(period / 4.0 / FLOOR) * 1.001
