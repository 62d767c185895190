"""The paper's identification in a closed loop: recursive least squares on (4), fed forward.

The estimator is the paper's: all samples count, sliding or not; nothing is filtered; Vs and delta are assumed. The
torque ``u(k)`` is the one realised over the period that ends at ``k``, the newest that is known then. What the paper
leaves open, how the model is fed forward, is done as in the adaptive controller, with the same bounds on the
estimates. Where the covariance grows beyond a bound (standstill), forgetting pauses; the paper has no such bound.

It begins with the same covariance for every coefficient, whatever its unit: how fast it learns depends on the units of
torque and velocity.
"""

import math
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.friction.bounds import (
    FRICTION_LAG,
    confine_in_place,
    largest_lag,
    possible_ranges,
    torque_model,
    write_model,
)
from adaptive_ff.friction.feedforward import FeedforwardState, initial_feedforward_state, step_feedforward
from adaptive_ff.friction.identifying import IdentifyingController
from adaptive_ff.friction.model import ESTIMATED, TorqueModel
from adaptive_ff.learning.rls import (
    RLSState,
    begin_anew_in_place,
    initial_rls_state,
    trace,
    update_rls_in_place,
)
from adaptive_ff.learning.series import COEFFICIENTS, series_regressors, write_physical
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
    feed_back,
    initial_pi_state,
    plausible_inputs,
    remember,
    with_feedforward,
)
from controllers.arrays import MutableArray

INITIAL_COVARIANCE = 1e4
LARGEST_COVARIANCE = 1e8


class PaperParameters(NamedTuple):
    """Parameters of the controller.

    Attributes
    ----------
    feedback : PIParameters
        The PI loop.
    stribeck_velocity, stribeck_shape : float
        Pre-estimated ``Vs`` (rad/s) and ``delta``.
    inertia : float
        Inertia that the feedback was designed for, kg m^2.
    ranges : ndarray, shape (5, 2)
        Least and largest possible value of each physical parameter.
    forgetting_factor : float
        ``lambda``.
    period : float
        Sampling period, s.
    """

    feedback: PIParameters
    stribeck_velocity: float
    stribeck_shape: float
    inertia: float
    ranges: NDArray[np.float64]
    forgetting_factor: float
    period: float


class PaperState(NamedTuple):
    """State of the controller.

    Attributes
    ----------
    feedback : PIState
        State of the PI loop.
    feedforward : FeedforwardState
        State of the feedforward.
    recursion : RLSState
        Estimate ``P`` of the six coefficients of (4) and covariance ``R``; changed in place.
    physical : ndarray, shape (5,)
        Physical parameters of the last estimate that has any; changed in place.
    last_velocity, velocity_before : float
        ``w(k-1)`` and ``w(k-2)``, rad/s.
    torque : float
        ``u(k-1)``, N m.
    known_torques : tuple of float
        Torque known from elsewhere, N m, the newest first, as far back as the drive may still apply it.
    valid : int
        Valid measurements without interruption.
    enabled : bool
        Whether the estimates adapt.
    row : ndarray, shape (6,)
        Scratch: regressors of the last equation; changed in place.
    """

    feedback: PIState
    feedforward: FeedforwardState
    recursion: RLSState
    physical: MutableArray
    last_velocity: float
    velocity_before: float
    torque: float
    known_torques: tuple[float, ...]
    valid: int
    enabled: bool
    row: MutableArray


def initial_paper_state(block: PaperParameters) -> PaperState:
    """Return the state at the start: estimates zero, covariance large, as in the paper."""
    return PaperState(
        feedback=initial_pi_state(block.feedback),
        feedforward=initial_feedforward_state(),
        recursion=initial_rls_state(np.zeros(len(COEFFICIENTS)), INITIAL_COVARIANCE * np.eye(len(COEFFICIENTS))),
        physical=np.array([block.inertia, 0.0, 0.0, 0.0, 0.0]),
        last_velocity=0.0,
        velocity_before=0.0,
        torque=0.0,
        known_torques=delay_line(block.feedback.delay),
        valid=0,
        enabled=True,
        row=np.zeros(len(COEFFICIENTS)),
    )


@register_jitable
def identified_model(block: PaperParameters, state: PaperState) -> TorqueModel:
    """Return the model as it is identified now."""
    physical = state.physical
    return torque_model(physical, physical[FRICTION_LAG], block.stribeck_velocity, block.stribeck_shape)


@register_jitable
def step_paper(block: PaperParameters, state: PaperState, inputs: Inputs) -> tuple[Output, PaperState]:
    """Do one sample: learn from the period that ends, feed forward for the one that begins, then feedback."""
    inputs, guard = plausible_inputs(block.feedback, state.feedback, inputs)
    finite = math.isfinite(inputs.velocity)
    velocity = inputs.velocity if finite else state.feedback.velocity
    delay = block.feedback.delay
    torque = acting_torque(inputs, asked_torque(block.feedback, state.feedback), delayed(state.known_torques, delay))
    valid = state.valid + 1 if finite else 0
    if state.enabled and valid > 2:
        series_regressors(
            state.row,
            (state.last_velocity, state.velocity_before),
            (torque, state.torque),
            block.stribeck_velocity,
            block.stribeck_shape,
        )
        # without excitation the covariance would grow without bound; the paper leaves this open
        factor = block.forgetting_factor if trace(state.recursion.covariance) < LARGEST_COVARIANCE else 1.0
        update_rls_in_place(state.recursion, state.row, velocity, factor)
        # the physical estimates of before are kept
        anew = begin_anew_in_place(state.recursion, INITIAL_COVARIANCE)
        if not anew and write_physical(state.recursion.estimate, block.period, state.physical):
            confine_in_place(state.physical, block.ranges)
    model = identified_model(block, state)
    model_torque, feedforward = step_feedforward(model, state.feedforward, inputs, block.period, delay, inputs.inertia)
    output, feedback = feed_back(block.feedback, state.feedback, with_feedforward(inputs, model_torque), guard)
    return output, PaperState(
        feedback=feedback,
        feedforward=feedforward,
        recursion=state.recursion,
        physical=state.physical,
        last_velocity=velocity,
        velocity_before=state.last_velocity,
        torque=torque,
        known_torques=remember(state.known_torques, inputs.feedforward),
        valid=valid,
        enabled=state.enabled,
        row=state.row,
    )


@register_jitable
def write_paper(block: PaperParameters, state: PaperState, row: NDArray[np.float64]) -> None:
    """Write the physical estimates into a row."""
    write_model(identified_model(block, state), row)


STEPS[PaperParameters] = step_paper
ESTIMATES[PaperParameters] = write_paper


class PaperController(IdentifyingController):
    """``u = PI(e) + J dr/dt + f(r)`` with ``J`` and ``f`` from the paper's recursive least squares on (4).

    ``e = reference + correction - velocity``; ``r`` is the plan alone.

    Parameters
    ----------
    proportional, integral : float
        Gains of the PI loop, N m s/rad and N m/rad.
    period : float
        Sampling period, s.
    inertia : float
        Inertia that the feedback was designed for, kg m^2.
    stribeck_velocity, stribeck_shape : float
        Pre-estimated ``Vs`` (rad/s) and ``delta``.
    memory : float, optional
        Memory of the estimator, s; the forgetting factor is ``exp(-period/memory)``.
    delay : float, optional
        Computation delay of the drive, sampling periods.
    """

    needs_double = "the covariance of its recursion does not stay positive definite, and the estimates diverge"

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
        delay: float = 0.0,
    ) -> None:
        feedback = check_gains(proportional, integral, period, delay)
        check_positive(
            proportional=proportional,
            period=period,
            inertia=inertia,
            stribeck_velocity=stribeck_velocity,
            stribeck_shape=stribeck_shape,
            memory=memory,
        )
        check_positive(forgetting_factor=math.exp(-period / memory))
        parameters = PaperParameters(
            feedback,
            float(stribeck_velocity),
            float(stribeck_shape),
            float(inertia),
            possible_ranges(inertia, largest_lag(inertia / proportional), len(ESTIMATED)),
            math.exp(-period / memory),
            float(period),
        )
        super().__init__(parameters, period, initial_paper_state)
