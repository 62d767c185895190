"""The elasto-plastic joint against closed forms of its loops, the joint without presliding, and its own equations."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from stepped_joint import FRICTION, TORQUE, VELOCITY, accepted, along_paths, ends, friction_fields, mirrored, run

import plant
from plant.elasto_plastic import mobilised

FIELDS = {"inertia": 20.0, **FRICTION, "presliding": 3e-3}
FLAT = {"stiction": 60.0, "viscous": 0.0}
REST = plant.ElastoPlasticState(0.0, 0.0, 0.0, 0.0, 0.0)


def model(**changes):
    return plant.ElastoPlasticJoint(**{**FIELDS, **changes})


friction_along = along_paths(plant.step_elasto_plastic, REST)


def rising(share):
    """The curve of the source."""
    inside = np.clip(share, 1e-300, 1.0)
    return inside * (1.0 - np.log(inside))


def test_branches_from_rest_and_from_a_reversal_are_the_curve_of_the_source():
    joint = model(**FLAT).parameters
    up, down = np.linspace(0.0, 2e-3, 401), np.linspace(2e-3, -3e-3, 1001)
    found = friction_along(joint, np.concatenate([up, down[1:]]))
    assert found[:400] == pytest.approx(60.0 * rising(up[1:] / 3e-3), rel=1e-9)
    top = found[399]
    assert found[400:] == pytest.approx(top - (60.0 + top) * rising((2e-3 - down[1:]) / 3e-3), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("stroke", [3e-3, 0.01])
def test_closed_loop_takes_the_energy_of_the_closed_form(stroke):
    # the curve covers 3/4 of a rectangle: a cycle that slides takes 2 Fc (stroke - s/2)
    joint = model(**FLAT).parameters
    steps = 2_500
    path = np.concatenate([np.linspace(0.0, stroke, steps + 1), np.linspace(stroke, 0.0, steps + 1)[1:]])
    twice = np.concatenate([path, path[1:]])
    torque = friction_along(joint, twice)[-2 * steps :]
    assert np.sum(torque * np.diff(path)) == pytest.approx(2.0 * 60.0 * (stroke - 1.5e-3), rel=2e-3)


def test_small_cycle_of_displacement_closes_at_the_fixed_point_of_its_branches():
    # b = a + (1 - a) g and a = -b: b = g/(2 - g), with g the curve at the cycle's stroke
    joint = model(**FLAT).parameters
    stroke = 5e-4
    leg = np.linspace(0.0, stroke, 51)
    cycle = np.concatenate([leg, leg[::-1][1:]])
    torque = friction_along(joint, np.concatenate([cycle, *60 * [cycle[1:]]]))
    rise = rising(stroke / 3e-3)
    assert torque[-51] == pytest.approx(60.0 * rise / (2.0 - rise), rel=1e-9)
    assert torque[-1] == pytest.approx(-60.0 * rise / (2.0 - rise), rel=1e-9)


@pytest.mark.parametrize("lag", [0.0, 0.02])
def test_joint_without_presliding_is_the_papers(lag):
    rigid = plant.JointModel(inertia=20.0, **FRICTION, friction_lag=lag, offset=3.0).parameters
    torques = 150.0 * np.sin(1e-3 * np.arange(8000)) + 40.0 * np.sin(0.0041 * np.arange(8000))
    state, expected = plant.initial_state(rigid, 0.1), [0.1]
    for torque in torques.tolist():
        state = plant.step_joint(rigid, state, torque, 2e-4)
        expected.append(state.velocity)
    differences = []
    for presliding in (1e-5, 1e-8, 1e-10):
        joint = model(friction_lag=lag, offset=3.0, presliding=presliding, solver_period=2e-4).parameters
        motion = run(joint, plant.initial_state(joint, 0.1), torques, 2e-4)
        differences.append(np.sqrt(np.mean((motion[:, 0] - expected) ** 2)))
    assert np.ptp(expected) > 0.3
    assert differences[0] > 10.0 * differences[1] > 100.0 * differences[2]
    assert differences[2] < 1e-7


def by_runge_kutta(joint, start, torque, duration):
    """Velocity, position and friction at the end of a forward motion, by scipy."""
    curve, origin = joint.friction, start.position - start.travel

    def slope(t, y):
        share = start.turned + (1.0 - start.turned) * float(rising((y[1] - origin) / joint.presliding))
        level = plant.sliding_friction(curve._replace(viscous=0.0), y[0])
        static = share * level + curve.viscous * y[0]
        return [(torque(t) - y[2]) / joint.inertia, y[0], (static - y[2]) / joint.friction_lag]

    found = solve_ivp(slope, (0.0, duration), [*start[:1], 0.0, start[1]], "DOP853", rtol=1e-10, atol=1e-14)
    assert found.success
    assert np.all(found.y[0] > 0.0)
    assert found.y[1, -1] - origin > 1.5 * joint.presliding
    return found.y[[0, 1, 2], -1]


def test_motion_from_presliding_into_sliding_converges_to_that_of_solve_ivp_with_first_order():
    joint, start = model(friction_lag=0.02).parameters, plant.ElastoPlasticState(0.02, 10.0, 0.0, -0.5, 5e-4)

    def torque(t):
        return 40.0 + 400.0 * t

    exact = by_runge_kutta(joint, start, torque, 0.3)
    errors = ends(joint, start, torque, 0.3, (1e-4, 5e-5, 2.5e-5))[:, [0, 2, 1]] - exact
    assert np.all(np.abs(errors[0]) < 0.01 * np.abs(exact))
    assert errors[:-1] / errors[1:] == pytest.approx(2.0, abs=0.1)


@st.composite
def steps(draw):
    fields = {
        **draw(friction_fields()),
        "friction_lag": draw(st.just(0.0) | st.floats(1e-4, 0.1)),
        "presliding": 10.0 ** draw(st.floats(-6.0, -1.0)),
    }
    model = accepted(plant.ElastoPlasticJoint, fields)
    travel = draw(st.floats(-1.0, 1.0)) * fields["presliding"]
    friction, turned = draw(st.floats(-150.0, 150.0)), draw(st.floats(-1.0, 1.0))
    state = plant.ElastoPlasticState(draw(VELOCITY), friction, 0.0, turned, travel)
    return model.parameters, state, draw(TORQUE), model.solver_period


@settings(max_examples=100)
@given(steps())
def test_step_solves_its_equations_and_is_odd(case):
    joint, state, torque, h = case
    after = plant.step_elasto_plastic(joint, state, torque, h)
    pull = torque - joint.offset - after.friction_torque
    size = abs(state.velocity) + h / joint.inertia * (abs(torque) + abs(joint.offset) + 500.0)
    assert after.velocity == pytest.approx(state.velocity + h / joint.inertia * pull, abs=1e-9 * size)
    share = mobilised(joint.presliding, after.turned, after.travel)
    before = mobilised(joint.presliding, state.turned, state.travel)
    assert (share - before) * after.velocity >= 0.0
    assert abs(after.travel) <= joint.presliding
    curve = joint.friction if share > 0.0 else joint.backward
    level = plant.sliding_friction(curve._replace(viscous=0.0), abs(after.velocity))
    static = share * level + joint.friction.viscous * after.velocity
    lagged = after.friction_torque + joint.friction_lag * (after.friction_torque - state.friction_torque) / h
    scale = (1.0 + joint.friction_lag / h) * 500.0 + 1e-9 * size * joint.inertia * (joint.friction_lag + h) / h**2
    assert lagged == pytest.approx(static, abs=1e-9 * scale + 1e-6)
    assert mirrored(plant.step_elasto_plastic, joint, state, torque, h) == after
