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
from typing import TYPE_CHECKING, Any, NamedTuple

from numba.extending import register_jitable

from controllers.checks import check_positive
from controllers.interface import Controller
from controllers.kernels import (
    ESTIMATES,
    STEPS,
    Inputs,
    Output,
    present_inertia,
    with_feedforward,
    with_velocity,
    without_estimates,
)
from controllers.observers.inertia_observer import ObserverState, correct, double_pole_gains, predict
from controllers.pi import (
    PIParameters,
    PIState,
    asked_torque,
    check_gains,
    feed_back,
    initial_pi_state,
    plausible_inputs,
)
from controllers.plausibility import kept
from controllers.sensitivity import OBSERVER_SENSITIVITY
from controllers.torques import acting_torque, slope_torque

if TYPE_CHECKING:
    from controllers.design.observer_design import ObserverDesign


class ExtendedStateParameters(NamedTuple):
    """Parameters of the loop with an extended state observer.

    Attributes
    ----------
    feedback : PIParameters
        The feedback; its integral gain is zero.
    inertia : float
        Nominal inertia, kg m^2.
    pole : float
        Both poles ``wo`` of the observer, rad/s.
    period : float
        Nominal period, s.
    """

    feedback: PIParameters
    inertia: float
    pole: float
    period: float


class ExtendedStateState(NamedTuple):
    """State of the loop with an extended state observer.

    Attributes
    ----------
    feedback : PIState
        State of the feedback; its velocity is the observed one at the last valid measurement.
    observer : ObserverState
        Velocity and total disturbance.
    known_torque : float
        Torque known from elsewhere in the last period, N m.
    reference : float
        Last reference, rad/s.
    """

    feedback: PIState
    observer: ObserverState
    known_torque: float
    reference: float


def initial_extended_state_state(block: ExtendedStateParameters) -> ExtendedStateState:
    """Return the state of a loop at rest."""
    return ExtendedStateState(initial_pi_state(block.feedback), ObserverState(0.0, 0.0), 0.0, 0.0)


@register_jitable
def step_extended_state(
    block: ExtendedStateParameters, state: ExtendedStateState, inputs: Inputs
) -> tuple[Output, ExtendedStateState]:
    """Do one sample: observe the period that ends, add disturbance and inertia's torque, feed the velocity back."""
    inputs, guard = plausible_inputs(block.feedback, state.feedback, inputs)
    last, observer = state.feedback, state.observer
    valid, inertia = math.isfinite(inputs.velocity), present_inertia(inputs, block.inertia)
    if last.samples > last.rejected:  # the observer has started
        torque = acting_torque(inputs, asked_torque(block.feedback, last), state.known_torque)
        observer = predict(inertia, observer, torque, inputs.dt)
        if valid:
            velocity_gain, disturbance_gain = double_pole_gains(inertia, block.pole, inputs.dt)
            observer = correct(observer, inputs.velocity, velocity_gain, disturbance_gain)
    elif valid:
        observer = ObserverState(inputs.velocity, observer.disturbance)
    observer = ObserverState(kept(observer.velocity), kept(observer.disturbance))
    ahead = slope_torque(block.inertia, inputs, state.reference, last.samples > 0, block.period)
    seen = with_velocity(inputs, observer.velocity if valid else inputs.velocity)
    output, feedback = feed_back(block.feedback, last, with_feedforward(seen, ahead + observer.disturbance), guard)
    return Output(output.torque, inputs.feedforward + ahead), ExtendedStateState(
        feedback, observer, inputs.feedforward, inputs.reference
    )


STEPS[ExtendedStateParameters] = step_extended_state
ESTIMATES[ExtendedStateParameters] = without_estimates


class ExtendedState(Controller):
    """``u = Kp (reference + correction - w^) + J dr/dt + d^``: loop with an extended state observer (ADRC).

    ``w^`` and ``d^`` are the observed velocity and total disturbance, ``r`` is the plan alone.

    After a lost measurement the observer goes on with its prediction; the gains are always those for the last period.

    Parameters
    ----------
    proportional : float
        Proportional gain ``Kp = wc J``, N m s/rad.
    period : float
        Nominal sampling period, s.
    inertia : float
        Nominal inertia, kg m^2.
    bandwidth : float
        Bandwidth ``wo/(2 pi)`` of the observer, Hz; :meth:`design` says how fast it may be.
    delay : float, optional
        Computation delay of the drive, sampling periods: it applies the torque of a sample from that much later on.

    Raises
    ------
    ValueError
        A value is out of range.

    Examples
    --------
    >>> from controllers import ExtendedState
    >>> observer = ExtendedState.design(inertia=20.0, period=0.01, proportional=1200.0)
    >>> controller = ExtendedState(1200.0, 0.01, inertia=20.0, bandwidth=observer.bandwidth)
    >>> torque = controller.step(0.1, 0.0, next_reference=0.101)
    """

    def __init__(
        self, proportional: float, period: float, *, inertia: float, bandwidth: float, delay: float = 0.0
    ) -> None:
        feedback = check_gains(proportional, 0.0, period, delay)
        check_positive(inertia=inertia, bandwidth=bandwidth)
        parameters = ExtendedStateParameters(feedback, float(inertia), 2.0 * math.pi * float(bandwidth), float(period))
        super().__init__(parameters, period, initial_extended_state_state)

    @property
    def disturbance(self) -> float:
        """Estimated torque that opposes the commanded one, N m."""
        return float(self.state.observer.disturbance)

    @staticmethod
    def design(
        inertia: float,
        period: float,
        proportional: float,
        bandwidth: float | None = None,
        *,
        delay: int = 0,
        maximum_sensitivity: float = OBSERVER_SENSITIVITY,
        velocity: Any = None,
    ) -> "ObserverDesign":
        """Return the margins of the loop with an observer, or the fastest observer that a margin allows.

        Parameters
        ----------
        inertia : float
            Nominal inertia, kg m^2.
        period : float
            Sampling period, s.
        proportional : float
            Proportional gain, N m s/rad.
        bandwidth : float, optional
            Bandwidth of the observer, Hz. By default the largest one that the margin allows.
        delay : int, optional
            Computation delay, whole periods.
        maximum_sensitivity : float, optional
            Bound on ``max |1/(1 + L)|`` where no bandwidth is given.
        velocity : NamedTuple, optional
            Estimator of :mod:`controllers.velocity` that makes the measured velocity of positions.

        Raises
        ------
        ValueError
            An argument is out of range, or no bandwidth meets the bound.
        """
        from controllers.design.compensations import extended_state_compensation as compensation
        from controllers.design.observer_design import design_observer

        return design_observer(
            inertia, period, (proportional, 0.0), bandwidth, delay, maximum_sensitivity, compensation, velocity
        )
