"""The adaptive controller: PI loop with feedforward from a model that is identified while it works.

At every sample the filters of the torque-form regression advance twice: once over what was measured, once over what the
reference and the model say (the instrument, which no noise touches). While the joint slides, the error of the
regression corrects the five physical parameters

    u_f ~ J (w'_f + tau w''_f) + Fc g_f + Fs h_f + sigma w_f - tau u'_f

The form is linear in six parameters, of which ``J tau`` is the product of two others; here the five are estimated
themselves, with the gradient of the form at the present estimate (Gauss-Newton). That removes the one direction
in which closed-loop data hardly determine the six: ``tau`` times the rate of friction.
"""

import math
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.feedforward import FeedforwardState, initial_feedforward_state, step_feedforward
from adaptive_ff.gate import sliding_time
from adaptive_ff.identifying import IdentifyingController, check_positive
from adaptive_ff.model import ESTIMATED
from adaptive_ff.physical import FRICTION_LAG, INERTIA, LARGEST_LAG, confine, torque_model, write_model
from adaptive_ff.resetting import update_resetting
from adaptive_ff.torque_form import (
    Signals,
    TorqueForm,
    advance_signals,
    initial_signals,
    settle_signals,
    write_regressors,
)
from controllers import (
    ESTIMATES,
    STEPS,
    Inputs,
    Output,
    PIParameters,
    PIState,
    check_gains,
    initial_pi_state,
    step_pi,
    with_feedforward,
)

GATE_SHARE = 0.2
"""Speed of the gate, as a share of the Stribeck velocity."""

GATE_HOLD = 3.0
"""Hold of the gate, in time constants of the filters."""

FLOOR = 3e-5
"""Floor of the information, in units of the scaled regressors squared."""

PRIOR = 3e-3
"""Information at the start, in units of the scaled regressors squared times seconds."""

PARAMETERS = len(ESTIMATED)


class AdaptiveParameters(NamedTuple):
    """Parameters of the adaptive controller.

    Attributes
    ----------
    feedback : PIParameters
        The PI loop.
    form : TorqueForm
        The regression.
    inertia : float
        Inertia that the feedback was designed for, kg m^2: the first estimate.
    scale : ndarray, shape (5,)
        Unit in which each parameter is estimated, of its expected size.
    torque_scale : float
        Unit of torque, N m.
    largest_lag : float
        Largest friction lag, s.
    slowest : float
        Speed of the gate, rad/s.
    memory : float
        Memory of the estimator, s of sliding motion.
    period : float
        Nominal period, s.
    """

    feedback: PIParameters
    form: TorqueForm
    inertia: float
    scale: NDArray[np.float64]
    torque_scale: float
    largest_lag: float
    slowest: float
    memory: float
    period: float


class AdaptiveState(NamedTuple):
    """State of the adaptive controller.

    Attributes
    ----------
    feedback : PIState
        State of the PI loop.
    feedforward : FeedforwardState
        State of the feedforward.
    measured : Signals
        Filters over the measurements.
    instrument : Signals
        Filters over reference and model.
    estimate : ndarray, shape (5,)
        Inertia, Coulomb friction, stiction, viscous coefficient, friction lag; changed in place.
    information : ndarray, shape (5, 5)
        Information matrix; changed in place.
    sliding : float
        For how long the joint has been sliding, s.
    model_torque : float
        Feedforward torque of the model in the last period, N m.
    known_torque : float
        Torque known from elsewhere in the last period, N m.
    enabled : bool
        Whether the estimates adapt.
    """

    feedback: PIState
    feedforward: FeedforwardState
    measured: Signals
    instrument: Signals
    estimate: NDArray[np.float64]
    information: NDArray[np.float64]
    sliding: float
    model_torque: float
    known_torque: float
    enabled: bool


def initial_adaptive_state(block: AdaptiveParameters) -> AdaptiveState:
    """Return the state of a controller that knows nothing but the assumed inertia."""
    return AdaptiveState(
        initial_pi_state(block.feedback),
        initial_feedforward_state(),
        initial_signals(),
        initial_signals(),
        np.array([block.inertia, 0.0, 0.0, 0.0, 0.0]),
        np.eye(PARAMETERS) * (PRIOR / block.memory + FLOOR),
        -GATE_HOLD / block.form.pole,  # the filters start from a guess: hold twice as long
        0.0,
        0.0,
        True,
    )


@register_jitable
def learn(block: AdaptiveParameters, state: AdaptiveState, measured: Signals, instrument: Signals, dt: float) -> None:
    """Correct the estimate by one equation of the regression."""
    x = np.empty(6)
    z = np.empty(6)
    torque = write_regressors(block.form, measured, x)
    write_regressors(block.form, instrument, z)
    estimate = state.estimate
    inertia = estimate[INERTIA]
    lag = estimate[FRICTION_LAG]
    prediction = inertia * (x[1] + lag * x[0]) + lag * x[5]
    for i in range(1, PARAMETERS - 1):
        prediction += estimate[i] * x[i + 1]
    gradient = np.empty(PARAMETERS)
    gradient[INERTIA] = z[1] + lag * z[0]
    for i in range(1, PARAMETERS - 1):
        gradient[i] = z[i + 1]
    gradient[FRICTION_LAG] = inertia * z[0] + z[5]
    for i in range(PARAMETERS):
        gradient[i] *= block.scale[i] / block.torque_scale
    correction = np.empty(PARAMETERS)
    update_resetting(
        state.information,
        FLOOR,
        math.exp(-dt / block.memory),
        gradient,
        (torque - prediction) / block.torque_scale,
        correction,
        np.empty((PARAMETERS, PARAMETERS)),
    )
    for i in range(PARAMETERS):
        estimate[i] += correction[i] * block.scale[i]
    confine(estimate, block.inertia, block.largest_lag)


@register_jitable
def step_adaptive(block: AdaptiveParameters, state: AdaptiveState, inputs: Inputs) -> tuple[Output, AdaptiveState]:
    """Do one sample: learn from the period that ends, feed forward for the one that begins, then feedback."""
    valid = math.isfinite(inputs.velocity)
    velocity = inputs.velocity if valid else state.feedback.velocity
    realised = inputs.realised_torque if math.isfinite(inputs.realised_torque) else state.feedback.command
    realised -= state.known_torque
    measured, instrument = state.measured, state.instrument
    if state.feedback.samples == 0:
        measured = settle_signals(block.form, measured, velocity)
        instrument = settle_signals(block.form, instrument, inputs.reference)
    measured = advance_signals(block.form, measured, realised, velocity, inputs.dt)
    instrument = advance_signals(block.form, instrument, state.model_torque, inputs.reference, inputs.dt)
    sliding = sliding_time(state.sliding, velocity, inputs.reference, valid, block.slowest, inputs.dt)
    if state.enabled and sliding * block.form.pole > GATE_HOLD:
        learn(block, state, measured, instrument, inputs.dt)
    model = torque_model(state.estimate, block.form.stribeck_velocity, block.form.stribeck_shape)
    torque, feedforward = step_feedforward(
        model, state.feedforward, inputs.reference, inputs.next_reference, block.period
    )
    output, feedback = step_pi(block.feedback, state.feedback, with_feedforward(inputs, torque))
    return output, AdaptiveState(
        feedback,
        feedforward,
        measured,
        instrument,
        state.estimate,
        state.information,
        sliding,
        torque,
        inputs.feedforward,
        state.enabled,
    )


@register_jitable
def write_adaptive(block: AdaptiveParameters, state: AdaptiveState, row: NDArray[np.float64]) -> None:
    """Write the physical estimates into a row."""
    write_model(torque_model(state.estimate, block.form.stribeck_velocity, block.form.stribeck_shape), row)


STEPS[AdaptiveParameters] = step_adaptive
ESTIMATES[AdaptiveParameters] = write_adaptive


class AdaptiveController(IdentifyingController):
    """PI loop with feedforward from a model identified online.

    Parameters
    ----------
    proportional, integral : float
        Gains of the PI loop, N m s/rad and N m/rad.
    period : float
        Nominal sampling period, s.
    inertia : float
        Inertia that the feedback was designed for, kg m^2; it may be wrong.
    stribeck_velocity : float
        Stribeck velocity, rad/s, pre-estimated; it may be wrong.
    stribeck_shape : float, optional
        Stribeck shape factor, pre-estimated.
    memory : float, optional
        Memory of the estimator, s of sliding motion: an equation counts ``exp(-age/memory)``.
    filter_pole : float, optional
        Pole of the regression's filters, rad/s; by default the crossover of the feedback, ``Kp/J``.

    Raises
    ------
    ValueError
        A value is out of range.

    Examples
    --------
    >>> from adaptive_ff import AdaptiveController
    >>> from controllers import PI
    >>> design = PI.design(inertia=20.0, period=0.01, bandwidth=10.0)
    >>> controller = AdaptiveController(
    ...     design.proportional, design.integral, period=0.01, inertia=20.0, stribeck_velocity=0.05
    ... )
    >>> torque = controller.step(0.1, 0.0, next_reference=0.101)
    >>> controller.estimates["coulomb"]
    0.0
    """

    def __init__(
        self,
        proportional: float,
        integral: float,
        period: float,
        *,
        inertia: float,
        stribeck_velocity: float,
        stribeck_shape: float = 1.0,
        memory: float = 5.0,
        filter_pole: float | None = None,
    ) -> None:
        feedback = check_gains(proportional, integral)
        check_positive(
            proportional=proportional,
            inertia=inertia,
            stribeck_velocity=stribeck_velocity,
            stribeck_shape=stribeck_shape,
            memory=memory,
        )
        pole = proportional / inertia if filter_pole is None else filter_pole
        check_positive(filter_pole=pole)
        torque_scale = proportional * stribeck_velocity
        scale = [inertia, torque_scale, torque_scale, proportional / 5.0, inertia / proportional]
        parameters = AdaptiveParameters(
            feedback,
            TorqueForm(float(pole), float(stribeck_velocity), float(stribeck_shape)),
            float(inertia),
            np.array(scale, dtype=float),
            float(torque_scale),
            LARGEST_LAG * inertia / proportional,
            GATE_SHARE * float(stribeck_velocity),
            float(memory),
            float(period),
        )
        super().__init__(parameters, period, initial_adaptive_state)
