"""PI loop with feedforward from a fixed model and a disturbance observer for what the model leaves.

The friction that the model predicts along the plan is fed forward and taken, from the period in which it acts on, for a
torque known from elsewhere: the observer of ``controllers.observers.disturbance_observer`` sees what is left. The
inertia's torque is the observer's own, with the model's inertia. This is what is common in machine tools, where the
feedforward is set once and an observer makes up for its errors, loads and changes.
"""

import math
from typing import Any, NamedTuple

from numba.extending import register_jitable

from adaptive_ff.friction.feedforward import FeedforwardState, initial_feedforward_state, step_feedforward
from adaptive_ff.friction.model import TorqueModel
from adaptive_ff.friction.turning import turning_of
from controllers import (
    ESTIMATES,
    STEPS,
    Controller,
    DisturbanceObserver,
    Inputs,
    Output,
    delay_line,
    delayed,
    plausible_inputs,
    remember,
    with_feedforward,
    without_estimates,
)
from controllers.observers.disturbance_observer import (
    DisturbanceObserverParameters,
    DisturbanceObserverState,
    initial_disturbance_observer_state,
    observe_and_feed_back,
)


class ObservedModelParameters(NamedTuple):
    """Parameters of the loop with a fixed model and an observer.

    Attributes
    ----------
    feedback : DisturbanceObserverParameters
        The PI loop and its observer.
    friction : TorqueModel
        The model without its inertia.
    """

    feedback: DisturbanceObserverParameters
    friction: TorqueModel


class ObservedModelState(NamedTuple):
    """State of the loop with a fixed model and an observer.

    Attributes
    ----------
    feedback : DisturbanceObserverState
        State of the PI loop and its observer.
    feedforward : FeedforwardState
        State of the feedforward.
    line : tuple of float
        Torques fed forward that wait for the delay of the drive, N m, newest first.
    """

    feedback: DisturbanceObserverState
    feedforward: FeedforwardState
    line: tuple[float, ...]


def initial_observed_model_state(block: Any) -> ObservedModelState:
    """Return the state of the loop at rest, for parameters with a velocity loop and its observer as ``feedback``."""
    return ObservedModelState(
        initial_disturbance_observer_state(block.feedback),
        initial_feedforward_state(),
        delay_line(block.feedback.feedback.delay),
    )


@register_jitable
def aware_observer(state: ObservedModelState, delay: float) -> DisturbanceObserverState:
    """Return the observer that knows what acted in the period that ends, not what was computed at its start."""
    last, acted = state.feedback, delayed(state.line, delay)
    return DisturbanceObserverState(last.feedback, last.disturbance, last.impulse, last.elapsed, acted, last.reference)


@register_jitable
def step_observed_model(
    block: ObservedModelParameters, state: ObservedModelState, inputs: Inputs
) -> tuple[Output, ObservedModelState]:
    """Do one sample: feedforward of the friction, then the loop with its observer."""
    loop, delay = block.feedback, block.feedback.feedback.delay
    inputs, guard = plausible_inputs(loop.feedback, state.feedback.feedback, inputs)
    turning = turning_of(block.friction, loop.inertia, loop.feedback.proportional, loop.period)
    torque, feedforward = step_feedforward(
        block.friction, state.feedforward, inputs, loop.period, delay, math.nan, turning.speed, turning.path
    )
    known = with_feedforward(inputs, torque)
    output, after = observe_and_feed_back(loop, aware_observer(state, delay), known, guard)
    return output, ObservedModelState(after, feedforward, remember(state.line, known.feedforward))


STEPS[ObservedModelParameters] = step_observed_model
ESTIMATES[ObservedModelParameters] = without_estimates


class ObservedModel(Controller):
    """``u = PI(e) + J dr/dt + f_ref + d``, ``d = g/(s + g) (u - f_ref - J dw/dt)``: fixed feedforward and an observer.

    ``f_ref`` is the friction of the model along the plan, lag included.

    Parameters
    ----------
    proportional, integral : float
        Gains of the PI loop, N m s/rad and N m/rad.
    period : float
        Nominal sampling period, s.
    model : TorqueModel
        The joint that the feedforward assumes; its inertia is the observer's nominal one and must be positive.
    bandwidth : float
        Bandwidth of the observer's filter, Hz; :meth:`controllers.DisturbanceObserver.design` says how fast it may be.
    delay : float, optional
        Computation delay of the drive, sampling periods.

    Raises
    ------
    ValueError
        A value is out of range.
    """

    def __init__(
        self,
        proportional: float,
        integral: float,
        period: float,
        model: TorqueModel,
        *,
        bandwidth: float,
        delay: float = 0.0,
    ) -> None:
        loop = DisturbanceObserver(
            proportional, integral, period, inertia=model.inertia, bandwidth=bandwidth, delay=delay
        )
        friction = TorqueModel(*(float(value) for value in model._replace(inertia=0.0)))
        super().__init__(ObservedModelParameters(loop.parameters, friction), period, initial_observed_model_state)

    @property
    def disturbance(self) -> float:
        """Estimated torque that opposes the commanded one beyond the model's friction, N m."""
        return float(self.state.feedback.disturbance)
