"""PI loop with feedforward from a fixed model and a disturbance observer for what the model leaves.

The friction that the model predicts along the reference is fed forward and taken, from the period in which it acts on,
for a torque known from elsewhere: the observer of ``controllers.observers.disturbance_observer`` estimates the rest.
The inertia's torque is the observer's own, with the model's inertia. This is what is common in machine tools, where the
feedforward is set once and an observer makes up for its errors, loads and changes.
"""

import math
from typing import Any, NamedTuple

from adaptive_ff.friction.feedforward import FeedforwardState, step_feedforward, turning_speed
from adaptive_ff.friction.model import TorqueModel, checked_model
from controllers.declaration import argument, begin, controller, derived, positive
from controllers.delay import delay_line, delayed, remember
from controllers.loops import Observing, PILoop
from controllers.observers.disturbance_observer import (
    DisturbanceObserver,
    DisturbanceObserverState,
    observe_and_feed_back,
)
from controllers.pi import plausible_inputs
from controllers.registry import Inputs, Output, with_feedforward

WAITING: Any = begin(lambda parameters: delay_line(parameters.feedback.feedback.delay))
"""Torques fed forward that wait for the delay of the drive, at the start."""


class ObservedModelState(NamedTuple):
    """State of the loop with a fixed model and an observer."""

    feedback: DisturbanceObserverState
    feedforward: FeedforwardState = FeedforwardState()
    line: tuple[float, ...] = WAITING  # torques fed forward that wait for the delay of the drive, N m, newest first


def aware_observer(state: ObservedModelState, delay: float) -> DisturbanceObserverState:
    """Return the observer that knows what acted in the period that ends, not what was computed at its start."""
    last, acted = state.feedback, delayed(state.line, delay)
    return DisturbanceObserverState(last.feedback, last.disturbance, last.impulse, last.elapsed, acted, last.reference)


def step_observed_model(
    parameters: "ObservedModel", state: ObservedModelState, inputs: Inputs
) -> tuple[Output, ObservedModelState]:
    """Do one sample: feedforward of the friction, then the loop with its observer."""
    loop, friction = parameters.feedback, parameters.friction
    pi, period = loop.feedback, loop.period
    inputs, guard = plausible_inputs(pi, state.feedback.feedback, inputs)
    turned = turning_speed(friction, loop.inertia, period)
    torque, feedforward = step_feedforward(friction, state.feedforward, inputs, period, pi.delay, math.nan, turned)
    known = with_feedforward(inputs, torque)
    output, after = observe_and_feed_back(loop, aware_observer(state, pi.delay), known, guard)
    return output, ObservedModelState(after, feedforward, remember(state.line, known.feedforward))


@controller(step_observed_model, ObservedModelState)
class ObservedModel(PILoop, Observing):
    """``u = PI(e) + J dr/dt + f_ref + d``, ``d = g/(s + g) (u - f_ref - J dw/dt)``: fixed feedforward and an observer.

    ``f_ref`` is the friction of the model along the reference, lag included.
    """

    model: TorqueModel = argument(
        checked_model,
        "The joint that the feedforward assumes; its inertia is the observer's nominal one and must be positive.",
        kw_only=False,
        kept=False,
    )
    bandwidth: float = argument(
        positive, "Bandwidth of the observer's filter, Hz; ``DisturbanceObserver.design`` computes it.", kept=False
    )
    feedback: DisturbanceObserver = derived("The PI loop and its observer.")  # type: ignore[assignment]
    friction: TorqueModel = derived("The model without its inertia.")

    def derive(self) -> dict[str, Any]:
        """Return the loop with its observer, and the friction."""
        gains = self.proportional, self.integral, self.period
        loop = DisturbanceObserver(*gains, inertia=self.model.inertia, bandwidth=self.bandwidth, delay=self.delay)
        return {"feedback": loop.parameters, "friction": self.model._replace(inertia=0.0)}
