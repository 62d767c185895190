"""Maxwell-slip joints against the Masing rule, return-point memory, closed loops, and their own equations."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError
from scipy.integrate import solve_ivp
from stepped_joint import FRICTION, TORQUE, VELOCITY, accepted, along_paths, ends, friction_fields, mirrored

from plant import MaxwellJoint, MaxwellState, RollingJoint, Stribeck, initial_state, sliding_friction, step_maxwell
from plant.friction import steepest_fall
from plant.maxwell import KNOTS

FIELDS = {"inertia": 20.0, **FRICTION, "displacements": [3e-4, 1e-3, 2e-3, 4e-3], "shares": [0.4, 0.3, 0.2, 0.1]}
FLAT = {**FIELDS, "stiction": 60.0, "viscous": 0.0}
REST = MaxwellState(*11 * [0.0])
SHARES, REACHES = np.array(FIELDS["shares"]), np.array(FIELDS["displacements"])


def model(**changes):
    return MaxwellJoint(**{**FIELDS, **changes})


friction_along = along_paths(step_maxwell, REST)


def virgin(displacement, shares=SHARES, reaches=REACHES, torque=60.0):
    """Friction from rest: each element is a spring that slips."""
    return torque * np.sum(shares * np.minimum(np.abs(np.atleast_1d(displacement))[:, None] / reaches, 1.0), axis=1)


def test_first_branch_is_the_sum_of_springs_that_slip_and_every_other_one_obeys_masing():
    joint = model(**FLAT).parameters
    up, down, again = np.linspace(0.0, 3e-3, 301), np.linspace(3e-3, -1e-3, 401), np.linspace(-1e-3, 2e-3, 301)
    found = friction_along(joint, np.concatenate([up, down[1:], again[1:]]))
    first, second, third = found[:300], found[300:700], found[700:]
    assert first == pytest.approx(virgin(up[1:]), rel=1e-9)
    assert second == pytest.approx(first[-1] - 2.0 * virgin((3e-3 - down[1:]) / 2.0), rel=1e-9, abs=1e-9)
    assert third == pytest.approx(second[-1] + 2.0 * virgin((again[1:] + 1e-3) / 2.0), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("amplitude", [2e-4, 8e-4, 5e-3])
def test_closed_loop_takes_the_energy_of_the_closed_form(amplitude):
    joint = model(**FLAT).parameters
    quarter = np.linspace(0.0, amplitude, 1001)
    cycle = np.concatenate([quarter, quarter[::-1][1:], -quarter[1:], -quarter[::-1][1:]])
    torque = friction_along(joint, np.concatenate([cycle, cycle[1:]]))[-4000:]
    area = np.sum(torque * np.diff(cycle))  # each torque holds over its step: a sum of rectangles
    expected = np.sum(4.0 * 60.0 * SHARES * np.maximum(amplitude - REACHES, 0.0))
    assert area == pytest.approx(expected, abs=2e-3 * 4.0 * 60.0 * amplitude)


def of_events(torque, duration, joint):
    """Velocity and position at the end of a forward motion by scipy; each element slips at an event."""
    stiffness, limits, slips = np.array(joint.stiffnesses), 60.0 * np.array(joint.shares), np.zeros(4, dtype=bool)

    def slope(t, y):
        rates = np.where(slips, 0.0, stiffness * y[0])
        return [(torque(t) - np.sum(y[2:]) - 80.0 * y[0]) / 20.0, y[0], *rates]

    onsets = [lambda t, y, i=i: y[2 + i] - limits[i] if not slips[i] else 1.0 for i in range(4)]
    for onset in onsets:
        onset.terminal = True
    time, state = 0.0, np.zeros(6)
    for _ in range(5):
        found = solve_ivp(slope, (time, duration), state, method="DOP853", rtol=1e-11, atol=1e-14, events=onsets)
        assert found.success
        assert np.all(found.y[0] > -1e-9)
        time, state = found.t[-1], found.y[:, -1]
        slips |= [event.size > 0 for event in found.t_events]
    assert time == duration
    assert np.all(slips)
    return state[:2]


def test_motion_through_all_onsets_of_slip_converges_to_that_of_solve_ivp_with_first_order():
    joint = model(stiction=60.0).parameters
    exact = of_events(lambda t: 400.0 * t, 0.4, joint)
    errors = ends(joint, REST, lambda t: 400.0 * t, 0.4, (1e-4, 5e-5, 2.5e-5))[:, [0, 2]] - exact
    assert np.all(np.abs(errors[0]) < 1e-3 * exact)
    assert errors[:-1] / errors[1:] == pytest.approx(2.0, abs=0.1)


def test_sliding_friction_follows_with_the_time_constant_of_the_attraction():
    # sum of dF/dt = C (1 - F/g): F - g fades with the time constant g/C
    joint = model(viscous=0.0, attraction=2e3).parameters
    start, fast = initial_state(joint, 0.01), 0.2
    friction = friction_along(joint, np.arange(201) * 1e-4 * fast, period=1e-4, state=start)
    before, level = sliding_friction(joint.friction, 0.01), sliding_friction(joint.friction, fast)
    time = 1e-4 * np.arange(1, 201)
    assert friction == pytest.approx(level + (before - level) * np.exp(-2e3 / level * time), abs=0.01 * before)
    at_once = friction_along(model(viscous=0.0).parameters, np.arange(3) * 1e-4 * fast, period=1e-4, state=start)
    assert at_once == pytest.approx(2 * [level], rel=1e-9)


@st.composite
def steps(draw):
    shares = np.array([draw(st.floats(0.1, 1.0)) for _ in range(4)])
    fields = {
        **draw(friction_fields(least=1.0)),
        "coulomb_backward": None,
        "attraction": draw(st.none() | st.floats(10.0, 1e5)),
        "displacements": np.cumsum([draw(st.floats(1e-4, 1e-2)) for _ in range(4)]).tolist(),
        "shares": (shares / shares.sum()).tolist(),
    }
    model = accepted(MaxwellJoint, fields)
    slips = [draw(st.sampled_from([-1.0, 0.0, 1.0])) for _ in range(4)]
    loads = [
        share * fields["stiction"] * (slip * draw(st.floats(0.3, 1.0)) if slip else draw(st.floats(-1.0, 1.0)))
        for share, slip in zip(model.parameters.shares, slips, strict=True)
    ]
    state = MaxwellState(draw(VELOCITY), 0.0, 0.0, *loads, *slips)
    return model.parameters, state, draw(TORQUE), model.solver_period


@settings(max_examples=100)
@given(steps())
def test_step_solves_its_equations_and_is_odd(case):
    joint, state, torque, h = case
    after = step_maxwell(joint, state, torque, h)
    loads, slips = np.array(state[3:7]), np.array(state[7:])
    pull = torque - joint.offset - after.friction_torque
    size = abs(state.velocity) + h / joint.inertia * (abs(torque) + abs(joint.offset) + 5.0 * joint.friction.stiction)
    assert after.velocity == pytest.approx(state.velocity + h / joint.inertia * pull, abs=1e-9 * size)
    assert after.position == pytest.approx(h * after.velocity, abs=1e-15)
    way = math.copysign(1.0, after.velocity)
    level = sliding_friction(joint.friction._replace(viscous=0.0), abs(after.velocity))
    share, spring = np.array(joint.shares), np.array(joint.stiffnesses)
    free = loads + h * spring * after.velocity
    attracted = way * share * level  # a slipping element by implicit Euler, C (a - F/g)
    if joint.relaxation > 0.0:
        rate = h / joint.relaxation
        attracted = np.where(slips == way, (loads + rate * way * share) / (1.0 + rate / level), attracted)
    expected = way * np.minimum(way * free, way * attracted)
    assert np.array(after[3:7]) == pytest.approx(expected, rel=1e-9, abs=1e-9)
    viscous = joint.friction.viscous * after.velocity
    assert after.friction_torque == pytest.approx(np.sum(expected) + viscous, rel=1e-9, abs=1e-9)
    assert mirrored(step_maxwell, joint, state, torque, h) == after


@pytest.mark.parametrize("exponent", [1.5, 2.0, 3.0])
def test_rolling_friction_is_its_curve_where_elements_slip_and_straight_between(exponent):
    fields = {**FLAT, "rolling_range": 0.01, "exponent": exponent}
    joint = RollingJoint(**{name: fields[name] for name in fields if name not in ("displacements", "shares")})
    path = np.linspace(0.0, 0.012, 961)
    found = friction_along(joint.parameters, path)
    curve = 60.0 * (1.0 - (1.0 - np.minimum(path[1:] / 0.01, 1.0)) ** exponent)
    places = np.searchsorted(path[1:], 0.01 * np.array(KNOTS) - 1e-12)
    assert found[places] == pytest.approx(curve[places], rel=1e-9)
    assert np.all(found <= curve + 1e-9)  # straight lines below a curve that bends down
    assert np.max(curve - found) < 0.05 * 60.0
    assert sum(joint.parameters.shares) == pytest.approx(1.0, rel=1e-12)
    assert min(joint.parameters.shares) > 0.0


@pytest.mark.parametrize(("ratio", "factor"), [(1.9, 1.0), (3.0, 1.125)])
def test_longest_solver_period_is_that_of_the_steepest_element(ratio, factor):
    fall = steepest_fall(Stribeck(10.0, 10.0 * ratio, 0.0, 0.05, 1.0))
    fields = {**FIELDS, "coulomb": 10.0, "stiction": 10.0 * ratio, "viscous": 0.0}
    longest = 0.5 * 20.0 / (factor * fall)
    MaxwellJoint(**fields, solver_period=0.999 * longest)
    with pytest.raises(ValidationError, match="solver_period"):
        MaxwellJoint(**fields, solver_period=1.001 * longest)
