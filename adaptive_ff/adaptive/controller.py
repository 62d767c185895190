"""The adaptive controller: PI loop with feedforward from a model that is identified while it works.

At every sample the filters of the torque-form regression advance over the period that has ended; while the joint
slides, the estimator corrects its physical parameters; the model that they make is fed forward for the period
that begins, with a friction lag that the tracking error tunes; the PI loop does the rest.
"""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.adaptive.estimator import (
    SPEED_FACTOR,
    EstimatorParameters,
    EstimatorState,
    guess_friction,
    has_learnt,
    initial_estimator_state,
    learn,
    make_workspace,
)
from adaptive_ff.adaptive.lag_tuning import (
    FIRST,
    YOUNG,
    TimingState,
    advance_response,
    best_lag,
    initial_timing_state,
    lag_torque,
    learn_timing,
    note_friction,
)
from adaptive_ff.adaptive.uncertainty import assess
from adaptive_ff.model.bounds import FRICTION_LAG, INERTIA, largest_lag, torque_model, write_model
from adaptive_ff.model.feedforward import (
    FeedforwardState,
    ahead,
    exchange_model,
    initial_feedforward_state,
    step_feedforward,
)
from adaptive_ff.model.friction import ESTIMATED, TorqueModel
from adaptive_ff.model.identifying import IdentifyingController, check_parameters
from adaptive_ff.regression.sliding_gate import sliding_time
from adaptive_ff.regression.torque_form import Signals, TorqueForm, advance_signals, initial_signals, settle_signals
from controllers import (
    ESTIMATES,
    STEPS,
    Inputs,
    Output,
    PIParameters,
    PIState,
    acting_torque,
    asked_torque,
    check_gains,
    check_positive,
    delay_line,
    delayed,
    hand_over,
    initial_pi_state,
    remember,
    step_pi,
    with_feedforward,
)

if TYPE_CHECKING:
    from adaptive_ff.report.diagnosis import Diagnosis, Recorded

GATE_SHARE = 0.2
"""Speed of the gate, as a share of the Stribeck velocity."""

GATE_HOLD = 3.0
"""Hold of the gate, in time constants of the filters."""

MEMORY = 320.0
"""Default memory, in geometric means of the sampling period and the time constant of the filters."""

VISCOUS_SHARE = 0.2
"""Unit of the viscous coefficient, as a share of the proportional gain."""


LAG_UNIT = 0.01
"""Least unit of the friction lag, s: the time constant of a fast loop would be too small a unit to find the lag in."""

ONE_SIDED_SHARE = 0.1
"""Units of the offset and of what differs by direction, as a share of those of friction itself.

Until the joint has moved both ways, the offset and Coulomb friction are one number; the smaller unit, the less of it is
taken for an offset. With equal units the first seconds were worse than with the five parameters of a symmetric joint.
"""


class AdaptiveParameters(NamedTuple):
    """Parameters of the adaptive controller.

    Attributes
    ----------
    feedback : PIParameters
        The PI loop.
    estimator : EstimatorParameters
        The estimator.
    slowest : float
        Speed of the gate, rad/s.
    hold : float
        Hold of the gate, s.
    velocity_lag : float
        Time by which the measured velocity lags behind the joint's, s.
    period : float
        Nominal period, s.
    tunes_lag : bool
        Whether the lag of the feedforward is tuned by the tracking error.
    """

    feedback: PIParameters
    estimator: EstimatorParameters
    slowest: float
    hold: float
    velocity_lag: float
    period: float
    tunes_lag: bool


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
    model : Signals
        Filters over the reference and the torque of the model.
    estimator : EstimatorState
        State of the estimator.
    sliding : float
        For how long the joint has been sliding, s.
    lagged_torque : float
        Torque behind a low-pass with the lag of the measured velocity, N m.
    model_torques, known_torques : tuple of float
        Torque of the model, and torque known from elsewhere, N m, the newest first, as far back as the drive may still
        apply them.
    timing : TimingState
        State of the tuning of the feedforward's lag.
    enabled : bool
        Whether the estimates adapt.
    """

    feedback: PIState
    feedforward: FeedforwardState
    measured: Signals
    model: Signals
    estimator: EstimatorState
    sliding: float
    lagged_torque: float
    model_torques: tuple[float, ...]
    known_torques: tuple[float, ...]
    timing: TimingState
    enabled: bool


def initial_adaptive_state(block: AdaptiveParameters) -> AdaptiveState:
    """Return the state of a controller that knows nothing but the assumed inertia."""
    return AdaptiveState(
        initial_pi_state(block.feedback),
        initial_feedforward_state(),
        initial_signals(block.estimator.first.size),
        initial_signals(block.estimator.first.size),
        initial_estimator_state(block.estimator),
        -block.hold,  # the filters start from a guess: hold twice as long
        0.0,
        delay_line(block.feedback.delay),
        delay_line(block.feedback.delay),
        initial_timing_state(block.feedback, float(block.estimator.first[FRICTION_LAG])),
        True,
    )


@register_jitable(forceinline=True)
def fed_model(block: AdaptiveParameters, state: AdaptiveState, lag: float) -> TorqueModel:
    """Return the model that is fed forward: the identified one with a lag (s) of its own."""
    form = block.estimator.form
    return torque_model(state.estimator.estimate, lag, form.stribeck_velocity, form.stribeck_shape)


@register_jitable(forceinline=True)
def identified_model(block: AdaptiveParameters, state: AdaptiveState) -> TorqueModel:
    """Return the model as it is identified now."""
    return fed_model(block, state, state.estimator.estimate[FRICTION_LAG])


@register_jitable(forceinline=True)
def tune_lag(block: AdaptiveParameters, state: AdaptiveState, inputs: Inputs) -> TimingState:
    """Return the state of the lag's tuning after the period that has ended."""
    timing, estimator, learnt = state.timing, block.estimator, state.estimator.levels[3]
    timing = advance_response(timing, block.feedback, estimator.first[INERTIA], block.velocity_lag, inputs.dt)
    error = inputs.reference + inputs.correction - inputs.velocity  # what the feedback sees
    believable = abs(error) < SPEED_FACTOR * state.estimator.levels[2]
    if state.enabled and believable and learnt > FIRST * estimator.memory:
        learn_timing(timing, error, learnt, estimator.memory, inputs.dt)
    return timing


@register_jitable(forceinline=True)
def learn_bumpless(
    block: AdaptiveParameters,
    state: AdaptiveState,
    measured: Signals,
    model: Signals,
    lag: float,
    inputs: Inputs,
    learns: bool,
) -> tuple[float, FeedforwardState, PIState, float]:
    """Learn, or guess before there is anything to learn, and hand over to the feedforward what that adds to it.

    What is fed forward so far has the given lag (s); the new one is returned last.

    The integral holds what the feedforward did not give so far. Without the hand-over both would give it for a while.
    """
    reference, following, delay = inputs.reference, inputs.next_reference, block.feedback.delay
    start, _ = ahead(state.feedforward, reference, following, delay)
    old = fed_model(block, state, lag)
    before, _ = step_feedforward(old, state.feedforward, reference, following, block.period, delay, inputs.inertia)
    if learns:
        learn(block.estimator, state.estimator, measured, model, inputs.dt)
    else:
        guess_friction(block.estimator, state.estimator, measured, model)
    identified, largest = state.estimator.estimate[FRICTION_LAG], block.estimator.work.ranges[FRICTION_LAG, 1]
    young = state.estimator.levels[3] < YOUNG * block.estimator.memory
    lag = best_lag(state.timing, identified, largest, block.period, young)
    new = fed_model(block, state, lag)
    feedforward = exchange_model(state.feedforward, old, new, start)
    after, feedforward = step_feedforward(new, feedforward, reference, following, block.period, delay, inputs.inertia)
    return after, feedforward, hand_over(block.feedback, state.feedback, after - before), lag


@register_jitable(forceinline=True)
def step_adaptive(block: AdaptiveParameters, state: AdaptiveState, inputs: Inputs) -> tuple[Output, AdaptiveState]:
    """Do one sample: learn from the period that ends, feed forward for the one that begins, then feedback.

    With a computation delay the period that the feedforward is for begins later, and the torques that belong to the one
    that ends were computed earlier.
    """
    valid, delay = math.isfinite(inputs.velocity), block.feedback.delay
    velocity = inputs.velocity if valid else state.feedback.velocity
    form = block.estimator.form
    measured, model = state.measured, state.model
    if state.feedback.samples == 0:
        measured = settle_signals(form, measured, velocity)
        model = settle_signals(form, model, inputs.reference)
    acting = acting_torque(inputs, asked_torque(block.feedback, state.feedback), delayed(state.known_torques, delay))
    lagged_torque = state.lagged_torque
    if block.velocity_lag > 0.0:  # what the velocity shows now is what the torque did a while ago
        acting, lagged_torque = lag_torque(block.velocity_lag, lagged_torque, acting, inputs.dt)
    measured = advance_signals(form, measured, acting, velocity, inputs.dt)
    model = advance_signals(form, model, delayed(state.model_torques, delay), inputs.reference, inputs.dt)
    sliding = sliding_time(state.sliding, velocity, inputs.reference, valid, block.slowest, inputs.dt)
    feedback, timing, learns = state.feedback, state.timing, sliding > block.hold
    if block.tunes_lag:
        timing = tune_lag(block, state, inputs)
    lag = timing.lag
    if state.enabled and (learns or (valid and not has_learnt(state.estimator))):
        torque, feedforward, feedback, lag = learn_bumpless(block, state, measured, model, lag, inputs, learns)
    else:
        torque, feedforward = step_feedforward(
            fed_model(block, state, lag),
            state.feedforward,
            inputs.reference,
            inputs.next_reference,
            block.period,
            delay,
            inputs.inertia,
        )
    output, feedback = step_pi(block.feedback, feedback, with_feedforward(inputs, torque))
    return output, AdaptiveState(
        feedback,
        feedforward,
        measured,
        model,
        state.estimator,
        sliding,
        lagged_torque,
        remember(state.model_torques, torque),
        remember(state.known_torques, inputs.feedforward),
        note_friction(timing, state.feedforward.friction, feedforward.friction, lag, block.period),
        state.enabled,
    )


@register_jitable(forceinline=True)
def write_adaptive(block: AdaptiveParameters, state: AdaptiveState, row: NDArray[np.float64]) -> None:
    """Write the physical estimates into a row."""
    write_model(identified_model(block, state), row)


STEPS[AdaptiveParameters] = step_adaptive
ESTIMATES[AdaptiveParameters] = write_adaptive


def default_memory(period: float, pole: float) -> float:
    """Return the memory (s of sliding motion) that suits a sampling period (s) and a pole of the filters (rad/s).

    The more samples there are in a second and the faster the filters, the more equations average the noise. The factor
    suited loops of 5 and 10 Hz at 1 kHz, 100 Hz and 22 ms (seeds from 101 on).
    """
    return MEMORY * math.sqrt(period / pole)


class AdaptiveController(IdentifyingController):
    """PI loop with feedforward from a model identified online.

    The first estimate is a frictionless joint of the assumed inertia, with a friction lag equal to the time constant
    ``J/Kp`` of the feedback; lags that are much shorter hardly matter to the loop.

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
        Memory of the estimator, s of sliding motion: an equation counts ``exp(-age/memory)``. By default what
        :func:`default_memory` says.
    filter_pole : float, optional
        Pole of the regression's filters, rad/s; by default the crossover of the feedback, ``Kp/J``.
    parameters : sequence of str, optional
        What is identified: ``model.ESTIMATED`` by default; ``model.WITH_OFFSET`` for a joint with a constant load or
        with Coulomb friction that differs by direction; ``model.PER_DIRECTION`` where all friction may.
    delay : float, optional
        Computation delay of the drive, sampling periods. What ``step`` is told as ``feedforward`` is, as the torque
        that it returns, of the period in which the drive will apply it.
    velocity_lag : float, optional
        Time by which the measured velocity lags behind the joint's, s, such as half a period of a difference of
        positions plus the time constant of a low-pass behind it.
    tunes_lag : bool, optional
        Whether the lag of the feedforward is tuned by the tracking error, beyond the identified friction lag; see
        :mod:`timing`. For a controller that only watches another one's motion it must be false.

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
        memory: float | None = None,
        filter_pole: float | None = None,
        parameters: Sequence[str] = ESTIMATED,
        delay: float = 0.0,
        velocity_lag: float = 0.0,
        tunes_lag: bool = True,
    ) -> None:
        feedback = check_gains(proportional, integral, delay)
        self.estimate_names = check_parameters(parameters)
        check_positive(
            proportional=proportional,
            inertia=inertia,
            stribeck_velocity=stribeck_velocity,
            stribeck_shape=stribeck_shape,
            period=period,
        )
        pole = proportional / inertia if filter_pole is None else filter_pole
        check_positive(filter_pole=pole)
        memory = default_memory(period, pole) if memory is None else memory
        check_positive(memory=memory)
        if not 0.0 <= velocity_lag < math.inf:
            raise ValueError(f"velocity_lag = {velocity_lag} s is not allowed: it must be zero or more and finite")
        torque_scale = proportional * stribeck_velocity
        response = inertia / proportional
        slope = VISCOUS_SHARE * proportional
        size = len(self.estimate_names)
        one_sided = [ONE_SIDED_SHARE * unit for unit in (torque_scale, torque_scale, slope)]
        scale = [inertia, torque_scale, torque_scale, slope, max(response, LAG_UNIT), *one_sided]
        estimator = EstimatorParameters(
            TorqueForm(float(pole), float(stribeck_velocity), float(stribeck_shape)),
            np.array([inertia, 0.0, 0.0, 0.0, response, 0.0, 0.0, 0.0])[:size],
            np.array(scale)[:size],
            float(torque_scale),
            float(memory),
            make_workspace(inertia, largest_lag(response), size),
        )
        block = AdaptiveParameters(
            feedback,
            estimator,
            GATE_SHARE * float(stribeck_velocity),
            GATE_HOLD / float(pole),
            float(velocity_lag),
            float(period),
            bool(tunes_lag),
        )
        super().__init__(block, period, initial_adaptive_state)

    @property
    def uncertainties(self) -> dict[str, float]:
        """How far each estimate may be off, as a standard deviation, by name; see ``confidence`` for its limits."""
        errors = assess(self.parameters.estimator, self.state.estimator, self.parameters.period).errors
        return dict(zip(self.estimate_names, errors.tolist(), strict=True))

    @property
    def feedforward_lag(self) -> float:
        """Friction lag that the feedforward is computed with, s: the identified one, tuned by the tracking error."""
        return float(self.state.timing.lag)

    def diagnose(self, run: "Recorded | None" = None) -> "Diagnosis":
        """Tell what the controller learns and how sure it is, for a terminal; see :func:`diagnosis.diagnose`."""
        from adaptive_ff.report.diagnosis import diagnose

        return diagnose(self, run)
