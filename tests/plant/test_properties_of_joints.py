"""What holds of every friction law and of every step, whatever the kind of joint.

And how the rigid joint's step converges in the solver period, to a solution from event to event. Without friction lag
it is of first order through stops and breakaways, too. With a lag the joint bounces about zero velocity before it
rests: there only means converge with first order, single velocities with about the square root.
"""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenario_files import factor_of, in_other_units
from stepped_joint import motion, run
from test_kinds import MODELS, TORQUES

from plant import SENSED_VELOCITY, STEP_JOINT, JointParameters, JointState, Stribeck, initial_state

PROMPT = {
    name: type(model)(**{**model.model_dump(), "friction_lag": 0.0}) if "friction_lag" in model.model_dump() else model
    for name, model in MODELS.items()
}
"""The same joints without a friction lag: friction that lags can give back energy at a reversal."""

HELD = 10
"""Steps that a torque is held for."""

torques = st.lists(st.floats(-300.0, 300.0), min_size=1, max_size=20)
every = pytest.mark.parametrize("kind", MODELS)


def stepped(model, forces, velocity=0.0):
    """Torque, state before and state after each step."""
    parameters, state = model.parameters, initial_state(model.parameters, velocity)
    step = STEP_JOINT[type(parameters)]
    for torque in forces:
        after = step(parameters, state, torque, model.solver_period)
        yield torque, state, after
        state = after


def inertias(model):
    """Inertia of each side, kg m^2, by the velocity that it has."""
    parameters = model.parameters
    if hasattr(parameters, "link_inertia"):
        return {"velocity": parameters.link_inertia, "motor_velocity": parameters.motor_inertia}
    return {"velocity": parameters.inertia}


@every
@settings(max_examples=20)
@given(forces=torques)
def test_friction_takes_energy_and_gives_none(kind, forces):
    """From rest, the work done at the motor against friction and inertia is never less than the energy of motion.

    The spring of a gear is stepped by the trapezoidal rule, so work is done at the mean velocity of a step there.
    """
    model = PROMPT[kind]
    model = type(model)(**{**model.model_dump(), "offset": 0.0})
    mean = 0.5 if "motor_velocity" in inertias(model) else 0.0
    work = size = 0.0
    for torque, state, after in stepped(model, [one for one in forces for _ in range(HELD)]):
        before, now = (SENSED_VELOCITY[type(state)](one) for one in (state, after))
        work += model.solver_period * torque * (now + mean * (before - now))
        size += model.solver_period * abs(torque * now)
        kinetic = sum(0.5 * J * getattr(after, name) ** 2 for name, J in inertias(model).items())
        assert work >= kinetic - 1e-9 * size - 1e-12


@every
def test_motion_is_the_same_in_other_units(kind):
    """With scales that are powers of two every digit is the same, so that no constant with a unit can hide."""
    model, scales = MODELS[kind], (4.0, 16.0, 1024.0)
    other = type(model)(**in_other_units(model.model_dump(), scales))
    torque = scales[0]
    for (_, _, after), (_, _, found) in zip(
        stepped(model, TORQUES[:700], 0.125),
        stepped(other, torque * TORQUES[:700], 0.125 * scales[2] / scales[1]),
        strict=True,
    ):
        for name, value in after._asdict().items():
            expected = value * factor_of("", name, scales)
            assert getattr(found, name) == pytest.approx(expected, rel=1e-9, abs=1e-12 * abs(expected)), name
    assert math.isfinite(value)


STRIBECK = Stribeck(60.0, 90.0, 80.0, 0.05, 1.0)
PERIODS = (1e-3, 5e-4, 2.5e-4, 1.25e-4)
GRID = 1e-3


def velocities(joint, torques, period):
    return run(joint, JointState(0.0, 0.0, 0.0), torques, period)[:, 0]


def sines(*waves):
    """Torque, and its slope, that is a sum of sines of amplitudes (N m) and frequencies (Hz)."""

    def torque(time):
        return sum(size * np.sin(2.0 * math.pi * frequency * time) for size, frequency in waves)

    def slope(time):
        return sum(
            size * 2.0 * math.pi * frequency * math.cos(2.0 * math.pi * frequency * time) for size, frequency in waves
        )

    return torque, slope


def beside_the_exact_motion(lag, duration, *waves):
    """Exact velocities on a grid, and for each period those of the step there."""
    joint = JointParameters(20.0, STRIBECK, STRIBECK, 0.0, lag)
    torque, slope = sines(*waves)
    grid = GRID * np.arange(round(duration / GRID))
    exact = motion(joint, torque, slope, duration, grid)
    own = [
        velocities(joint, torque(h * np.arange(1, round(duration / h) + 1)), h)[: -1 : round(GRID / h)] for h in PERIODS
    ]
    assert np.mean(np.abs(exact) < 1e-6) > 0.05  # it rests
    assert np.ptp(np.sign(exact)) == 2.0
    return exact, own


def test_without_lag_every_velocity_converges_with_first_order_through_stops_and_breakaways():
    exact, own = beside_the_exact_motion(0.0, 2.0, (120.0, 1.0))
    errors = [np.max(np.abs(velocity - exact)) for velocity in own]
    assert errors[0] < 3e-3
    assert np.log2(np.divide(errors[:-1], errors[1:])) == pytest.approx(1.0, abs=0.05)


def test_with_lag_means_converge_with_first_order_and_single_velocities_slower():
    exact, own = beside_the_exact_motion(0.02, 2.0, (110.0, 0.5), (20.0, 1.7))
    size = math.sqrt(np.mean(np.square(exact)))
    means = [math.sqrt(np.mean(np.square(velocity))) / size - 1.0 for velocity in own]
    assert abs(means[0]) < 1e-3
    assert np.log2(np.divide(means[:-1], means[1:])) == pytest.approx(1.0, abs=0.1)
    errors = [np.max(np.abs(velocity - exact)) for velocity in own]
    assert errors[0] < 0.015
    order = math.log2(errors[0] / errors[-1]) / 3.0
    assert 0.3 < order < 0.8  # about one half; first order would be a model without bounces
