"""P loop with friction compensation, a disturbance observer and the zero-phase inverse of the joint.

After H. S. Lee, M. Tomizuka, "Robust motion controller design for high-accuracy positioning systems" (1996): a friction
compensator, a disturbance observer in the velocity loop for what it leaves, feedback of the position, and a feedforward
of the desired motion by zero phase error tracking (M. Tomizuka, 1987). The text could not be compared, and no number of
it is claimed. It is meant to stand in a position loop, whose gain and the proportional one here are the feedback of the
source.

As chosen here:

- *Friction compensation* is the static curve of a fixed model, fed forward along the reference: along the measured
  velocity it would close a loop of its own. The observer takes it for known from the period on in which it acts.
- *Observer*: that of :mod:`controllers.observers.disturbance_observer`, of first order. It integrates already.
- *Zero-phase inverse* of the joint ``q/u = T^2/(2 J) z^-(1+d) (1 + z^-1)/(1 - z^-1)^2``, held torque to position, with
  the delay ``d`` of the drive. Its zero at -1 cannot be cancelled, only its phase:
  ``u(k) = J/(2 T^2) (1 - z^-1)^2 (1 + z) q_ref(k+1+d)``, mean velocities planned from before ``k`` to ``k+2+d``.
  The reference is known up to ``k + 1``; continued by a parabola through its last three velocities, this is

      u(k) = J/T ((r(k+1) - r(k-1))/2 + (d + 1/2) (r(k+1) - 2 r(k) + r(k-1)))

  Without a delay it is ``J (r(k+1) - r(k))/T``, as all others of the comparison feed it.
"""

import math
from typing import Any

from adaptive_ff.baselines.observed_model import ObservedModel, ObservedModelState, aware_observer
from adaptive_ff.friction.feedforward import step_feedforward
from controllers.declaration import controller
from controllers.delay import remember
from controllers.observers.disturbance_observer import observe_and_feed_back
from controllers.pi import plausible_inputs
from controllers.registry import Inputs, Output, acts_on_plan, present_inertia, with_feedforward
from controllers.torques import slope_torque


def zero_phase_torque(
    inertia: float, last: float, reference: float, following: float, period: float, delay: float
) -> float:
    """Return the torque (N m) of the zero-phase inverse; the delay of the drive is in periods."""
    bend = following - 2.0 * reference + last
    return inertia / period * (0.5 * (following - last) + (delay + 0.5) * bend)


def step_lee_tomizuka(
    parameters: "LeeTomizuka", state: ObservedModelState, inputs: Inputs
) -> tuple[Output, ObservedModelState]:
    """Do one sample: friction compensation and zero-phase inverse, then the loop with its observer."""
    loop, delay = parameters.feedback, parameters.feedback.feedback.delay
    inputs, guard = plausible_inputs(loop.feedback, state.feedback.feedback, inputs)
    friction, feedforward = step_feedforward(parameters.friction, state.feedforward, inputs, loop.period, delay, 0.0)
    last, started = state.feedback.reference, state.feedforward.started
    further = 0.0
    # the observer feeds the slope of the reference itself, which is all where that is known for when the torque acts
    if started and delay > 0.0 and math.isfinite(inputs.next_reference) and not acts_on_plan(inputs):
        inertia, following = present_inertia(inputs, loop.inertia), inputs.next_reference
        inverse = zero_phase_torque(inertia, last, inputs.reference, following, loop.period, delay)
        further = inverse - slope_torque(loop.inertia, inputs, last, started, loop.period)
    known = inputs.feedforward + friction
    fed = with_feedforward(inputs, friction + further)
    output, after = observe_and_feed_back(loop, aware_observer(state, delay), fed, guard)
    return output, ObservedModelState(after, feedforward, remember(state.line, known))


@controller(step_lee_tomizuka, ObservedModelState)
class LeeTomizuka(ObservedModel):
    """``u = Kp e + f(r) + J Z(r) + d``, ``d = g/(s + g) (u - f - J dw/dt)``, ``Z`` the zero-phase inverse.

    The integral gain may be zero, for the observer integrates. The lag of the model is not used.
    """

    def derive(self) -> dict[str, Any]:
        """Return the static friction."""
        return {"friction": self.model._replace(inertia=0.0, friction_lag=0.0)}
