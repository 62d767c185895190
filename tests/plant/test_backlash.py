"""The joint with backlash against the elastic joint, closed forms of play and hysteresis, and its own equations."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from stepped_joint import FRICTION, TORQUE, VELOCITY, accepted, ends, friction_fields, mirrored, run

import plant
from plant import BacklashJoint, BacklashState, ElasticJoint, ElasticState, initial_state, step_backlash, step_elastic

FIELDS = {"inertia": 20.0, **FRICTION, "link_share": 0.6, "link_stiffness": 5e4, "gap": 0.002}
FREE = {**FIELDS, "coulomb": 0.0, "stiction": 0.0, "viscous": 0.0}
MOTOR, LINK = 8.0, 12.0
RESONANCE = math.sqrt(5e4 / MOTOR + 5e4 / LINK)  # rad/s
REST = BacklashState(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
HELD = {"link_inertia": 1e15, "motor_inertia": 1e15}


def model(**changes):
    return BacklashJoint(**{**FIELDS, **changes})


def turned_back_and_forth(joint, twists, period=1e-3):
    """Torque of the gear along a twist that is forced upon it, as motor and link are too heavy to move."""
    joint, state, torques = joint._replace(**HELD), REST, []
    for twist in twists.tolist():
        speed = 2.0 * (twist - state.twist) / period  # of the motor before the step; after it, the same
        state = step_backlash(joint, state._replace(motor_velocity=0.5 * speed), 0.0, period)
        torques.append(joint.link_stiffness * state.wind + state.hysteresis_torque)
    return np.array(torques)


def test_joint_without_gap_and_hysteresis_is_the_elastic_joint():
    shared = {name: value for name, value in FIELDS.items() if name != "gap"}
    shared |= {"link_damping": 20.0, "friction_lag": 0.02, "offset": 3.0}
    elastic = ElasticJoint(**shared).parameters
    joint = BacklashJoint(**shared, gap=0.0).parameters
    state, expected = initial_state(joint, 0.1), initial_state(elastic, 0.1)
    assert isinstance(expected, ElasticState)
    for k in range(3000):
        torque = 150.0 * math.sin(0.01 * k) + 30.0 * math.sin(0.037 * k)
        state, expected = step_backlash(joint, state, torque, 1e-3), step_elastic(elastic, expected, torque, 1e-3)
        assert state[:5] == pytest.approx(expected, rel=1e-9, abs=1e-12)
    assert abs(expected.velocity) > 1e-3


def test_swing_across_the_gap_has_the_period_of_the_closed_form_and_keeps_its_energy():
    # two masses fly through the gap at a relative speed V, then the spring turns them round in half a swing
    speed, period = 0.3, 1e-4
    joint = BacklashJoint(**FREE, solver_period=period).parameters
    start = REST._replace(motor_velocity=LINK / 20.0 * speed, velocity=-MOTOR / 20.0 * speed)
    motion = run(joint, start, np.zeros(40_000), period)
    twist = motion[:, 4]
    upward = np.nonzero((twist[:-1] < 0.0) & (twist[1:] >= 0.0))[0][3:]
    assert len(upward) > 15
    expected = 2.0 * (math.pi / RESONANCE + 0.002 / speed)
    assert period * np.mean(np.diff(upward)) == pytest.approx(expected, rel=2e-3)
    assert np.max(np.abs(twist)) == pytest.approx(0.001 + speed / RESONANCE, rel=2e-3)
    energy = 0.5 * (MOTOR * motion[:, 3] ** 2 + LINK * motion[:, 0] ** 2 + 5e4 * motion[:, 5] ** 2)
    assert energy == pytest.approx(energy[0], rel=0.02)
    assert MOTOR * motion[:, 3] + LINK * motion[:, 0] == pytest.approx(0.0, abs=1e-9)  # momentum


def by_radau(torque, duration):
    """Twist and both velocities at the end, by scipy with the moments of touching as events."""

    def slope(t, y):
        spring = 5e4 * (y[2] - min(max(y[2], -0.001), 0.001))
        return [(torque(t) - 80.0 * y[0] - spring) / MOTOR, spring / LINK, y[0] - y[1]]

    touch = [lambda t, y, side=side: y[2] - side for side in (-0.001, 0.001)]
    for event in touch:
        event.terminal = True
    time, state = 0.0, [0.0, 0.0, 0.0]
    while time < duration - 1e-12:
        exactly = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-14}
        found = solve_ivp(slope, (time, duration), state, events=touch, max_step=0.01, **exactly)
        assert found.success
        time, state = found.t[-1], found.y[:, -1]
        if time < duration:  # a little past the event, so that it is not met again
            found = solve_ivp(slope, (time, time + 1e-9), state, method="DOP853", rtol=1e-12, atol=1e-15)
            time, state = found.t[-1], found.y[:, -1]
    return np.array(state)


def test_motion_converges_to_that_of_solve_ivp_with_events_at_every_touch():
    def torque(t):
        return 60.0 * math.sin(8.0 * t)

    exact, joint = by_radau(torque, 0.6), model(coulomb=0.0, stiction=0.0, solver_period=4e-5).parameters
    found = ends(joint, REST, lambda t: 60.0 * np.sin(8.0 * t), 0.6, (4e-5, 2e-5, 1e-5))[:, [3, 0, 4]]
    errors = np.abs(found - exact) / np.abs(exact)
    assert np.all(errors[0] < 2e-3)
    assert np.max(errors[2]) < 0.45 * np.max(errors[0])


def test_twist_within_the_gap_gives_no_torque_and_beyond_it_the_springs():
    joint = model().parameters
    twists = np.concatenate([np.linspace(0.0, 0.003, 300), np.linspace(0.003, -0.004, 700)])
    expected = 5e4 * (twists - np.clip(twists, -0.001, 0.001))
    assert turned_back_and_forth(joint, twists) == pytest.approx(expected, abs=1e-9)


def test_lost_motion_is_the_play_operator_after_the_stop_operator():
    # unwinding, the element gives 2 H0 less after twice its reach; without torque the end crosses the whole gap
    joint = model(hysteresis=20.0, hysteresis_reach=0.0005).parameters
    up, down = np.linspace(0.0, 0.004, 1001), np.linspace(0.004, -0.004, 2001)
    torque = turned_back_and_forth(joint, np.concatenate([up, down]))
    assert torque[1000] == pytest.approx(5e4 * 0.003 + 20.0, rel=1e-9)
    back = torque[1001:]
    silent = down[np.abs(back) < 1e-7]
    assert np.ptp(silent) == pytest.approx(0.002, abs=1e-5)
    assert silent[0] == pytest.approx(0.001 + 20.0 / 5e4, abs=5e-6)  # k s = H0: the wind that the element holds
    assert back[-1] == pytest.approx(-torque[1000], rel=1e-9)


def test_loop_of_the_gear_takes_the_energy_of_the_closed_form():
    # a stop operator turned by +-A takes 4 H0 (A - reach) a cycle; the gap moves where the torque is zero
    joint = model(hysteresis=20.0, hysteresis_reach=0.0005).parameters
    cycle = 0.004 * np.sin(np.linspace(0.0, 4.0 * math.pi, 8001))
    torque = turned_back_and_forth(joint, cycle)
    second = slice(4000, None)
    area = np.trapezoid(torque[second], cycle[second])
    assert area == pytest.approx(4.0 * 20.0 * (0.003 - 0.0005), rel=1e-3)


def test_gear_is_rate_independent_without_damping():
    joint = model(hysteresis=20.0).parameters
    cycle = 0.004 * np.sin(np.linspace(0.0, 9.0, 3001)) + 0.001 * np.sin(np.linspace(0.0, 50.0, 3001))
    slow = turned_back_and_forth(joint, cycle, period=1e-2)
    assert turned_back_and_forth(joint, cycle, period=1e-4) == pytest.approx(slow, abs=1e-7)


@st.composite
def steps(draw):
    fields = {
        **draw(friction_fields()),
        "friction_lag": draw(st.just(0.0) | st.floats(1e-4, 0.1)),
        "link_share": draw(st.floats(0.1, 0.9)),
        "link_stiffness": 10.0 ** draw(st.floats(2.0, 5.0)),
        "link_damping": draw(st.just(0.0) | st.floats(0.0, 1e3)),
        "gap": draw(st.just(0.0) | st.floats(1e-4, 1e-2)),
        "hysteresis": draw(st.just(0.0) | st.floats(1.0, 50.0)),
        "hysteresis_reach": draw(st.floats(1e-3, 1e-2)),
    }
    model = accepted(BacklashJoint, fields)
    wind = draw(st.floats(-100.0, 100.0)) / fields["link_stiffness"]
    place = 0.5 * draw(st.floats(-1.0, 1.0)) * fields["gap"]
    held = draw(st.floats(-1.0, 1.0)) * fields["hysteresis"]
    friction = draw(st.floats(-150.0, 150.0))
    state = BacklashState(draw(VELOCITY), friction, 0.0, draw(VELOCITY), wind + place, wind, held)
    return model.parameters, state, draw(TORQUE), model.solver_period


@settings(max_examples=100)
@given(steps())
def test_step_solves_its_equations_stays_in_the_gap_and_is_odd(case):
    joint, state, torque, h = case
    after = step_backlash(joint, state, torque, h)
    winding = after.wind - state.wind
    before = joint.link_stiffness * state.wind + state.hysteresis_torque
    elastic = joint.link_stiffness * after.wind + after.hysteresis_torque
    damping = joint.link_damping * winding / h
    gear = 0.5 * (before + elastic) + damping
    size = 300.0 + abs(before) + abs(elastic) + abs(damping) + abs(joint.link_stiffness * (after.twist - state.twist))
    tiny = 1e-9 * size
    link = joint.link_inertia * (after.velocity - state.velocity) / h
    motor = joint.motor_inertia * (after.motor_velocity - state.motor_velocity) / h
    loose = 1e-9 * (size + joint.link_inertia * abs(state.velocity) / h + joint.motor_inertia * 4.0 / h)
    assert link == pytest.approx(gear, abs=loose)
    assert motor == pytest.approx(torque - joint.offset - after.friction_torque - gear, abs=loose)
    wound = state.hysteresis_torque + joint.hysteresis_stiffness * winding
    held = float(np.clip(wound, -joint.hysteresis, joint.hysteresis))
    assert after.hysteresis_torque == pytest.approx(held, abs=tiny)
    place = after.twist - after.wind
    assert abs(place) <= joint.half_gap + 1e-12
    slack = 1e-12 + 1e-9 * abs(after.twist)
    push = elastic + damping  # of the spring's end after the step: each side can only push
    if place < joint.half_gap - slack:
        assert push <= tiny
    if place > -joint.half_gap + slack:
        assert push >= -tiny
    assert mirrored(step_backlash, joint, state, torque, h) == pytest.approx(after, rel=1e-12, abs=1e-15)


def test_link_coasts_in_the_gap_while_the_motor_sticks():
    joint = model().parameters
    motion = run(joint, REST._replace(velocity=0.01), np.zeros(99), 1e-3)
    assert not np.any(motion[:, 3])
    assert motion[:, 0] == pytest.approx(0.01)  # 1 mrad at 10 mrad/s
    later = run(joint, REST._replace(velocity=0.01), np.zeros(150), 1e-3)
    assert later[-1, 0] < -0.005  # turned round at the gap's end


@pytest.mark.parametrize("wind", [-0.01, 1e-5, 0.01])
def test_a_free_end_winds_until_spring_hysteresis_and_damping_are_in_balance(wind):
    joint, rate = model(hysteresis=50.0, hysteresis_reach=1e-3).parameters, 1e4
    winding = plant.backlash.free_winding(joint, REST._replace(wind=wind), rate)
    hysteresis = min(max(joint.hysteresis_stiffness * winding, -joint.hysteresis), joint.hysteresis)
    assert joint.link_stiffness * (wind + winding) + hysteresis + rate * winding == pytest.approx(0.0, abs=1e-9)
