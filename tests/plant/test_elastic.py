"""The elastic joint against the closed forms of two inertias on a spring, its energy, and the rigid joint."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError
from scipy.integrate import solve_ivp
from stepped_joint import FRICTION, TORQUE, VELOCITY, accepted, ends, friction_fields, mirrored, run

from plant import ElasticJoint, ElasticState, sliding_friction, step_elastic

FIELDS = {"inertia": 20.0, **FRICTION, "link_share": 0.6, "link_stiffness": 5e4}
FREE = {**FIELDS, "coulomb": 0.0, "stiction": 0.0, "viscous": 0.0}
MOTOR, LINK = 8.0, 12.0
RESONANCE = math.sqrt(5e4 / MOTOR + 5e4 / LINK)  # rad/s
ANTIRESONANCE = math.sqrt(5e4 / LINK)
REST = ElasticState(0.0, 0.0, 0.0, 0.0, 0.0)


def model(**changes):
    return ElasticJoint(**{**FIELDS, **changes})


def free(**changes):
    return ElasticJoint(**{**FREE, **changes})


def response(period, frequencies):
    """Size of the frequency response from torque to motor velocity, from a simulated impulse response."""
    joint = free(link_damping=20.0, solver_period=period).parameters
    torques = np.zeros(round(4.0 / period))
    torques[0] = 1.0 / period
    impulse = run(joint, REST, torques, period)[1:, 3] - 1.0 / 20.0  # of both inertias together
    assert np.max(np.abs(impulse[-100:])) < 1e-3 * np.max(np.abs(impulse))
    z = np.exp(-1j * np.outer(frequencies, period * np.arange(impulse.size)))
    whole = 1.0 / 20.0 / (1.0 - np.exp(-1j * frequencies * period))
    return np.abs(z @ impulse + whole)


@pytest.mark.parametrize("period", [1e-3, 2e-4])
def test_resonance_and_antiresonance_are_those_of_the_closed_form(period):
    near = np.linspace(0.95, 1.05, 81)
    peak = near[np.argmax(response(period, RESONANCE * near))]
    dip = near[np.argmin(response(period, ANTIRESONANCE * near))]
    assert peak == pytest.approx(1.0, abs=0.01)
    assert dip == pytest.approx(1.0, abs=0.01)


def test_free_swing_decays_as_the_closed_form_says():
    damping = 40.0
    joint = free(link_damping=damping, solver_period=1e-4).parameters
    motion = run(joint, REST._replace(twist=0.01), np.zeros(6000), 1e-4)
    rate = 0.5 * damping * (1.0 / MOTOR + 1.0 / LINK)
    omega = math.sqrt(RESONANCE**2 - rate**2)
    before, swing, after = motion[:-2, 4], motion[1:-1, 4], motion[2:, 4]
    found = swing[(swing > before) & (swing >= after)]  # its maxima
    assert len(found) == 9
    assert np.log(found[:-1] / found[1:]) == pytest.approx(rate * 2.0 * math.pi / omega, rel=0.02)
    assert MOTOR * motion[:, 3] + LINK * motion[:, 0] == pytest.approx(0.0, abs=1e-10)  # momentum


@pytest.mark.nightly
def test_swing_without_damping_goes_on_for_ten_thousand_periods():
    joint = free().parameters
    motion = run(joint, REST._replace(twist=0.01), np.zeros(650_000), 1e-3)
    assert 1e-3 * 650_000 * RESONANCE / (2.0 * math.pi) > 10_000
    assert np.max(motion[-1000:, 4]) == pytest.approx(0.01, rel=2e-3)  # a sampled maximum
    energy = 0.5 * (MOTOR * motion[:, 3] ** 2 + LINK * motion[:, 0] ** 2 + 5e4 * motion[:, 4] ** 2)
    assert energy == pytest.approx(energy[0], rel=1e-9)
    crossings = np.nonzero(np.diff(np.sign(motion[:, 4])))[0]
    lowered = 2.0 / 1e-3 * math.atan(0.5 * RESONANCE * 1e-3)  # by the trapezoidal rule
    assert math.pi / (1e-3 * np.mean(np.diff(crossings))) == pytest.approx(lowered, rel=1e-6)


@st.composite
def steps(draw):
    fields = {
        **draw(friction_fields(shapes=(0.7, 1.0, 2.0))),
        "friction_lag": draw(st.just(0.0) | st.floats(1e-4, 0.1)),
        "link_share": draw(st.floats(0.01, 0.99)),
        "link_stiffness": 10.0 ** draw(st.floats(1.0, 6.0)),
        "link_damping": draw(st.just(0.0) | st.floats(0.0, 1e3)),
    }
    joint = accepted(ElasticJoint, fields, draw(st.floats(1e-4, 2e-3)))
    twist = draw(st.floats(-200.0, 200.0)) / fields["link_stiffness"]
    state = ElasticState(draw(VELOCITY), draw(st.floats(-200.0, 200.0)), draw(VELOCITY), draw(VELOCITY), twist)
    return joint.parameters, state, draw(TORQUE), joint.solver_period


def energy(joint, state):
    kinetic = joint.motor_inertia * state.motor_velocity**2 + joint.link_inertia * state.velocity**2
    return 0.5 * (kinetic + joint.link_stiffness * state.twist**2)


@settings(max_examples=100)
@given(steps())
def test_step_solves_its_equations_balances_energy_and_is_odd(case):
    joint, state, torque, h = case
    after = step_elastic(joint, state, torque, h)
    twist = 0.5 * (state.twist + after.twist)
    motor = 0.5 * (state.motor_velocity + after.motor_velocity)
    link = 0.5 * (state.velocity + after.velocity)
    spring = joint.link_stiffness * twist + joint.link_damping * (motor - link)
    pull = torque - joint.offset - after.friction_torque
    speed = abs(state.motor_velocity) + abs(state.velocity)
    torques = abs(torque) + abs(joint.offset) + abs(state.friction_torque) + joint.friction.stiction + 200.0
    torques += (joint.link_damping + h * joint.link_stiffness) * speed
    size = speed + h / min(joint.motor_inertia, joint.link_inertia) * torques
    tiny = 1e-10 * size
    assert after.velocity == pytest.approx(state.velocity + h / joint.link_inertia * spring, abs=tiny)
    assert after.motor_velocity == pytest.approx(
        state.motor_velocity + h / joint.motor_inertia * (pull - spring), abs=tiny
    )
    assert after.twist == pytest.approx(state.twist + h * (motor - link), abs=h * tiny + 1e-15)
    assert after.position == pytest.approx(state.position + h * motor, abs=h * tiny + 1e-15)
    static = after.friction_torque + joint.friction_lag * (after.friction_torque - state.friction_torque) / h
    forward = after.motor_velocity > 0.0 or (after.motor_velocity == 0.0 and static > 0.0)
    curve = joint.friction if forward else joint.backward
    weight = h * h / (joint.motor_inertia * (joint.friction_lag + h))
    if after.motor_velocity == 0.0:
        assert weight * abs(static) <= weight * curve.stiction + 10.0 * tiny
    else:
        expected = math.copysign(sliding_friction(curve, abs(after.motor_velocity)), after.motor_velocity)
        assert weight * static == pytest.approx(weight * expected, abs=10.0 * tiny)
    gained = energy(joint, after) - energy(joint, state)
    given_ = h * (pull * motor - joint.link_damping * (motor - link) ** 2)
    scale = energy(joint, after) + energy(joint, state) + h * torques * speed
    assert gained == pytest.approx(given_, abs=1e-8 * scale + 1e-12)
    assert mirrored(step_elastic, joint, state, torque, h) == after


def test_motion_with_smooth_friction_converges_to_that_of_solve_ivp_with_first_order():
    joint = model(coulomb=0.0, stiction=0.0, friction_lag=0.02, link_damping=20.0, offset=3.0).parameters

    def slope(t, y):
        link, friction, motor, twist = y
        spring = 5e4 * twist + 20.0 * (motor - link)
        pull = 150.0 * math.sin(8.0 * t) - 3.0 - friction - spring
        return [spring / LINK, (80.0 * motor - friction) / 0.02, pull / MOTOR, motor - link]

    exact = solve_ivp(slope, (0.0, 0.9), [0.0] * 4, method="LSODA", rtol=1e-10, atol=1e-13).y[:, -1]
    errors = ends(joint, REST, lambda t: 150.0 * np.sin(8.0 * t), 0.9, (1e-4, 5e-5))[:, [0, 1, 3, 4]] - exact
    assert np.all(np.abs(errors[1]) < 1e-3 * np.max(np.abs(exact)))
    assert errors[0][:3] / errors[1][:3] == pytest.approx(2.0, abs=0.05)


@pytest.mark.parametrize("share", [0.2, 0.9])
def test_solver_period_that_misplaces_the_resonance_is_refused(share):
    omega = math.sqrt(5e4 / 20.0 / (share * (1.0 - share)))
    with pytest.raises(
        ValidationError, match=f"its resonance of {omega / 2.0 / math.pi:.4g} Hz is misplaced"
    ) as caught:
        model(link_share=share, solver_period=0.01)
    longest = float(str(caught.value).partition("beyond ")[2].split()[0])
    placed = 2.0 / longest * math.atan(0.5 * omega * longest) / omega
    assert placed == pytest.approx(0.99, abs=1e-4)
    assert model(link_share=share, solver_period=0.999 * longest, stiction=60.0).link_share == share
    with pytest.raises(ValidationError, match="misplaced"):
        model(link_share=share, solver_period=1.001 * longest)


def test_solver_period_that_leaves_several_solutions_is_refused():
    # h < Jm/((Fs - Fc)/Vs - sigma) = 0.2/520
    with pytest.raises(ValidationError, match="the falling Stribeck curve leaves the implicit step more than one"):
        model(link_share=0.99, link_stiffness=100.0, solver_period=1.001 * 0.2 / 520.0)
    assert model(link_share=0.99, link_stiffness=100.0, solver_period=0.999 * 0.2 / 520.0).inertia == 20.0
