import math
from unittest.mock import patch

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from stepped_joint import mirrored, motion, run

from plant import JointParameters, JointState, Stribeck, initial_state, sliding, sliding_friction, step_joint
from plant.friction import sliding_friction_and_slope
from plant.joint import check_unique_step

STRIBECK = Stribeck(60.0, 90.0, 80.0, 0.05, 1.0)
COULOMB = Stribeck(60.0, 60.0, 0.0, 0.05, 1.0)
REST = JointState(0.0, 0.0, 0.0)
SHAPES = (0.7, 1.0, 1.5, 2.0, 3.0)


def symmetric(friction, lag):
    return JointParameters(20.0, friction, friction, 0.0, lag)


PROMPT = symmetric(STRIBECK, 0.0)


def constant(torque, duration, period):
    return np.full(round(duration / period), torque)


def exact_motion(joint, begin, torque, duration):
    """Velocity after a constant torque, from event to event."""
    end = np.array([duration])
    return motion(joint, lambda time: torque, lambda time: 0.0, duration, end, *begin[:2])[0]


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_coulomb_stop_time_and_distance_in_closed_form(direction):
    joint, period = symmetric(COULOMB, 0.0), 1e-3
    motion = run(joint, initial_state(joint, 0.3001 * direction), np.zeros(1000), period)[:, 0] * direction
    deceleration = 60.0 / 20.0
    sliding = 101  # the last step before J w0/Fc = 0.10003 s, and the step in which it stops
    expected = 0.3001 - deceleration * period * np.arange(sliding)
    assert motion[:sliding] == pytest.approx(expected, abs=1e-13)
    assert np.all(motion[sliding:] == 0.0)
    distance = period * (np.sum(motion) - 0.5 * motion[0])
    assert distance == pytest.approx(0.3001**2 / (2.0 * deceleration), rel=1e-5)


def test_viscous_decay_is_that_of_the_implicit_euler_method():
    joint = symmetric(Stribeck(0.0, 0.0, 80.0, 0.05, 1.0), 0.0)
    motion = run(joint, initial_state(joint, 0.3), np.zeros(2000), 1e-3)
    decay = (1.0 + 1e-3 * 80.0 / 20.0) ** -np.arange(2001.0)
    assert motion[:, 0] == pytest.approx(0.3 * decay, rel=1e-11)


def test_lagged_friction_approaches_the_coulomb_level_in_closed_form_with_first_order():
    joint, torque, duration = symmetric(COULOMB, 0.02), 70.0, 0.05
    errors = []
    for period in (1e-3, 5e-4, 2.5e-4):
        motion = run(joint, JointState(0.3, 0.0, 0.0), constant(torque, duration, period), period)
        discrete = 60.0 * (1.0 - (0.02 / (0.02 + period)) ** np.arange(len(motion)))
        assert motion[:, 1] == pytest.approx(discrete, abs=1e-9)
        loss = 60.0 * (duration - 0.02 * (1.0 - math.exp(-duration / 0.02)))
        errors.append(motion[-1, 0] - (0.3 + (torque * duration - loss) / 20.0))
    assert abs(errors[0]) < 2e-3
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.05)
    assert errors[1] / errors[2] == pytest.approx(2.0, rel=0.03)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("lag", [0.0, 0.02])
@pytest.mark.parametrize(("start", "torque"), [(0.02, 95.0), (0.3, 75.0)], ids=["speeding up", "slowing down"])
def test_sliding_motion_converges_to_that_of_solve_ivp_with_first_order(shape, lag, start, torque):
    joint = symmetric(STRIBECK._replace(stribeck_shape=shape), lag)
    begin = initial_state(joint, start)
    exact = exact_motion(joint, begin, torque, 0.3)
    errors = [run(joint, begin, constant(torque, 0.3, h), h)[-1, 0] - exact for h in (2e-4, 1e-4)]
    assert abs(errors[1]) < 5e-5
    assert math.log2(errors[0] / errors[1]) == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("lag", [0.0, 0.02])
@pytest.mark.parametrize("period", [1e-3, 1e-4, 1e-5])
def test_reversal_follows_solve_ivp_within_the_friction_jump_of_one_step(shape, lag, period):
    joint = symmetric(STRIBECK._replace(stribeck_shape=shape), lag)
    begin = initial_state(joint, 0.2)
    exact = exact_motion(joint, begin, -150.0, 0.2)
    assert exact < -0.5
    velocity = run(joint, begin, constant(-150.0, 0.2, period), period)[-1, 0]
    assert velocity == pytest.approx(exact, abs=2.0 * 90.0 * period / 20.0)


def test_plan_of_reversal_stop_rest_and_breakaway_follows_solve_ivp():
    velocity, period = 0.2, 1e-5
    state = initial_state(PROMPT, velocity)
    for torque, duration in [(-150.0, 0.2), (0.0, 0.5), (85.0, 0.2), (120.0, 0.3)]:
        velocity = exact_motion(PROMPT, (velocity, 0.0), torque, duration)
        state = JointState(*run(PROMPT, state, constant(torque, duration, period), period)[-1])
        assert state.velocity == pytest.approx(velocity, abs=2.0 * 90.0 * period / 20.0)
        assert (state.velocity == 0.0) == (velocity == 0.0) == (torque in (0.0, 85.0))


@pytest.mark.parametrize("torque", [0.0, 89.9999, -89.9999])
def test_joint_rests_exactly_for_an_hour_below_breakaway(torque):
    assert not np.any(run(PROMPT, REST, np.full(3_600_000, torque), 1e-3)[:, 0])


@st.composite
def frictions(draw):
    coulomb = draw(st.just(0.0) | st.floats(1e-3, 100.0))
    stiction = coulomb + draw(st.just(0.0) | st.floats(1e-3, 50.0))
    shape = draw(st.sampled_from(SHAPES))
    return Stribeck(coulomb, stiction, draw(st.floats(0.0, 100.0)), draw(st.floats(0.01, 0.5)), shape)


@st.composite
def unique_steps(draw, lags):
    """A joint, a state, a torque and a period that pass the check of uniqueness."""
    offset = draw(st.just(0.0) | st.floats(-50.0, 50.0))
    joint = JointParameters(draw(st.floats(0.5, 100.0)), draw(frictions()), draw(frictions()), offset, draw(lags))
    period = draw(st.floats(1e-4, 2e-3))
    while True:
        try:
            check_unique_step(joint, period)
            break
        except ValueError:
            period *= 0.5
    state = JointState(
        draw(st.floats(-2.0, 2.0) | st.just(0.0)), draw(st.floats(-200.0, 200.0)), draw(st.floats(-9.0, 9.0))
    )
    return joint, state, draw(st.floats(-300.0, 300.0)), period


def assert_solves_the_implicit_equations(joint, state, torque, period):
    after = step_joint(joint, state, torque, period)
    lag, inertia = joint.friction_lag, joint.inertia
    size = abs(state.velocity) + period / inertia * (abs(torque) + abs(joint.offset) + abs(state.friction_torque) + 1.0)
    euler = state.velocity + period / inertia * (torque - joint.offset - after.friction_torque)
    assert after.velocity == pytest.approx(euler, abs=1e-12 * size)
    static = after.friction_torque + lag * (after.friction_torque - state.friction_torque) / period  # (1)
    weight = period * period / (inertia * (lag + period))  # of F in the new velocity
    if after.velocity == 0.0:
        stiction = (joint.friction if static > 0.0 else joint.backward).stiction
        assert weight * abs(static) <= weight * stiction + 1e-12 * size
    else:
        friction = joint.friction if after.velocity > 0.0 else joint.backward
        expected = math.copysign(sliding_friction(friction, abs(after.velocity)), after.velocity)
        assert weight * static == pytest.approx(weight * expected, abs=1e-11 * size)
    assert after.position == state.position + period * after.velocity


@settings(max_examples=150)
@given(unique_steps(st.just(0.0) | st.floats(1e-4, 0.1)))
def test_step_solves_the_implicit_equations_and_is_odd(case):
    joint, state, torque, period = case
    assert_solves_the_implicit_equations(joint, state, torque, period)
    assert mirrored(step_joint, joint, state, torque, period) == step_joint(joint, state, torque, period)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("lag", [0.0, 0.02])
@pytest.mark.parametrize("excess", [1e-9, 1e-7, 1e-5, 1e-3, 0.1, 10.0])
def test_step_solves_the_implicit_equations_just_above_breakaway(shape, lag, excess):
    joint = symmetric(STRIBECK._replace(stribeck_shape=shape), lag)
    check_unique_step(joint, 1e-4)
    # from rest under u, with f = u, breakaway is at u = Fs
    assert_solves_the_implicit_equations(joint, JointState(0.0, 90.0, 0.0), 90.0 * (1.0 + excess), 1e-4)


def test_speed_of_sliding_solves_its_equation_to_the_last_digits():
    """With one exponential: the residual of ``w + kappa F(w) = free speed``, in more digits."""
    generator, most = np.random.default_rng(1), 0.0
    for coulomb, excess, kappa, velocity, start, near in 10.0 ** generator.uniform(
        [0.8, -2.0, -6.0, -2.5, -2.0, -5.0], [2.8, 0.0, -4.0, 0.0, 1.3, -1.0], (3000, 6)
    ):
        curve = Stribeck(coulomb, (1.0 + excess) * coulomb, 80.0, velocity, 1.0)
        one, speed = sliding.direction_of(curve, kappa), start * velocity
        free = one.linear * speed + one.coulomb + one.excess * math.exp(-start)
        if one.linear < one.excess / velocity + 0.05 or free <= one.breakaway:
            continue  # it has more than one solution, or rests
        friction = (free - speed * (1.0 + near * generator.standard_normal())) / kappa
        found = np.longdouble(sliding.speed_in_direction(one, free, friction))
        left = one.linear * found + one.coulomb + one.excess * np.exp(-found * one.per_velocity) - free
        most = max(most, abs(float(left)) / free)
    assert most < 3.0 * np.finfo(float).eps


@settings(max_examples=150)
@given(unique_steps(st.just(0.0)))
@example((PROMPT, JointState(1e-9, 0.0, 0.0), 0.0, 1e-3))
def test_friction_without_lag_dissipates_and_energy_does_not_grow_without_torque(case):
    joint, state, torque, period = case
    after = step_joint(joint, state, torque, period)
    assert after.friction_torque * after.velocity >= 0.0
    coasting = step_joint(joint, state, joint.offset, period)
    assert abs(coasting.velocity) <= abs(state.velocity)
    assert coasting.velocity * state.velocity >= 0.0


@pytest.mark.parametrize("lag", [0.0, 0.02])
@pytest.mark.parametrize("shape", [1.0, 1.5])
def test_newton_needs_few_steps(shape, lag):
    """With a wrong slope or bracket the root is still found, by bisection, which takes some forty."""
    joint = symmetric(STRIBECK._replace(stribeck_shape=shape), lag)
    state, counts = initial_state(joint, 0.1), []

    def counted(*arguments):
        counts[-1] += 1
        return sliding_friction_and_slope(*arguments)

    with patch.object(sliding, "sliding_friction_and_slope", counted):
        for torque in 120.0 * np.sin(0.02 * np.arange(600)):
            counts.append(0)
            state = step_joint(joint, state, torque, 1e-3)
    used = np.array([count for count in counts if count])
    if shape == 1.0:  # one exponential does, but at reversals
        assert used.size < 30
        return
    assert used.size > 400
    assert np.mean(used) < 3.5
    assert np.max(used) < 12
