"""What the PI loop guarantees whatever the feedforward does, as long as the drive does not saturate.

With the error ``e``, the integral ``I`` and the feedforward ``v``, sampled, the loop is linear but for its input:

    e(k+1) = e(k) - T/J (Kp e(k) + I(k) - q(k)),   I(k) = I(k-1) + Ki T e(k) - (change of v by a new estimate)
    q(k) = J (r(k+1) - r(k))/T + f(k) - v(k)

``f`` is the mean friction over the period. So errors at the samples are at most the sum of ``|g(k)|``, the loop's
response to an impulse of ``q``, times the largest ``|q|``, plus the sum of its response to a step times the largest
change of ``v`` by a new estimate in a sample. The sums are computed by ``scipy``.
"""

import math

import numpy as np
import pytest
from closed_loops import SCENARIO
from plan_inputs import plan_inputs
from scipy import signal

from adaptive_ff.friction.feedforward import exchange_model, initial_feedforward_state, step_feedforward
from adaptive_ff.friction.model import TorqueModel
from controllers import PI, hand_over, pi_gains, planned_inputs, step_pi, with_feedforward
from plant import Joint

JOINT = SCENARIO.joint
PERIODS = [0.01, 0.001]


def loop(period):
    """Closed loop from ``q`` to the error: poles and response to an impulse."""
    proportional, integral = pi_gains(JOINT.inertia, 10.0)
    share = period / JOINT.inertia
    dynamics = np.array([[1.0 - share * (proportional + integral * period), -share], [integral * period, 1.0]])
    system = signal.StateSpace(dynamics, [[share], [0.0]], [[1.0, 0.0]], [[0.0]], dt=period)
    (response,) = signal.dimpulse(system, n=round(5.0 / period))[1]
    return np.abs(np.linalg.eigvals(dynamics)), response[:, 0]


def sums(period):
    """Sums of the absolute responses to an impulse and to a step, rad/s per N m."""
    _, impulse = loop(period)
    return float(np.sum(np.abs(impulse))), float(np.sum(np.abs(np.cumsum(impulse))))


@pytest.mark.parametrize(("period", "impulse", "step"), [(0.01, 1.30e-3, 6.33e-3), (0.001, 1.22e-3, 6.33e-2)])
def test_the_sums_are_finite_and_small(period, impulse, step):
    poles, response = loop(period)
    assert np.max(poles) < 1.0
    assert abs(response[-1]) < 1e-12
    assert abs(np.sum(response)) < 1e-12  # the integral takes a constant away, hence the response to a step dies out
    found = sums(period)
    assert found[0] == pytest.approx(impulse, rel=0.01)
    assert found[1] == pytest.approx(step, rel=0.01)


def random_model(rng):
    """Any model that the estimator may hold after torques of up to 100 N m at speeds of up to 0.35 rad/s."""
    coulomb, stiction = rng.uniform(0.0, 200.0, 2)
    return TorqueModel(
        JOINT.inertia * 10.0 ** rng.uniform(-1.0, 1.0),
        coulomb,
        max(coulomb, stiction),
        rng.uniform(0.0, 570.0),
        rng.uniform(0.0, 0.16),
        0.05,
        1.0,
    )


def errors_and_bound(period, seed, hold):
    """Largest error at the samples of 10 s, with a new model every so many samples, and its bound."""
    rng, joint = np.random.default_rng(seed), Joint(JOINT)
    loop_parameters = PI(*pi_gains(JOINT.inertia, 10.0), period)
    pi, state, feedforward = loop_parameters.parameters, loop_parameters.state, initial_feedforward_state()
    steps = round(period / JOINT.solver_period)
    reference = SCENARIO.modified(duration=10.0, seed=seed).reference_velocity()[::steps]
    model, largest_input, largest_change, largest_error = random_model(rng), 0.0, 0.0, 0.0
    for k in range(reference.size - 1):
        now, following = float(reference[k]), float(reference[k + 1])
        if k % hold == hold - 1:
            new = random_model(rng)
            before, _ = step_feedforward(model, feedforward, plan_inputs(now, following), period)
            feedforward = exchange_model(feedforward, model, new, now, feedforward.slip, feedforward.adhesion)
            after, _ = step_feedforward(new, feedforward, plan_inputs(now, following), period)
            state, model = hand_over(pi, state, after - before), new
            largest_change = max(largest_change, abs(after - before))
        torque, feedforward = step_feedforward(model, feedforward, plan_inputs(now, following), period)
        start = joint.state.velocity
        inputs = with_feedforward(planned_inputs(now, start, following, math.nan, period), torque)
        output, state = step_pi(pi, state, inputs)
        joint.step(output.torque, period)
        friction = output.torque - JOINT.inertia * (joint.state.velocity - start) / period
        left = JOINT.inertia * (following - now) / period + friction - torque
        largest_input = max(largest_input, abs(left))
        largest_error = max(largest_error, abs(now - start))
    impulse, step = sums(period)
    return largest_error, impulse * largest_input + step * largest_change


@pytest.mark.parametrize("hold", [10**9, 50, 1], ids=["frozen", "now and then", "every sample"])
@pytest.mark.parametrize("period", PERIODS)
def test_no_model_that_may_be_fed_forward_makes_the_error_larger_than_the_bound(period, hold):
    for seed in range(101, 104):
        error, bound = errors_and_bound(period, seed, hold)
        assert error <= bound
        assert hold != 10**9 or error > 0.1 * bound


def test_any_friction_up_to_stiction_and_viscous_friction_is_held_by_a_small_gain():
    """``|f| <= Fs + sigma |w|``, whatever its dynamics: ``sigma`` times the sum is far below one."""
    assert max(sums(period)[0] for period in PERIODS) * JOINT.viscous < 0.15
