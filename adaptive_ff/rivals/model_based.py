"""PI loop with a feedforward from a model that is told, not identified.

One kernel serves inertia feedforward (a model without friction), feedforward from fixed parameters (nominal, stale,
true) and the oracle, which is told the true parameters of every moment.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.feedforward import FeedforwardState, initial_feedforward_state, step_feedforward
from adaptive_ff.model import TorqueModel
from controllers import (
    ESTIMATES,
    STEPS,
    Controller,
    Inputs,
    Output,
    PIParameters,
    PIState,
    check_gains,
    initial_pi_state,
    step_pi,
    with_feedforward,
    without_estimates,
)


class ModelBasedParameters(NamedTuple):
    """Parameters of the loop with a told model.

    Attributes
    ----------
    feedback : PIParameters
        The PI loop.
    model : TorqueModel
        The joint.
    times : ndarray, shape (changes,)
        When the friction changes, s, ascending.
    scales : ndarray, shape (changes,)
        Factor on the model's friction from each of these times on.
    period : float
        Nominal period, s.
    """

    feedback: PIParameters
    model: TorqueModel
    times: NDArray[np.float64]
    scales: NDArray[np.float64]
    period: float


class ModelBasedState(NamedTuple):
    """State of the loop with a told model.

    Attributes
    ----------
    feedback : PIState
        State of the PI loop.
    feedforward : FeedforwardState
        State of the feedforward.
    time : float
        Time since the first sample, s.
    """

    feedback: PIState
    feedforward: FeedforwardState
    time: float


def initial_model_based_state(parameters: ModelBasedParameters) -> ModelBasedState:
    """Return the state of the loop at rest."""
    return ModelBasedState(initial_pi_state(parameters.feedback), initial_feedforward_state(), 0.0)


@register_jitable
def step_model_based(
    block: ModelBasedParameters, state: ModelBasedState, inputs: Inputs
) -> tuple[Output, ModelBasedState]:
    """Do one sample: feedforward of the model as it is now, then feedback."""
    time = state.time + inputs.dt if state.feedback.samples > 0 else 0.0
    scale = 1.0
    for change in range(block.times.size):
        if time >= block.times[change] - 0.5 * block.period:  # in force for most of the coming period
            scale = block.scales[change]
    model = TorqueModel(
        block.model.inertia,
        scale * block.model.coulomb,
        scale * block.model.stiction,
        scale * block.model.viscous,
        block.model.friction_lag,
        block.model.stribeck_velocity,
        block.model.stribeck_shape,
    )
    torque, feedforward = step_feedforward(
        model, state.feedforward, inputs.reference, inputs.next_reference, block.period
    )
    output, feedback = step_pi(block.feedback, state.feedback, with_feedforward(inputs, torque))
    return output, ModelBasedState(feedback, feedforward, time)


STEPS[ModelBasedParameters] = step_model_based
ESTIMATES[ModelBasedParameters] = without_estimates


class ModelBased(Controller):
    """PI loop with feedforward from told parameters.

    Parameters
    ----------
    proportional, integral : float
        Gains of the PI loop, N m s/rad and N m/rad.
    period : float
        Nominal sampling period, s.
    model : TorqueModel
        The joint that the feedforward assumes.
    changes : sequence of (float, float), optional
        Times (s) and factors on the model's friction from then on, in ascending order of time.
    """

    def __init__(
        self,
        proportional: float,
        integral: float,
        period: float,
        model: TorqueModel,
        changes: Sequence[tuple[float, float]] = (),
    ) -> None:
        parameters = ModelBasedParameters(
            check_gains(proportional, integral),
            TorqueModel(*(float(value) for value in model)),
            np.array([time for time, _ in changes], dtype=float),
            np.array([scale for _, scale in changes], dtype=float),
            float(period),
        )
        super().__init__(parameters, period, initial_model_based_state)
