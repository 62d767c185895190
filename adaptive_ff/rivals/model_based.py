"""PI loop with a feedforward from a model that is assumed, not identified.

One kernel serves inertia feedforward (a model without friction), feedforward from fixed parameters (nominal, stale,
true) and the oracle, which assumes the true parameters of every moment.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.model.feedforward import FeedforwardState, initial_feedforward_state, step_feedforward
from adaptive_ff.model.friction import TorqueModel
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
    """Parameters of the loop with an assumed model.

    Attributes
    ----------
    feedback : PIParameters
        The PI loop.
    model : TorqueModel
        The joint.
    load : float
        Part of the model's offset that is no friction, N m.
    times : ndarray, shape (changes,)
        When the friction changes, s, ascending.
    scales : ndarray, shape (changes,)
        Factor on the model's friction from each of these times on.
    period : float
        Nominal period, s.
    """

    feedback: PIParameters
    model: TorqueModel
    load: float
    times: NDArray[np.float64]
    scales: NDArray[np.float64]
    period: float


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
    acting = time + block.feedback.delay * block.period
    scale = 1.0
    for change in range(block.times.size):
        if acting >= block.times[change] - 0.5 * block.period:  # in force for most of the period to come
            scale = block.scales[change]
    assumed = block.model
    model = TorqueModel(
        assumed.inertia,
        scale * assumed.coulomb,
        scale * assumed.stiction,
        scale * assumed.viscous,
        assumed.friction_lag,
        assumed.stribeck_velocity,
        assumed.stribeck_shape,
        block.load + scale * (assumed.offset - block.load),
        scale * assumed.stiction_asymmetry,
        scale * assumed.viscous_asymmetry,
    )
    torque, feedforward = step_feedforward(
        model, state.feedforward, inputs.reference, inputs.next_reference, block.period, block.feedback.delay
    )
    output, feedback = step_pi(block.feedback, state.feedback, with_feedforward(inputs, torque))
    return output, ModelBasedState(feedback, feedforward, time)


STEPS[ModelBasedParameters] = step_model_based
ESTIMATES[ModelBasedParameters] = without_estimates


class ModelBased(Controller):
    """Control law ``u = Kp (r - w) + Ki int (r - w) dt + J dr/dt + f_ref + offset``, the model assumed.

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
    load : float, optional
        Part of the model's offset that is no friction, N m: changes leave it as it is.
    delay : float, optional
        Computation delay of the drive, sampling periods.
    """

    def __init__(
        self,
        proportional: float,
        integral: float,
        period: float,
        model: TorqueModel,
        changes: Sequence[tuple[float, float]] = (),
        *,
        load: float = 0.0,
        delay: float = 0.0,
    ) -> None:
        parameters = ModelBasedParameters(
            check_gains(proportional, integral, delay),
            TorqueModel(*(float(value) for value in model)),
            float(load),
            np.array([time for time, _ in changes], dtype=float),
            np.array([scale for _, scale in changes], dtype=float),
            float(period),
        )
        super().__init__(parameters, period, initial_model_based_state)
