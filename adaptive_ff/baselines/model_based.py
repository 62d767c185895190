"""PI loop with a feedforward from a model that is assumed, not identified.

One kernel serves inertia feedforward (a model without friction), feedforward from fixed parameters (nominal, stale,
true) and the oracle, which assumes the true parameters of every moment.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.adaptive.supervision.observer import plan_as_measured
from adaptive_ff.friction.feedforward import (
    FeedforwardState,
    initial_feedforward_state,
    is_plan_at_rest,
    released,
    step_feedforward,
)
from adaptive_ff.friction.model import TorqueModel, checked_model
from adaptive_ff.friction.turning import Turning, turning_of
from controllers import (
    ESTIMATES,
    INLINED,
    STEPS,
    Controller,
    Inputs,
    Output,
    PIParameters,
    PIState,
    check_gains,
    feed_back,
    initial_pi_state,
    plausible_inputs,
    with_feedforward,
    with_reference,
    without_estimates,
)
from controllers.checks import check_numbers, check_velocity_lag

FIELDS = len(TorqueModel._fields)


class ModelBasedParameters(NamedTuple):
    """Parameters of the loop with an assumed model.

    Attributes
    ----------
    feedback : PIParameters
        The PI loop.
    model : TorqueModel
        The joint.
    turning : Turning
        When a reversed reference turns the friction of this model.
    times : ndarray, shape (changes,)
        When the model changes, s, ascending.
    models : ndarray, shape (changes * fields,)
        Fields of the model from each of these times on, one model after the other.
    gravity, gravity_phase : float
        Torque ``gravity sin(q + gravity_phase)`` of a weight along the planned position ``q``, N m and rad.
    ripple, ripple_waves : float
        Ripple ``ripple sin(ripple_waves q)`` of the drive at the measured position ``q``, N m and 1/rad; at the planned
        one where none is measured.
    period : float
        Nominal period, s.
    velocity_lag : float
        Time by which the measured velocity lags behind the joint's, s.
    held : float
        Share of what a joint at rest would hold of its friction that this one holds.
    """

    feedback: PIParameters
    model: TorqueModel
    turning: Turning
    times: NDArray[np.float64]
    models: NDArray[np.float64]
    gravity: float
    gravity_phase: float
    ripple: float
    ripple_waves: float
    period: float
    velocity_lag: float
    held: float


class ModelBasedState(NamedTuple):
    """State of the loop with an assumed model.

    Attributes
    ----------
    feedback : PIState
        State of the PI loop.
    feedforward : FeedforwardState
        State of the feedforward.
    time : float
        Time since the first sample, s.
    position : float
        Integral of the reference since then, rad.
    seen : float
        Last reference as the measured velocity shows it, rad/s.
    """

    feedback: PIState
    feedforward: FeedforwardState
    time: float
    position: float
    seen: float


def initial_model_based_state(parameters: ModelBasedParameters) -> ModelBasedState:
    """Return the state of the loop at rest."""
    return ModelBasedState(initial_pi_state(parameters.feedback), initial_feedforward_state(), 0.0, 0.0, 0.0)


@register_jitable
def model_in_row(models: NDArray[np.float64], row: int) -> TorqueModel:
    """Return one of the models that stand one after the other in an array."""
    first = FIELDS * row
    return TorqueModel(
        inertia=models[first],
        coulomb=models[first + 1],
        stiction=models[first + 2],
        viscous=models[first + 3],
        friction_lag=models[first + 4],
        stribeck_velocity=models[first + 5],
        stribeck_shape=models[first + 6],
        offset=models[first + 7],
        stiction_asymmetry=models[first + 8],
        viscous_asymmetry=models[first + 9],
        presliding=models[first + 10],
        micro_damping=models[first + 11],
    )


@register_jitable
def step_model_based(
    block: ModelBasedParameters, state: ModelBasedState, inputs: Inputs
) -> tuple[Output, ModelBasedState]:
    """Do one sample: feedforward of the model as it is now, then feedback.

    The feedback compares the measured velocity with the plan behind the same lag; else it would brake where the
    feedforward accelerates.
    """
    inputs, guard = plausible_inputs(block.feedback, state.feedback, inputs)
    time, position, seen = 0.0, 0.0, inputs.reference
    if state.feedback.samples > 0:
        time = state.time + inputs.dt
        position = state.position + 0.5 * inputs.dt * (state.feedforward.reference + inputs.reference)
        if block.velocity_lag > 0.0:
            seen = plan_as_measured(block.velocity_lag, state.seen, inputs.reference, inputs.dt)
    acting = time + block.feedback.delay * block.period
    model, turning = block.model, block.turning
    for change in range(block.times.size):
        if acting >= block.times[change] - 0.5 * block.period:  # in force for most of the period to come
            model = model_in_row(block.models, change)
            turning = turning_of(model, model.inertia, block.feedback.proportional, block.period)
    torque, feedforward = step_feedforward(
        model,
        state.feedforward,
        inputs,
        block.period,
        block.feedback.delay,
        inputs.inertia,
        turning.speed,
        turning.path,
    )
    if block.held < 1.0 and is_plan_at_rest(state.feedforward, inputs, block.feedback.delay):
        feedforward = released(model, feedforward, block.held, inputs.dt)
    turn = (block.feedback.delay + 0.5) * block.period * inputs.reference  # to the middle of the coming period
    if block.gravity > 0.0:
        torque += block.gravity * math.sin(position + turn + block.gravity_phase)
    if block.ripple > 0.0:
        there = inputs.position if math.isfinite(inputs.position) else position
        torque -= block.ripple * math.sin(block.ripple_waves * (there + turn))
    compared = with_reference(with_feedforward(inputs, torque), seen)
    output, feedback = feed_back(block.feedback, state.feedback, compared, guard)
    return output, ModelBasedState(feedback, feedforward, time, position, seen)


STEPS[ModelBasedParameters] = step_model_based
ESTIMATES[ModelBasedParameters] = without_estimates
INLINED.add(ModelBasedParameters)


class ModelBased(Controller):
    """``u = PI(e) + J dr/dt + f(r) + offset`` with a friction model of given parameters.

    ``e = reference + correction - velocity``; ``r`` is the plan alone.

    Parameters
    ----------
    proportional, integral : float
        Gains of the PI loop, N m s/rad and N m/rad.
    period : float
        Nominal sampling period, s.
    model : TorqueModel
        The joint that the feedforward assumes.
    changes : sequence of (float, TorqueModel), optional
        Times (s) and models from then on, in ascending order of time.
    gravity : (float, float), optional
        Amplitude (N m) and phase (rad) of the torque of a weight along the planned position, zero at the start.
    ripple : (float, float), optional
        Amplitude (N m) and period (rad) of a ripple of the drive, a sine of the measured position.
    delay : float, optional
        Computation delay of the drive, sampling periods.
    velocity_lag : float, optional
        Time by which the measured velocity lags behind the joint's, s; see :func:`controllers.low_pass_lag`.
    held : float, optional
        Share, 0 to 1, of the friction that is held at rest, see :func:`adaptive_ff.friction.feedforward.released`: zero
        for a joint that creeps.
    """

    def __init__(
        self,
        proportional: float,
        integral: float,
        period: float,
        model: TorqueModel,
        changes: Sequence[tuple[float, TorqueModel]] = (),
        *,
        gravity: tuple[float, float] = (0.0, 0.0),
        ripple: tuple[float, float] = (0.0, 1.0),
        delay: float = 0.0,
        velocity_lag: float = 0.0,
        held: float = 1.0,
    ) -> None:
        if not 0.0 <= held <= 1.0:
            raise ValueError(f"held = {held} is not allowed: it must be from 0 to 1")
        feedback, assumed = check_gains(proportional, integral, period, delay), checked_model("model", model)
        check_velocity_lag(velocity_lag, period)
        for place, (time, changed) in enumerate(changes):
            check_numbers(**{f"changes[{place}] time": time})
            checked_model(f"changes[{place}]", changed)
        parameters = ModelBasedParameters(
            feedback=feedback,
            model=assumed,
            turning=turning_of(assumed, assumed.inertia, feedback.proportional, float(period)),
            times=np.array([time for time, _ in changes], dtype=float),
            models=np.array([value for _, changed in changes for value in changed], dtype=float),
            gravity=float(gravity[0]),
            gravity_phase=float(gravity[1]),
            ripple=float(ripple[0]),
            ripple_waves=2.0 * math.pi / float(ripple[1]),
            period=float(period),
            velocity_lag=float(velocity_lag),
            held=float(held),
        )
        super().__init__(parameters, period, initial_model_based_state)
