"""What holds of every friction law and of every step, whatever the kind of joint."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenario_files import factor_of, in_other_units
from test_kinds import MODELS, TORQUES

from plant import SENSED_VELOCITY, STEP_JOINT, initial_state

PROMPT = {
    name: type(model)(**{**model.model_dump(), "friction_lag": 0.0}) if "friction_lag" in model.model_dump() else model
    for name, model in MODELS.items()
}
"""The same joints without a friction lag: friction that lags can give back energy at a reversal."""

HELD = 10
"""Steps that a torque is held for."""

torques = st.lists(st.floats(-300.0, 300.0), min_size=1, max_size=20)
every = pytest.mark.parametrize("kind", MODELS)


def motion(model, forces, velocity=0.0):
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
    for torque, state, after in motion(model, [one for one in forces for _ in range(HELD)]):
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
        motion(model, TORQUES[:700], 0.125),
        motion(other, torque * TORQUES[:700], 0.125 * scales[2] / scales[1]),
        strict=True,
    ):
        for name, value in after._asdict().items():
            expected = value * factor_of("", name, scales)
            assert getattr(found, name) == pytest.approx(expected, rel=1e-9, abs=1e-12 * abs(expected)), name
    assert math.isfinite(value)
