"""The LuGre joint against its own differential equations, closed forms of slow motion, and the claims of its paper."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError
from scipy.integrate import solve_ivp
from stepped_joint import FRICTION, TORQUE, VELOCITY, accepted, ends, friction_fields, mirrored, run

from plant import LuGreJoint, LuGreState, initial_state, step_lugre
from plant.lugre import steepest_fall_in_a_step

FIELDS = {"inertia": 20.0, **FRICTION, "stiffness": 1e5}
MODEL = LuGreJoint(**FIELDS)
JOINT = MODEL.parameters
UNEVEN = LuGreJoint(
    **FIELDS, coulomb_backward=40.0, stiction_backward=50.0, viscous_backward=100.0, offset=7.0, stribeck_shape=1.5
).parameters
HELD = JOINT._replace(inertia=1e12)  # its velocity is forced: friction does not change it
REST = LuGreState(0.0, 0.0, 0.0, 0.0)


def friction_force(joint, velocity, deflection):
    """Friction torque and dz/dt as in the paper of 1995, with Olsson's damping."""
    curve = joint.friction if velocity >= 0.0 else joint.backward
    falling = math.exp(-(abs(velocity / curve.stribeck_velocity) ** curve.stribeck_shape))
    level = curve.coulomb + (curve.stiction - curve.coulomb) * falling
    rate = velocity - joint.stiffness * abs(velocity) / level * deflection
    damping = joint.damping * math.exp(-((velocity / curve.stribeck_velocity) ** 2))
    return joint.stiffness * deflection + damping * rate + curve.viscous * velocity, rate


def by_lsoda(joint, start, torque, duration):
    """Velocity, position and deflection at the end, by scipy at a tight tolerance."""

    def slope(t, y):
        friction, rate = friction_force(joint, y[0], y[2])
        return [(torque(t) - joint.offset - friction) / joint.inertia, y[0], rate]

    found = solve_ivp(slope, (0.0, duration), start, method="LSODA", rtol=1e-10, atol=1e-13, max_step=0.01)
    assert found.success
    return found.y[:, -1]


@pytest.mark.parametrize("joint", [JOINT, UNEVEN, JOINT._replace(damping=0.0)], ids=["even", "uneven", "undamped"])
@pytest.mark.parametrize(("size", "duration"), [(60.0, 0.4), (150.0, 0.9)], ids=["pre-sliding", "sliding, reversing"])
def test_motion_converges_to_that_of_solve_ivp_with_first_order(joint, size, duration):
    exact = by_lsoda(joint, [0.0, 0.0, 0.0], lambda t: size * math.sin(8.0 * t), duration)
    errors = ends(joint, REST, lambda t: size * np.sin(8.0 * t), duration, (1e-4, 5e-5))[:, [0, 2, 3]] - exact
    scale = np.array([0.1, 0.01, 1e-3])
    assert np.all(np.abs(errors[1]) < 0.01 * scale)
    large = np.abs(errors[1]) > 1e-5 * scale
    assert np.any(large)
    assert (errors[0] / errors[1])[large] == pytest.approx(2.0, abs=0.1)


def slow_cycle(joint, top, seconds):
    """Displacement along a torque that rises to the top, falls to minus the top and rises again, slowly."""
    period = 1e-3
    torque = np.interp(np.arange(0.0, 5.0 * seconds, period), seconds * np.array([0, 1, 3, 5]), [0, top, -top, top])
    return torque, run(joint, REST, torque, period)[1:, 2]


def test_slow_pre_sliding_follows_the_closed_form_of_its_hysteresis_loop():
    # while |w| << Vs, g = Fs: dy/dx = sigma0 (1 - y/Fs) forward and sigma0 (1 + y/Fs) backward
    torque, position = slow_cycle(JOINT, 60.0, 10.0)
    reach = 90.0 / 1e5
    loading, unloading = slice(0, 10_000), slice(10_000, 30_000)
    expected = -reach * np.log(1.0 - torque[loading] / 90.0)
    assert np.max(np.abs(position[loading] - expected)) < 0.01 * reach
    expected = position[9_999] - reach * np.log((1.0 + 60.0 / 90.0) / (1.0 + torque[unloading] / 90.0))
    assert np.max(np.abs(position[unloading] - expected)) < 0.01 * reach
    assert np.trapezoid(torque[10_000:], position[10_000:]) > 0.02  # the loop takes energy, N m rad


def test_bristles_are_critically_damped_by_default():
    omega = math.sqrt(1e5 / 20.0)
    times = 1e-5 * np.arange(10_001)
    position = run(JOINT, REST, np.full(10_000, 0.09), 1e-5)[:, 2]
    assert position == pytest.approx(9e-7 * (1.0 - (1.0 + omega * times) * np.exp(-omega * times)), abs=0.005 * 9e-7)


def test_joint_rests_for_long_below_breakaway_after_its_pre_sliding_displacement():
    torque = np.minimum(4e-3 * np.arange(1_000_000), 80.0)
    motion = run(JOINT, REST, torque, 1e-3)
    assert motion[-1, 2] == pytest.approx(-90.0 / 1e5 * math.log(1.0 - 80.0 / 90.0), rel=0.02)
    assert abs(motion[-1, 0]) < 1e-16
    assert np.ptp(motion[100_000:, 2]) < 1e-15
    assert not np.any(run(JOINT, REST, np.zeros(1000), 1e-3))


def test_breakaway_torque_falls_with_the_rate_at_which_it_is_applied():
    # as in the paper of 1995: the faster the torque rises, the less the bristles hold before they slide
    light = LuGreJoint(**{**FIELDS, "inertia": 0.2, "solver_period": 1e-4}).parameters
    found = []
    for rate in (2.0, 20.0, 200.0, 2000.0):
        deflection = run(light, REST, rate * 1e-4 * np.arange(round(1.5e6 / rate)), 1e-4)[:, 3]
        found.append(light.stiffness * np.max(deflection))
    assert 88.0 < found[0] < 90.0
    assert np.all(np.diff(found) < -1.0)
    assert found[-1] > 60.0


def test_friction_is_lower_while_decelerating_and_the_more_so_the_faster_the_velocity_varies():
    # frictional lag of the paper of 1995: velocity varies without reversing
    gaps = []
    for omega in (1.0, 10.0, 25.0):
        period = 2e-3 / omega
        times = period * np.arange(round(4.0 * math.pi / omega / period))
        velocity = 0.05 + 0.03 * np.sin(omega * times)
        acceleration = 0.03 * omega * np.cos(omega * (times + 0.5 * period))
        motion = run(HELD, initial_state(HELD, 0.05), HELD.inertia * acceleration, period)[:-1]
        last = times > 2.0 * math.pi / omega
        middle = last & (np.abs(velocity - 0.05) < 1e-3)
        rising, falling = middle & (acceleration > 0.0), middle & (acceleration < 0.0)
        gaps.append(np.mean(motion[rising, 1]) - np.mean(motion[falling, 1]))
    assert 0.0 < gaps[0] < gaps[1] < gaps[2]


@pytest.mark.nightly
def test_vibration_below_breakaway_lets_the_joint_creep_as_the_model_is_known_to_and_no_faster():
    def torque(t):
        return 50.0 + 25.0 * np.sin(30.0 * t)

    duration = 6.0 * 2.0 * math.pi / 30.0
    exact = by_lsoda(JOINT, [0.0, 0.0, 0.0], torque, duration)[1]
    earlier = by_lsoda(JOINT, [0.0, 0.0, 0.0], torque, duration / 2.0)[1]
    period = duration / 20_000
    position = run(JOINT, REST, torque(period * (np.arange(20_000) + 0.5)), period)[:, 2]
    assert exact - earlier > 1e-5
    assert position[-1] - position[10_000] == pytest.approx(exact - earlier, rel=0.01)


@st.composite
def models(draw):
    fields = {
        **draw(friction_fields(least=1.0, shapes=(0.5, 0.7, 1.0, 1.5, 2.0, 4.0))),
        "stiffness": 10.0 ** draw(st.floats(3.0, 6.0)),
    }
    least = min(fields["coulomb"], fields["coulomb_backward"] or math.inf)
    share = draw(st.none() | st.floats(0.0, 0.999))
    if share is not None:
        fields["damping"] = share * 4.0 * math.sqrt(2.0 * math.e) * least / fields["stribeck_velocity"]
    return accepted(LuGreJoint, fields, draw(st.floats(1e-4, 2e-3)))


@st.composite
def steps(draw):
    model = draw(models())
    joint = model.parameters
    share = draw(st.floats(-1.0, 1.0))
    bending = share * (joint.friction if share > 0.0 else joint.backward).stiction
    return model, LuGreState(draw(VELOCITY), 0.0, 0.0, bending / joint.stiffness), draw(TORQUE)


@settings(max_examples=100)
@given(steps())
def test_step_solves_the_implicit_equations_is_odd_and_passive_and_keeps_its_bristles_within_stiction(case):
    model, state, torque = case
    joint, h = model.parameters, model.solver_period
    after = step_lugre(joint, state, torque, h)
    friction, rate = friction_force(joint, after.velocity, after.deflection)
    size = abs(state.velocity) + h / joint.inertia * (abs(torque) + abs(joint.offset) + joint.friction.stiction)
    euler = state.velocity + h / joint.inertia * (torque - joint.offset - after.friction_torque)
    assert after.velocity == pytest.approx(euler, abs=1e-11 * size)
    strain = joint.stiffness * h * size + joint.friction.stiction  # what rounding is relative to, N m
    noise = 1e-11 * (1.0 + joint.damping / (joint.stiffness * h)) * strain
    assert h / joint.inertia * after.friction_torque == pytest.approx(
        h / joint.inertia * friction, abs=1e-10 * size + h / joint.inertia * noise
    )
    assert joint.stiffness * after.deflection == pytest.approx(
        joint.stiffness * (state.deflection + h * rate), abs=1e-10 * strain
    )
    assert after.position == h * after.velocity
    most = 1.0 + 1e-12
    assert -joint.backward.stiction * most <= joint.stiffness * after.deflection <= joint.friction.stiction * most
    stored = 0.5 * joint.stiffness * (after.deflection**2 - state.deflection**2)
    assert h * after.friction_torque * after.velocity >= stored - 1e-9 * h * strain * size
    assert mirrored(step_lugre, joint, state, torque, h) == after


@settings(max_examples=60)
@given(models(), st.floats(-1.0, 1.0))
def test_accepted_period_leaves_one_solution(model, share):
    joint, h = model.parameters, model.solver_period
    bending = share * (joint.friction if share > 0.0 else joint.backward).stiction
    speeds = joint.friction.stribeck_velocity * np.geomspace(1e-9, 1e3, 2000)
    speeds = np.concatenate([-speeds[::-1], [0.0], speeds])
    coulomb, stiction, viscous = (
        np.where(speeds >= 0.0, forward, backward)
        for forward, backward in zip(joint.friction[:3], joint.backward[:3], strict=True)
    )
    ratio, slip = np.abs(speeds) / joint.friction.stribeck_velocity, h * joint.stiffness
    level = coulomb + (stiction - coulomb) * np.exp(-np.minimum(ratio**joint.friction.stribeck_shape, 700.0))
    held = (bending + slip * speeds) / (1.0 + slip * np.abs(speeds) / level)
    damping = joint.damping * np.exp(-np.minimum(ratio**2, 700.0))
    left = speeds + h / joint.inertia * (held + damping * (held - bending) / slip + viscous * speeds)
    rise, span = np.diff(left), np.diff(speeds)
    # half as fast as w, but for rounding
    assert np.all(rise >= 0.49 * span - 1e-12 * (1.0 + np.abs(left[1:])))


def test_steepest_fall_is_found_by_brute_force():
    for joint in (JOINT, UNEVEN, JOINT._replace(stiffness=1e7), JOINT._replace(damping=0.0)):
        h = 1e-4
        slip = h * joint.stiffness
        worst = 0.0
        for curve, other in ((joint.friction, joint.backward), (joint.backward, joint.friction)):
            x = np.geomspace(1e-9, 10.0, 20_001)
            level = curve.coulomb + (curve.stiction - curve.coulomb) * np.exp(
                -((x / curve.stribeck_velocity) ** curve.stribeck_shape)
            )
            damping = joint.damping * np.exp(-((x / curve.stribeck_velocity) ** 2))
            for bending in np.linspace(-other.stiction, curve.stiction, 41):
                torque = (slip + damping) * x * (level - bending) / (level + slip * x) + curve.viscous * x
                worst = max(worst, float(np.max(-np.diff(torque) / np.diff(x))))
        assert steepest_fall_in_a_step(joint, h) == pytest.approx(worst, rel=0.03)


def test_damping_that_would_let_friction_give_energy_is_refused():
    most = 4.0 * math.sqrt(2.0 * math.e) * 60.0 / 0.05
    assert LuGreJoint(**FIELDS, damping=0.9999 * most, solver_period=1e-4).parameters.damping == 0.9999 * most
    with pytest.raises(ValidationError, match=r"damping = 11193 N m s/rad is not allowed: it must be at most 11191\.9"):
        LuGreJoint(**FIELDS, damping=11193.0, solver_period=1e-4)
    with pytest.raises(ValidationError, match="it must be at most"):
        LuGreJoint(**FIELDS, damping=0.9999 * most, coulomb_backward=59.0, solver_period=1e-4)
    assert LuGreJoint(**{**FIELDS, "stiffness": 1e7}, solver_period=1e-5).parameters.damping == pytest.approx(most)


def test_damping_is_critical_beside_the_lesser_of_both_viscous_frictions():
    fields = {"inertia": 20.0, "coulomb": 60.0, "stiction": 90.0, "stribeck_velocity": 0.05, "stiffness": 1e4}
    both = [{"viscous": one, "viscous_backward": other} for one, other in ((10.0, 80.0), (80.0, 10.0), (80.0, 80.0))]
    first, mirrored, more = (LuGreJoint(**fields, **sides).parameters.damping for sides in both)
    assert first == mirrored == pytest.approx(more + 70.0)
