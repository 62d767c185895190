"""Active disturbance rejection: proportional feedback with an extended state observer.

J. Han, "From PID to active disturbance rejection control" (2009), with linear gains after Z. Gao, "Scaling and
bandwidth-parameterization based controller tuning" (2003): an observer of the velocity and of the *total disturbance*,
with both poles at ``wo``; the estimate of the disturbance is added to the torque, which leaves an integrator; the
observed velocity is fed back proportionally, with ``wc = Kp/J``. There is no integral: the observer has it.

Variant: the observer is discretised exactly for the hold, in its *current* form, with both poles at ``exp(-wo dt)``:
R. Miklosovic, A. Radke and Z. Gao, "Discrete implementation and generalization of the extended state observer"
(2006). Where Han takes the slope of the reference from a tracking differentiator, it comes from the preview here; the
joint then follows the reference itself, not a filtered one, as it does with every other controller.
"""

import math
from typing import TYPE_CHECKING, Any

from controllers.declaration import argument, as_given, controller, derived, positive
from controllers.loops import DELAY, Observing, designing
from controllers.observers.inertia_observer import ObservedLoopState, double_pole_gains, observe
from controllers.pi import PIParameters, check_gains, plausible_inputs
from controllers.registry import Inputs, Output, present_inertia
from controllers.torques import feed_ahead_and_back

if TYPE_CHECKING:
    from controllers.design.observer_design import ObserverDesign


def step_extended_state(
    parameters: "ExtendedState", state: ObservedLoopState, inputs: Inputs
) -> tuple[Output, ObservedLoopState]:
    """Do one sample: observe the period that ends, add disturbance and inertia's torque, feed the velocity back."""
    inputs, guard = plausible_inputs(parameters.feedback, state.feedback, inputs)
    inertia = present_inertia(inputs, parameters.inertia)
    gains = double_pole_gains(inertia, parameters.pole, inputs.dt)
    observer = observe(parameters.feedback, state, inputs, inertia, gains)
    observed = inputs._replace(velocity=observer.velocity if math.isfinite(inputs.velocity) else inputs.velocity)
    output, feedback = feed_ahead_and_back(parameters, state, observed, guard, observer.disturbance)
    return output, ObservedLoopState(feedback, observer, inputs.feedforward, inputs.reference)


@controller(step_extended_state, ObservedLoopState)
class ExtendedState(Observing):
    """``u = Kp (reference + correction - w^) + J dr/dt + d^``: loop with an extended state observer (ADRC).

    ``w^`` and ``d^`` are the observed velocity and total disturbance, ``r`` is the reference alone. After a lost
    measurement the observer goes on with its prediction; the gains are always those for the last period.

    Examples
    --------
    >>> from controllers import ExtendedState
    >>> observer = ExtendedState.design(inertia=20.0, period=0.01, proportional=1200.0)
    >>> controller = ExtendedState(1200.0, 0.01, inertia=20.0, bandwidth=observer.bandwidth)
    >>> torque = controller.step(0.1, 0.0, next_reference=0.101)
    """

    proportional: float = argument(as_given, "Gain ``Kp = wc J``, N m s/rad.", kw_only=False, kept=False)
    feedback: PIParameters = derived("The feedback, without an integral.")
    inertia: float = argument(positive, "Nominal inertia ``J``, kg m^2.")
    bandwidth: float = argument(
        positive, "Bandwidth ``wo/(2 pi)`` of the observer, Hz; ``design`` computes it.", kept=False
    )
    pole: float = derived("Both poles ``wo`` of the observer, rad/s.")
    period: float = argument(as_given, "Nominal sampling period, s.", kw_only=False)
    delay: float = argument(as_given, DELAY, default=0.0, kept=False)

    def derive(self) -> dict[str, Any]:
        """Return the feedback and the poles."""
        feedback = check_gains(self.proportional, 0.0, self.period, self.delay)
        return {"feedback": feedback, "period": feedback.period, "pole": 2.0 * math.pi * self.bandwidth}

    @staticmethod
    def design(
        inertia: float, period: float, proportional: float, bandwidth: float | None = None, **options: Any
    ) -> "ObserverDesign":
        """Compute the margins of the loop, or its fastest observer, with the options of the other observers."""
        made = designing("extended_state_compensation")
        return made(inertia, period, proportional, 0.0, bandwidth, **options)
