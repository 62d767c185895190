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
from typing import TYPE_CHECKING, Any, NamedTuple

from numba.extending import register_jitable

from controllers.checks import check_positive
from controllers.interface import Controller
from controllers.kernels import ESTIMATES, STEPS, Inputs, Output, present_inertia, with_feedforward, without_estimates
from controllers.pi import (
    PIParameters,
    PIState,
    asked_torque,
    check_gains,
    feed_back,
    initial_pi_state,
    plausible_inputs,
)
from controllers.plausibility import Guard, kept
from controllers.sensitivity import OBSERVER_SENSITIVITY
from controllers.torques import acting_torque, slope_torque

if TYPE_CHECKING:
    from controllers.design.observer_design import ObserverDesign


class DisturbanceObserverParameters(NamedTuple):
    """Parameters of the loop with a disturbance observer.

    Attributes
    ----------
    feedback : PIParameters
        The PI loop.
    inertia : float
        Nominal inertia ``Jn``, kg m^2.
    pole : float
        Pole ``g`` of the filter ``Q``, rad/s.
    period : float
        Nominal period, s.
    """

    feedback: PIParameters
    inertia: float
    pole: float
    period: float


class DisturbanceObserverState(NamedTuple):
    """State of the loop with a disturbance observer.

    Attributes
    ----------
    feedback : PIState
        State of the PI loop.
    disturbance : float
        Estimated disturbance, N m; positive where it opposes the torque.
    impulse : float
        Integral of the acting torque since the last valid measurement, N m s.
    elapsed : float
        Time since then, s.
    known_torque : float
        Torque known from elsewhere in the last period, N m.
    reference : float
        Last reference, rad/s.
    """

    feedback: PIState
    disturbance: float
    impulse: float
    elapsed: float
    known_torque: float
    reference: float


def initial_disturbance_observer_state(block: DisturbanceObserverParameters) -> DisturbanceObserverState:
    """Return the state of a loop at rest."""
    return DisturbanceObserverState(initial_pi_state(block.feedback), 0.0, 0.0, 0.0, 0.0, 0.0)


@register_jitable
def step_disturbance_observer(
    block: DisturbanceObserverParameters, state: DisturbanceObserverState, inputs: Inputs
) -> tuple[Output, DisturbanceObserverState]:
    """Do one sample of the loop alone; see ``observe_and_feed_back``."""
    inputs, guard = plausible_inputs(block.feedback, state.feedback, inputs)
    return observe_and_feed_back(block, state, inputs, guard)


@register_jitable
def observe_and_feed_back(
    block: DisturbanceObserverParameters, state: DisturbanceObserverState, inputs: Inputs, guard: Guard
) -> tuple[Output, DisturbanceObserverState]:
    """Do one sample: observe the period that ends, add the disturbance and the inertia's torque, then feedback."""
    last = state.feedback
    impulse = state.impulse + inputs.dt * acting_torque(inputs, asked_torque(block.feedback, last), state.known_torque)
    elapsed = state.elapsed + inputs.dt
    disturbance = state.disturbance
    if math.isfinite(inputs.velocity):
        if last.samples > last.rejected:  # there is a measurement to compare with
            momentum = present_inertia(inputs, block.inertia) * (inputs.velocity - last.velocity)
            disturbance -= math.expm1(-block.pole * elapsed) * ((impulse - momentum) / elapsed - disturbance)
        impulse, elapsed = 0.0, 0.0
    disturbance, impulse = kept(disturbance), kept(impulse)
    ahead = slope_torque(block.inertia, inputs, state.reference, last.samples > 0, block.period)
    output, feedback = feed_back(block.feedback, last, with_feedforward(inputs, ahead + disturbance), guard)
    return Output(output.torque, inputs.feedforward + ahead), DisturbanceObserverState(
        feedback, disturbance, impulse, elapsed, inputs.feedforward, inputs.reference
    )


STEPS[DisturbanceObserverParameters] = step_disturbance_observer
ESTIMATES[DisturbanceObserverParameters] = without_estimates


class DisturbanceObserver(Controller):
    """``u = PI(e) + J dr/dt + d``, ``d = g/(s + g) (u - J dw/dt)``: PI loop with a disturbance observer.

    ``e = reference + correction - velocity``; ``r`` is the plan alone.

    Parameters
    ----------
    proportional, integral : float
        Gains of the PI loop, N m s/rad and N m/rad; without an integral the observer alone removes constant loads.
    period : float
        Nominal sampling period, s.
    inertia : float
        Nominal inertia, kg m^2.
    bandwidth : float
        Bandwidth of the filter ``Q``, Hz; :meth:`design` says how fast it may be.
    delay : float, optional
        Computation delay of the drive, sampling periods: it applies the torque of a sample from that much later on.

    Raises
    ------
    ValueError
        A value is out of range.

    Examples
    --------
    >>> from controllers import PI, DisturbanceObserver
    >>> pi = PI.design(inertia=20.0, period=0.01, bandwidth=10.0)
    >>> gains = (pi.proportional, pi.integral)
    >>> observer = DisturbanceObserver.design(20.0, 0.01, *gains)
    >>> controller = DisturbanceObserver(*gains, 0.01, inertia=20.0, bandwidth=observer.bandwidth)
    >>> torque = controller.step(0.1, 0.0, next_reference=0.101)
    """

    def __init__(
        self,
        proportional: float,
        integral: float,
        period: float,
        *,
        inertia: float,
        bandwidth: float,
        delay: float = 0.0,
    ) -> None:
        feedback = check_gains(proportional, integral, period, delay)
        check_positive(inertia=inertia, bandwidth=bandwidth)
        parameters = DisturbanceObserverParameters(
            feedback, float(inertia), 2.0 * math.pi * float(bandwidth), float(period)
        )
        super().__init__(parameters, period, initial_disturbance_observer_state)

    @property
    def disturbance(self) -> float:
        """Estimated torque that opposes the commanded one, N m."""
        return float(self.state.disturbance)

    @staticmethod
    def design(
        inertia: float,
        period: float,
        proportional: float,
        integral: float,
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
        proportional, integral : float
            Gains of the PI loop, N m s/rad and N m/rad.
        bandwidth : float, optional
            Bandwidth of ``Q``, Hz. By default the largest one that the margin allows.
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
        from controllers.design.compensations import disturbance_observer_compensation as compensation
        from controllers.design.observer_design import design_observer

        return design_observer(
            inertia, period, (proportional, integral), bandwidth, delay, maximum_sensitivity, compensation, velocity
        )
