"""The paper's identification in a closed loop: recursive least squares on (4), fed forward.

The estimator is the paper's: all samples count, sliding or not; nothing is filtered; Vs and delta are assumed. The
torque ``u(k)`` is the one realised over the period that ends at ``k``, the newest that is known then. What the paper
leaves open, how the model is fed forward, is done as in the adaptive controller, with the same bounds on the
estimates. Where the covariance grows beyond a bound (standstill), forgetting pauses; the paper has no such bound.

It begins with the same covariance for every coefficient, whatever its unit: how fast it learns depends on the units of
torque and velocity.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from adaptive_ff.baselines.bounds import INERTIA_RANGE, largest_lag
from adaptive_ff.friction.feedforward import FeedforwardState, step_feedforward
from adaptive_ff.friction.identifying import IdentifyingController
from adaptive_ff.friction.model import TorqueModel
from adaptive_ff.learning.rls import RLSState, begin_anew_in_place, initial_rls_state, trace, update_rls_in_place
from adaptive_ff.learning.series import COEFFICIENTS, series_regressors, write_physical
from controllers.arrays import MutableArray, NDArray
from controllers.checks import check_positive
from controllers.declaration import argument, begin, controller, derived, positive
from controllers.delay import delay_line, delayed, remember
from controllers.loops import DesignedLoop
from controllers.pi import PIState, asked_torque, feed_back, plausible_inputs
from controllers.registry import Inputs, Output, with_feedforward
from controllers.torques import acting_torque

INITIAL_COVARIANCE = 1e4
LARGEST_COVARIANCE = 1e8
SIZE = len(COEFFICIENTS)
INERTIA, COULOMB, STICTION, VISCOUS, FRICTION_LAG = range(5)
"""Places of the physical parameters."""


class PaperState(NamedTuple):
    """State of the controller; its arrays are changed in place."""

    feedback: PIState
    feedforward: FeedforwardState = FeedforwardState()
    # estimate ``P`` of the six coefficients of (4) and covariance ``R``: zero and large, as in the paper
    recursion: RLSState = begin(lambda _: initial_rls_state(np.zeros(SIZE), INITIAL_COVARIANCE * np.eye(SIZE)))
    # physical parameters of the last estimate that has any
    physical: MutableArray = begin(lambda parameters: np.array([parameters.inertia, 0.0, 0.0, 0.0, 0.0]))
    last_velocity: float = 0.0  # ``w(k-1)``, rad/s
    velocity_before: float = 0.0  # ``w(k-2)``, rad/s
    torque: float = 0.0  # ``u(k-1)``, N m
    # torque known from elsewhere, N m, the newest first, as far back as the drive may still apply it
    known_torques: tuple[float, ...] = begin(lambda parameters: delay_line(parameters.feedback.delay))
    valid: int = 0  # valid measurements without interruption
    enabled: bool = True  # whether the estimates adapt
    row: MutableArray = begin(lambda _: np.zeros(SIZE))  # regressors of the last equation


def identified_model(parameters: "PaperController", state: PaperState) -> TorqueModel:
    """Return the model as it is identified now."""
    physical = state.physical
    return TorqueModel(
        inertia=physical[INERTIA],
        coulomb=physical[COULOMB],
        stiction=physical[STICTION],
        viscous=physical[VISCOUS],
        friction_lag=physical[FRICTION_LAG],
        stribeck_velocity=parameters.stribeck_velocity,
        stribeck_shape=parameters.stribeck_shape,
    )


def step_paper(parameters: "PaperController", state: PaperState, inputs: Inputs) -> tuple[Output, PaperState]:
    """Do one sample: learn from the period that ends, feed forward for the one that begins, then feedback."""
    inputs, guard = plausible_inputs(parameters.feedback, state.feedback, inputs)
    finite = math.isfinite(inputs.velocity)
    velocity = inputs.velocity if finite else state.feedback.velocity
    delay = parameters.feedback.delay
    torque = acting_torque(
        inputs, asked_torque(parameters.feedback, state.feedback), delayed(state.known_torques, delay)
    )
    valid = state.valid + 1 if finite else 0
    if state.enabled and valid > 2:
        series_regressors(
            state.row,
            (state.last_velocity, state.velocity_before),
            (torque, state.torque),
            parameters.stribeck_velocity,
            parameters.stribeck_shape,
        )
        # without excitation the covariance would grow without bound; the paper leaves this open
        factor = parameters.forgetting_factor if trace(state.recursion.covariance) < LARGEST_COVARIANCE else 1.0
        update_rls_in_place(state.recursion, state.row, velocity, factor)
        # the physical estimates of before are kept
        anew = begin_anew_in_place(state.recursion, INITIAL_COVARIANCE)
        if not anew and write_physical(state.recursion.estimate, parameters.period, state.physical):
            for i in range(state.physical.size):
                state.physical[i] = min(max(state.physical[i], parameters.ranges[i, 0]), parameters.ranges[i, 1])
    model = identified_model(parameters, state)
    model_torque, feedforward = step_feedforward(
        model, state.feedforward, inputs, parameters.period, delay, inputs.inertia
    )
    output, feedback = feed_back(parameters.feedback, state.feedback, with_feedforward(inputs, model_torque), guard)
    return output, state._replace(
        feedback=feedback,
        feedforward=feedforward,
        last_velocity=velocity,
        velocity_before=state.last_velocity,
        torque=torque,
        known_torques=remember(state.known_torques, inputs.feedforward),
        valid=valid,
    )


def write_paper(parameters: "PaperController", state: PaperState, row: MutableArray) -> None:
    """Write the physical estimates into a row."""
    for i in range(row.size):
        row[i] = state.physical[i]


@controller(step_paper, PaperState, estimates=write_paper)
class PaperController(DesignedLoop, IdentifyingController):
    """``u = PI(e) + J dr/dt + f(r)`` with ``J`` and ``f`` from the paper's recursive least squares on (4)."""

    needs_double = "the covariance of its recursion does not stay positive definite, and the estimates diverge"

    stribeck_velocity: float = argument(positive, "Pre-estimated ``Vs``, rad/s.")
    stribeck_shape: float = argument(positive, "Pre-estimated ``delta``.", default=1.0)
    memory: float = argument(
        positive,
        "Memory of the estimator, s; the forgetting factor is ``exp(-period/memory)``.",
        default=5.0,
        kept=False,
    )
    ranges: NDArray[np.float64] = derived("Least and largest possible value of each physical parameter.")
    forgetting_factor: float = derived("``lambda``.")

    def derive(self) -> dict[str, Any]:
        """Return the bounds of the estimates and the forgetting factor."""
        factor = math.exp(-self.period / self.memory)
        check_positive(forgetting_factor=factor)
        ranges = np.array([[0.0, math.inf]] * 5)
        ranges[INERTIA] = self.inertia / INERTIA_RANGE, self.inertia * INERTIA_RANGE
        ranges[FRICTION_LAG] = 0.0, largest_lag(self.inertia / self.proportional)
        return {"ranges": ranges, "forgetting_factor": factor}
