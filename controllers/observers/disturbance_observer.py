"""PI loop with a disturbance observer.

K. Ohnishi's observer of the load torque, in the two-degrees-of-freedom form of T. Umeno and Y. Hori, "Robust speed
control of DC servomotors using modern two degrees-of-freedom controller design" (1991): the inverse of the nominal
inertia, applied to the measured velocity, is compared with the torque that acted; the difference passes the filter
``Q`` and is added to the torque. For its reference, the loop then is the nominal inertia, whose inverse is fed forward.

Variant: ``Q`` of first order, ``g/(s + g)``, as in Ohnishi's observer; a measured velocity needs no higher one. It is
discretised with the exact pole ``exp(-g dt)``, and the inverse of the inertia acts on means over the period, which for
a held torque is exact. Hence nothing is lost by a real period that is not the nominal one, or by a measurement that
is missing: the observer then works with means over all the time since the last one.
"""

import math
from typing import Any, NamedTuple

from controllers.declaration import argument, controller, derived, positive
from controllers.loops import Observing, PILoop, designing
from controllers.pi import PIState, asked_torque, plausible_inputs
from controllers.plausibility import Guard, kept
from controllers.registry import Inputs, Output, present_inertia
from controllers.torques import acting_torque, feed_ahead_and_back


class DisturbanceObserverState(NamedTuple):
    """State of the loop with a disturbance observer."""

    feedback: PIState
    disturbance: float = 0.0  # estimated disturbance, N m; positive where it opposes the torque
    impulse: float = 0.0  # integral of the acting torque since the last valid measurement, N m s
    elapsed: float = 0.0  # time since then, s
    known_torque: float = 0.0  # torque known from elsewhere in the last period, N m
    reference: float = 0.0  # last reference, rad/s


def step_disturbance_observer(
    parameters: "DisturbanceObserver", state: DisturbanceObserverState, inputs: Inputs
) -> tuple[Output, DisturbanceObserverState]:
    """Do one sample of the loop alone; see ``observe_and_feed_back``."""
    inputs, guard = plausible_inputs(parameters.feedback, state.feedback, inputs)
    return observe_and_feed_back(parameters, state, inputs, guard)


def observe_and_feed_back(
    parameters: "DisturbanceObserver", state: DisturbanceObserverState, inputs: Inputs, guard: Guard
) -> tuple[Output, DisturbanceObserverState]:
    """Do one sample: observe the period that ends, add the disturbance and the inertia's torque, then feedback."""
    last = state.feedback
    command = asked_torque(parameters.feedback, last)
    impulse = state.impulse + inputs.dt * acting_torque(inputs, command, state.known_torque)
    elapsed = state.elapsed + inputs.dt
    disturbance = state.disturbance
    if math.isfinite(inputs.velocity):
        if last.samples > last.rejected:  # there is a measurement to compare with
            momentum = present_inertia(inputs, parameters.inertia) * (inputs.velocity - last.velocity)
            disturbance -= math.expm1(-parameters.pole * elapsed) * ((impulse - momentum) / elapsed - disturbance)
        impulse, elapsed = 0.0, 0.0
    disturbance, impulse = kept(disturbance), kept(impulse)
    output, feedback = feed_ahead_and_back(parameters, state, inputs, guard, disturbance)
    return output, DisturbanceObserverState(
        feedback, disturbance, impulse, elapsed, inputs.feedforward, inputs.reference
    )


@controller(step_disturbance_observer, DisturbanceObserverState)
class DisturbanceObserver(PILoop, Observing):
    """``u = PI(e) + J dr/dt + d``, ``d = g/(s + g) (u - J dw/dt)``: PI loop with a disturbance observer.

    ``e = reference + correction - velocity``; ``r`` is the reference alone. Without an integral the observer alone
    removes constant loads.

    Examples
    --------
    >>> from controllers import PI, DisturbanceObserver
    >>> pi = PI.design(inertia=20.0, period=0.01, bandwidth=10.0)
    >>> gains = (pi.proportional, pi.integral)
    >>> observer = DisturbanceObserver.design(20.0, 0.01, *gains)
    >>> controller = DisturbanceObserver(*gains, 0.01, inertia=20.0, bandwidth=observer.bandwidth)
    >>> torque = controller.step(0.1, 0.0, next_reference=0.101)
    """

    design = staticmethod(designing("disturbance_observer_compensation"))

    inertia: float = argument(positive, "Nominal inertia ``J``, kg m^2.")
    bandwidth: float = argument(positive, "Bandwidth of the filter ``Q``, Hz; ``design`` computes it.", kept=False)
    pole: float = derived("Pole ``g`` of the filter ``Q``, rad/s.")

    def derive(self) -> dict[str, Any]:
        """Return the pole."""
        return {"pole": 2.0 * math.pi * self.bandwidth}
