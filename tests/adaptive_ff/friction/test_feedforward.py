"""Torque along a reference: behind a lag in time, and behind one over the path."""

import functools
import itertools
import math

import numpy as np
import pytest
from closed_loops import SCENARIO, drive, make, plan_inputs, setup_along
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from adaptive_ff.friction import feedforward
from adaptive_ff.friction.feedforward import TURNED, FeedforwardState, friction_along, step_feedforward, turning_speed
from adaptive_ff.friction.model import TorqueModel, directed_friction, model_friction, stribeck_power
from adaptive_ff.scenario.truth import true_model
from plant import Stribeck, sliding_friction

MODEL = true_model(SCENARIO)
COULOMB_VISCOUS = MODEL._replace(stiction=MODEL.coulomb)
PERIOD = 0.01


def test_power_of_the_fastest_speeds_stays_finite():
    assert [stribeck_power(1e9, 1e-3, shape) for shape in (0.7, 1.0, 2.0)] == [1e4] * 3
    assert [stribeck_power(0.5, 1.0, shape) for shape in (1.0, 2.0, 4.0)] == [0.5, 0.25, 0.0625]


def static_friction(model, velocity, direction):
    return math.copysign(model_friction(model, abs(velocity)), direction)


def pieces(start, end):
    """Parts of a period between reversals: share of the period, velocity at its ends."""
    if start * end < 0.0:
        turn = start / (start - end)
        return [(turn, start, 0.0), (1.0 - turn, 0.0, end)]
    return [(1.0, start, end)]


def torque_by_runge_kutta(model, friction, start, end, between):
    """Mean torque with the lagged friction over a period, and that at the end; ``between`` gives F within a part."""
    total = 0.0
    for share, first, last in pieces(start, end):
        duration = share * PERIOD

        def slope(t, y, first=first, last=last, duration=duration):
            return [y[1], (between(model, first, last, t / duration) - y[1]) / model.friction_lag]

        path = solve_ivp(slope, (0.0, duration), [0.0, friction], rtol=1e-11, atol=1e-12, max_step=duration / 20.0)
        total, friction = total + path.y[0, -1], path.y[1, -1]
    return (model.inertia * (end - start) + total) / PERIOD, friction


def true_between_the_ends(model, first, last, share):
    return static_friction(model, first + share * (last - first), first + last)


PIECES = [(0.1, 0.13), (-0.2, -0.19), (0.02, -0.03), (-0.004, 0.05), (0.0, 0.02), (0.02, 0.0), (0.1, 0.1)]


def test_stribeck_friction_is_integrated_with_second_order_in_the_change_of_the_reference():
    errors = []
    for change in (0.02, 0.01, 0.005):
        exact, _ = torque_by_runge_kutta(MODEL, 80.0, 0.02, 0.02 + change, true_between_the_ends)
        torque, _ = step_feedforward(MODEL, FeedforwardState(80.0, 0.0, True), plan_inputs(0.02, 0.02 + change), PERIOD)
        errors.append(torque - exact)
    assert 0.0 < errors[0] < 0.1  # of some 100 N m; the chord lies above the convex curve
    assert math.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.3)
    assert math.log2(errors[1] / errors[2]) == pytest.approx(2.0, abs=0.2)


@pytest.mark.parametrize("lag", [0.0, 0.02])
@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_at_rest_a_share_of_coulomb_friction_is_held_and_the_rest_fades(lag, direction):
    model = MODEL._replace(friction_lag=lag)
    held = feedforward.HELD * model.coulomb
    assert step_feedforward(model, FeedforwardState(), plan_inputs(0.0, 0.0), PERIOD) == (
        0.0,
        (0.0, 0.0, True, 0.0, 0.0),
    )
    begin = FeedforwardState(direction * (held + 12.0), 0.0, True)
    torque, state = step_feedforward(model, begin, plan_inputs(0.0, 0.0), PERIOD)
    decay = math.exp(-PERIOD / lag) if lag else 0.0
    fading = held * PERIOD / feedforward.FADING  # over a period, to first order
    assert direction * state.friction == pytest.approx(held + 12.0 * decay, abs=1.1 * fading)
    assert direction * torque == pytest.approx(held + 12.0 * lag * (1.0 - decay) / PERIOD, abs=0.6 * fading)
    assert abs(torque) < held + 12.0 * lag * (1.0 - decay) / PERIOD
    for _ in range(round(3.0 * feedforward.FADING / PERIOD)):
        torque, state = step_feedforward(model, state, plan_inputs(0.0, 0.0), PERIOD)
    assert direction * torque == pytest.approx(held * math.exp(-3.0), rel=0.15)
    little, _ = step_feedforward(model, FeedforwardState(direction * 5.0, 0.0, True), plan_inputs(0.0, 0.0), PERIOD)
    assert direction * little == pytest.approx(5.0, rel=0.02)  # no more than there was


def test_at_rest_bent_bristles_hold_all_friction_for_longer():
    """Bristles that stay bent carry the torque, stiction among it, and the lag in time has no part in it."""
    model = MODEL._replace(presliding=0.01, friction_lag=0.02)
    begin = model.coulomb + 12.0
    state = FeedforwardState(begin, 0.0, True, 1.0, 1.0)
    for _ in range(round(feedforward.BENT_FADING / PERIOD)):
        torque, state = step_feedforward(model, state, plan_inputs(0.0, 0.0), PERIOD)
    assert state.friction == pytest.approx(begin * math.exp(-1.0), rel=1e-6)
    assert torque == pytest.approx(state.friction, rel=PERIOD / feedforward.BENT_FADING)


@pytest.mark.parametrize(("presliding", "kept"), [(0.0, 0.25 * feedforward.HELD * 60.0), (0.01, 0.25 * 90.0)])
@pytest.mark.parametrize("lag", [0.0, 0.02])
@pytest.mark.parametrize("friction", [-70.0, -5.0, 5.0, 70.0])
def test_a_creeping_joint_releases_what_is_beyond_its_fraction(friction, lag, presliding, kept):
    model = MODEL._replace(coulomb=60.0, stiction=90.0, friction_lag=lag, presliding=presliding)
    state = FeedforwardState(friction, 0.1, True, 0.3, 0.4)
    assert feedforward.released(model, state, 1.0, PERIOD) == state
    left = min(abs(friction), kept) + max(abs(friction) - kept, 0.0) * (math.exp(-PERIOD / lag) if lag else 0.0)
    expected = state._replace(friction=math.copysign(left, friction))
    assert feedforward.released(model, state, 0.25, PERIOD) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(("start", "end"), [(0.01, 0.019), (0.019, 0.01), (0.01, 0.03), (0.03, 0.01), (0.02, 0.01)])
def test_friction_of_the_other_direction_is_held_below_the_turning_speed(start, end, sign):
    """At both ends; of the same direction it is not held, nor by bent bristles."""
    assert turning_speed(MODEL._replace(coulomb=60.0, stiction=90.0), 20.0, 0.01) == pytest.approx(TURNED * 0.045)
    for model, friction in ((MODEL, -50.0), (MODEL, 50.0), (MODEL, 0.0), (MODEL._replace(presliding=0.01), -50.0)):
        part = (model, sign * friction, 0.0, 0.0, sign * start, sign * end, PERIOD)
        at_rest = (*feedforward.resting_friction(model, sign * friction, PERIOD), 0.0, 0.0)
        held = model is MODEL and friction < 0.0 and max(start, end) < 0.02
        assert friction_along(*part, 0.02) == (at_rest if held else friction_along(*part))
        assert friction_along(*part) != at_rest


@pytest.mark.parametrize("delay", [0.5, 1.0, 2.3])
@pytest.mark.parametrize("preview", [True, False])
def test_delayed_torque_along_a_ramp_is_the_torque_of_that_much_later(delay, preview):
    """Along a straight line, through the reversal, continuing the slope is exact."""

    def ramp(sample):
        return 0.05 - 0.004 * sample

    early, late = (FeedforwardState(90.0, ramp(-1.0), True) for _ in range(2))
    for k in range(40):
        following = ramp(k + 1.0) if preview else math.nan
        acting = plan_inputs(ramp(k), 9.0, ramp(k + delay), ramp(k + 1.0 + delay))
        told, _ = step_feedforward(UNEQUAL, early, acting, PERIOD, delay)
        found, early = step_feedforward(UNEQUAL, early, plan_inputs(ramp(k), following), PERIOD, delay)
        assert told == pytest.approx(found, rel=1e-9)
        expected, late = step_feedforward(UNEQUAL, late, plan_inputs(ramp(k + delay), ramp(k + 1.0 + delay)), PERIOD)
        assert found == pytest.approx(expected, rel=1e-9)
        assert early.friction == pytest.approx(late.friction, rel=1e-9)
        assert early.reference == ramp(k)


frictions = st.builds(
    lambda coulomb, excess, viscous, velocity, shape: Stribeck(coulomb, coulomb + excess, viscous, velocity, shape),
    st.floats(0.0, 200.0),
    st.floats(0.0, 200.0),
    st.floats(0.0, 500.0),
    st.floats(1e-3, 1.0),
    st.sampled_from([1.0, 2.0]) | st.floats(0.3, 3.0),
)


@settings(max_examples=100)
@given(frictions, st.just(0.0) | st.floats(1e-9, 5.0))
def test_friction_of_the_model_is_that_of_the_plant(friction, speed):
    hypothesis = TorqueModel(20.0, *friction[:3], 0.02, *friction[3:])
    truth = sliding_friction(friction, speed)
    assert model_friction(hypothesis, speed) == pytest.approx(truth, rel=1e-12, abs=1e-12)


FORWARD = MODEL._replace(coulomb=70.0, stiction=105.0, viscous=95.0)
BACKWARD = MODEL._replace(coulomb=50.0, stiction=60.0, viscous=60.0)
LOAD = -25.0
ENDS = {"": FORWARD, "_backward": BACKWARD}
SIDES = {f"{name}{end}": getattr(one, name) for end, one in ENDS.items() for name in MODEL._fields[1:4]}
UNEQUAL = true_model(SCENARIO.modified(joint={"offset": LOAD, **SIDES}))


def unequal_friction(velocity, direction):
    """The paper's curve for each direction by itself, and the load."""
    return static_friction(FORWARD if direction > 0.0 else BACKWARD, velocity, direction) + LOAD


@pytest.mark.parametrize("speed", [0.0, 1e-4, 0.03, 0.4])
def test_true_model_of_a_joint_has_the_friction_of_each_direction(speed):
    for direction in (1.0, -1.0):
        found = directed_friction(UNEQUAL, speed, direction) + UNEQUAL.offset
        assert found == pytest.approx(unequal_friction(speed, direction), rel=1e-12)
    mean = 0.5 * (model_friction(FORWARD, speed) + model_friction(BACKWARD, speed))
    assert model_friction(UNEQUAL, speed) == pytest.approx(mean, rel=1e-12)


def test_coulomb_friction_that_differs_by_direction_is_an_offset_of_the_model():
    assert UNEQUAL.offset == LOAD + 10.0
    same = {f"{name}_backward": getattr(MODEL, name) for name in MODEL._fields[1:4]}
    assert true_model(SCENARIO.modified(joint=same)) == MODEL


CURVES = [(model, functools.partial(static_friction, model)) for model in (MODEL, COULOMB_VISCOUS)]


@pytest.mark.parametrize(("start", "end"), PIECES)
@pytest.mark.parametrize("friction", [0.0, 70.0, -120.0])
@pytest.mark.parametrize(("model", "curve"), [*CURVES, (UNEQUAL, unequal_friction)])
def test_mean_torque_is_the_integral_of_the_lagged_friction_with_and_without_reversal(
    start, end, friction, model, curve
):
    """Oracle: both directions and the load in one static curve, which the lag follows, integrated numerically.

    The curve is taken as linear between reversals, as it is without a Stribeck peak.
    """

    def between(_, first, last, share):
        return (1.0 - share) * curve(first, first + last) + share * curve(last, first + last)

    expected = torque_by_runge_kutta(MODEL, friction, start, end, between)
    state = FeedforwardState(friction - model.offset, 0.0, True)
    torque, state = step_feedforward(model, state, plan_inputs(start, end), PERIOD)
    assert (torque, state.friction + model.offset) == pytest.approx(expected, rel=1e-8)
    assert state.reference == start


def tracking_error(name, solver_period, substeps, **joint):
    """Root of the mean square of the error along a motion with reversals, without noise."""
    sampling = {"period": substeps * solver_period}
    scenario = SCENARIO.modified(joint={"solver_period": solver_period, **joint}, sampling=sampling)
    time = solver_period * np.arange(round(10.0 / solver_period) + 1)
    reference = 0.2 * np.sin(2.0 * np.pi * 0.3 * time) + 0.1 * np.sin(2.0 * np.pi * 0.8 * time)
    reference *= 1.0 - np.exp(-((time / 0.5) ** 3))  # from rest
    setup = setup_along(reference, joint=scenario.joint, substeps=substeps)
    record, _ = drive(make(name, scenario), setup)
    return float(np.sqrt(np.mean((record.velocity - reference) ** 2)))


def test_true_parameters_fed_forward_leave_an_error_that_vanishes_with_the_period():
    errors = [tracking_error("oracle", period, 4) for period in (1e-3, 5e-4, 2.5e-4)]
    assert errors[0] > 1.2 * errors[1] > 1.2**2 * errors[2]
    assert errors[2] < 0.15e-3
    assert errors[2] < 0.01 * tracking_error("pi", 2.5e-4, 4)
    assert errors[2] < 0.03 * tracking_error("fixed", 2.5e-4, 4)


PERIODS, PRESLIDING, STRIBECK = 0.01, 3e-3, 0.05
PRESLIDING = TorqueModel(2.0, 20.0, 30.0, 8.0, 0.004, STRIBECK, 1.0, 1.5, 4.0, 2.0, PRESLIDING, micro_damping=6.0)
PLAN = 0.12 * np.sin(2.0 * math.pi * 0.9 * PERIODS * np.arange(180)) + 0.05 * np.sin(
    2.0 * math.pi * 2.3 * PERIODS * np.arange(180)
)


def static(model, slip, adhesion, velocity, direction):
    ratio = velocity / model.stribeck_velocity
    damping = model.micro_damping * math.exp(-(ratio**2)) * abs(ratio) * (direction - slip - adhesion)
    one_sided = model.stiction_asymmetry * math.exp(-abs(ratio)) + model.viscous_asymmetry * abs(velocity)
    return model.coulomb * slip + model.stiction * adhesion + model.viscous * velocity + damping + one_sided


def by_scipy(model, state, start, end):
    """Integral of the friction over a period from a velocity to another, and the state at its end."""
    turns = [0.0, start / (start - end), 1.0] if start * end < 0.0 else [0.0, 1.0]
    values = [0.0, *state]
    for first, last in itertools.pairwise(turns):
        way = math.copysign(1.0, start + (end - start) * 0.5 * (first + last))

        def slope(t, y, direction=way):
            velocity = start + (end - start) * t / PERIODS
            share = math.exp(-abs(velocity) / model.stribeck_velocity)
            friction = static(model, y[2], y[3], velocity, direction)
            rate = abs(velocity) / model.presliding
            slips = rate * (direction * (1.0 - share) - y[2])
            return [y[1], (friction - y[1]) / model.friction_lag, slips, rate * (direction * share - y[3])]

        part = (first * PERIODS, last * PERIODS)
        values = solve_ivp(slope, part, values, rtol=1e-10, atol=1e-13).y[:, -1]
    return values[0], values[1:]


def along(model, plan):
    """Torques and states of the feedforward along a plan, and those of the oracle."""
    state, known = FeedforwardState(0.0, plan[0], True), np.zeros(3)
    rows = []
    for start, end in itertools.pairwise(plan):
        torque, state = step_feedforward(model, state, plan_inputs(start, end), PERIODS)
        friction = torque - model.offset - model.inertia * (end - start) / PERIODS
        integral, known = by_scipy(model, known, start, end)
        expected = (model.inertia * (end - start) + integral) / PERIODS + model.offset
        rows.append((torque, friction, *state[:1], state.slip, state.adhesion, expected, integral / PERIODS, *known))
    return np.array(rows).T


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("micro_damping", [0.0, 6.0])
def test_friction_along_a_plan_solves_the_equations_of_the_bristles(sign, micro_damping):
    found = along(PRESLIDING._replace(micro_damping=micro_damping), sign * PLAN)
    for own, oracle in zip(found[:5], found[5:], strict=True):
        assert np.max(np.abs(own - oracle)) <= 4e-3 * np.max(np.abs(oracle))
