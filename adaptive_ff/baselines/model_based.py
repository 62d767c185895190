"""PI loop with a feedforward from a model that is assumed, not identified.

One kernel serves inertia feedforward (a model without friction), feedforward from fixed parameters (nominal, stale,
true) and the oracle, which assumes the true parameters of every moment.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from adaptive_ff.friction.feedforward import (
    FeedforwardState,
    is_plan_at_rest,
    released,
    step_feedforward,
    turning_speed,
)
from adaptive_ff.friction.model import TorqueModel, checked_model
from controllers.arrays import NDArray
from controllers.checks import check_numbers, check_velocity_lag
from controllers.declaration import argument, as_given, controller, derived, fraction
from controllers.loops import PILoop
from controllers.pi import PIState, feed_back, plausible_inputs
from controllers.registry import Inputs, Output, with_feedforward, with_reference


class ModelBasedState(NamedTuple):
    """State of the loop with an assumed model."""

    feedback: PIState
    feedforward: FeedforwardState = FeedforwardState()
    time: float = 0.0  # time since the first sample, s
    position: float = 0.0  # integral of the reference since then, rad
    lagged: float = 0.0  # last reference behind the lag of the measured velocity, rad/s


def model_in_row(rows: NDArray[np.float64], row: int) -> TorqueModel:
    """Return the model in a row of times and models; its fields are in their order."""
    return TorqueModel(
        *(rows[row, 1], rows[row, 2], rows[row, 3], rows[row, 4], rows[row, 5], rows[row, 6]),
        *(rows[row, 7], rows[row, 8], rows[row, 9], rows[row, 10], rows[row, 11], rows[row, 12]),
    )


def step_model_based(
    parameters: "ModelBased", state: ModelBasedState, inputs: Inputs
) -> tuple[Output, ModelBasedState]:
    """Do one sample: feedforward of the model as it is now, then feedback.

    The feedback compares the measured velocity with the reference behind its lag; else it would brake where the
    feedforward accelerates.
    """
    inputs, guard = plausible_inputs(parameters.feedback, state.feedback, inputs)
    time, position, lagged = 0.0, 0.0, inputs.reference
    if state.feedback.samples > 0:
        time = state.time + inputs.dt
        position = state.position + 0.5 * inputs.dt * (state.feedforward.reference + inputs.reference)
        if parameters.velocity_lag > 0.0:
            lagged = state.lagged + (inputs.reference - state.lagged) * inputs.dt / (
                inputs.dt + parameters.velocity_lag
            )
    delay, period, gravity, ripple = parameters.feedback.delay, parameters.period, parameters.gravity, parameters.ripple
    acting = time + delay * period
    model, turned = parameters.model, parameters.turned
    for change in range(parameters.schedule.shape[0]):
        if acting >= parameters.schedule[change, 0] - 0.5 * period:  # in force for most of the period to come
            model = model_in_row(parameters.schedule, change)
            turned = turning_speed(model, model.inertia, period)
    torque, feedforward = step_feedforward(model, state.feedforward, inputs, period, delay, inputs.inertia, turned)
    if parameters.held < 1.0 and is_plan_at_rest(state.feedforward, inputs, delay):
        feedforward = released(model, feedforward, parameters.held, inputs.dt)
    turn = (delay + 0.5) * period * inputs.reference  # to the middle of the coming period
    if gravity[0] > 0.0:
        torque += gravity[0] * math.sin(position + turn + gravity[1])
    if ripple[0] > 0.0:
        there = inputs.position if math.isfinite(inputs.position) else position
        torque -= ripple[0] * math.sin(parameters.ripple_waves * (there + turn))
    compared = with_reference(with_feedforward(inputs, torque), lagged)
    output, feedback = feed_back(parameters.feedback, state.feedback, compared, guard)
    return output, ModelBasedState(feedback, feedforward, time, position, lagged)


def _rows(name: str, changes: Sequence[tuple[float, TorqueModel]]) -> NDArray[np.float64]:
    """Return times and models, a row for each change."""
    for place, (time, changed) in enumerate(changes):
        check_numbers(**{f"{name}[{place}] time": time})
        checked_model(f"{name}[{place}]", changed)
    rows = [[time, *changed] for time, changed in changes]
    return np.array(rows, dtype=float).reshape(-1, 1 + len(TorqueModel._fields))


def _pair(name: str, values: tuple[float, float]) -> tuple[float, float]:
    return float(values[0]), float(values[1])


@controller(step_model_based, ModelBasedState)
class ModelBased(PILoop):
    """``u = PI(e) + J dr/dt + f(r) + offset`` with a friction model of given parameters."""

    model: TorqueModel = argument(checked_model, "The joint that the feedforward assumes.", kw_only=False)
    changes: Sequence[tuple[float, TorqueModel]] = argument(
        as_given, "Times (s) and models from then on, ascending.", default=(), kw_only=False, kept=False
    )
    gravity: tuple[float, float] = argument(
        _pair,
        "Amplitude (N m) and phase (rad) of a weight's torque ``gravity sin(q + phase)`` along the planned position "
        "``q``, zero at the start.",
        default=(0.0, 0.0),
    )
    ripple: tuple[float, float] = argument(
        _pair,
        "Amplitude (N m) and period (rad) of a ripple of the drive, a sine of the measured position, or of the planned "
        "one where none is measured.",
        default=(0.0, 1.0),
    )
    velocity_lag: float = argument(
        as_given,
        "Time by which the measured velocity lags behind the joint's, s; see :func:`controllers.low_pass_lag`.",
        default=0.0,
    )
    held: float = argument(
        fraction,
        "Fraction of the friction held at standstill, see :func:`adaptive_ff.friction.feedforward.released`: zero "
        "for a joint that creeps.",
        default=1.0,
    )
    schedule: NDArray[np.float64] = derived("Time and model of each change, a row for each.")
    turned: float = derived("Speed of a reversed reference that turns the friction of this model, rad/s.")
    ripple_waves: float = derived("Angular frequency of the ripple over the position, 1/rad.")

    def derive(self) -> dict[str, Any]:
        """Return the delay of the reversal and the ripple's frequency."""
        check_velocity_lag(self.velocity_lag, self.period)
        return {
            "schedule": _rows("changes", self.changes),
            "velocity_lag": float(self.velocity_lag),
            "turned": turning_speed(self.model, self.model.inertia, float(self.period)),
            "ripple_waves": 2.0 * math.pi / self.ripple[1],
        }
