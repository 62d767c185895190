"""PI loop with a Kalman filter for the velocity and the torque that disturbs it.

R. E. Kalman, "A new approach to linear filtering and prediction problems" (1960), for the model

    J dw/dt = u - d,    dd/dt = white noise,    measured velocity = w + white noise,

which is sampled exactly: the disturbance is a random walk in continuous time, so that its intensity (N m/sqrt(s)) means
the same at every sampling period. The controller takes the settled gains; ``gains`` computes them. While they are small
against the sampling, the filter is a Butterworth one of second order with a natural frequency of

    w0^2 = walk / (J noise sqrt(Ts)),

which is called its bandwidth here. Friction is no random walk; one that suits it has the mean square of its jumps at
reversals times their rate.

Variant: the estimate of the disturbance stands beside the PI loop, which keeps the *measured* velocity; the filter's
own would add lag to the feedback.
"""

import math
from typing import TYPE_CHECKING, Any, NamedTuple

from numba.extending import register_jitable

from controllers.checks import check_positive
from controllers.interface import Controller
from controllers.kernels import ESTIMATES, STEPS, Inputs, Output, present_inertia, with_feedforward, without_estimates
from controllers.observers.inertia_observer import ObserverState, correct, predict
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


class KalmanDisturbanceParameters(NamedTuple):
    """Parameters of the loop with a Kalman filter.

    Attributes
    ----------
    feedback : PIParameters
        The PI loop.
    inertia : float
        Assumed inertia, kg m^2.
    velocity_gain : float
        Share of the innovation that goes to the velocity.
    disturbance_gain : float
        Torque that the disturbance loses for each unit of innovation, N m s/rad.
    period : float
        Nominal period, s.
    """

    feedback: PIParameters
    inertia: float
    velocity_gain: float
    disturbance_gain: float
    period: float


class KalmanDisturbanceState(NamedTuple):
    """State of the loop with a Kalman filter.

    Attributes
    ----------
    feedback : PIState
        State of the PI loop.
    observer : ObserverState
        Estimated velocity and disturbance.
    known_torque : float
        Torque known from elsewhere in the last period, N m.
    reference : float
        Last reference, rad/s.
    """

    feedback: PIState
    observer: ObserverState
    known_torque: float
    reference: float


def initial_kalman_disturbance_state(block: KalmanDisturbanceParameters) -> KalmanDisturbanceState:
    """Return the state of a loop at rest."""
    return KalmanDisturbanceState(initial_pi_state(block.feedback), ObserverState(0.0, 0.0), 0.0, 0.0)


@register_jitable
def step_kalman_disturbance(
    block: KalmanDisturbanceParameters, state: KalmanDisturbanceState, inputs: Inputs
) -> tuple[Output, KalmanDisturbanceState]:
    """Do one sample of the loop alone; see ``filter_and_feed_back``."""
    inputs, guard = plausible_inputs(block.feedback, state.feedback, inputs)
    return filter_and_feed_back(block, state, inputs, guard)


@register_jitable
def filter_and_feed_back(
    block: KalmanDisturbanceParameters, state: KalmanDisturbanceState, inputs: Inputs, guard: Guard
) -> tuple[Output, KalmanDisturbanceState]:
    """Do one sample: filter the period that ends, add the disturbance and the inertia's torque, then feedback."""
    last, observer = state.feedback, state.observer
    valid, inertia = math.isfinite(inputs.velocity), present_inertia(inputs, block.inertia)
    if last.samples > last.rejected:  # the filter has started
        torque = acting_torque(inputs, asked_torque(block.feedback, last), state.known_torque)
        observer = predict(inertia, observer, torque, inputs.dt)
        if valid:
            disturbance_gain = block.disturbance_gain * (inertia / block.inertia)  # times 1 where none is given
            observer = correct(observer, inputs.velocity, block.velocity_gain, disturbance_gain)
    elif valid:
        observer = ObserverState(inputs.velocity, observer.disturbance)
    observer = ObserverState(kept(observer.velocity), kept(observer.disturbance))
    ahead = slope_torque(block.inertia, inputs, state.reference, last.samples > 0, block.period)
    output, feedback = feed_back(block.feedback, last, with_feedforward(inputs, ahead + observer.disturbance), guard)
    return Output(output.torque, inputs.feedforward + ahead), KalmanDisturbanceState(
        feedback, observer, inputs.feedforward, inputs.reference
    )


STEPS[KalmanDisturbanceParameters] = step_kalman_disturbance
ESTIMATES[KalmanDisturbanceParameters] = without_estimates


class KalmanDisturbance(Controller):
    """``u = PI(e) + J dr/dt + d^``, ``d^`` from a Kalman filter of velocity and disturbance.

    ``e = reference + correction - velocity``; ``r`` is the plan alone.

    The prediction takes the real time since the last call; the gains are the settled ones of the nominal period, also
    after lost measurements, which are skipped.

    Parameters
    ----------
    proportional, integral : float
        Gains of the PI loop, N m s/rad and N m/rad.
    period : float
        Nominal sampling period, s.
    inertia : float
        Assumed inertia, kg m^2.
    velocity_gain : float
        Share of the innovation that goes to the velocity, above 0 and at most 1; see :meth:`gains`.
    disturbance_gain : float
        Torque that the disturbance loses for each unit of innovation, N m s/rad.
    delay : float, optional
        Computation delay of the drive, sampling periods: it applies the torque of a sample from that much later on.

    Raises
    ------
    ValueError
        A value is out of range.

    Examples
    --------
    >>> from controllers import KalmanDisturbance
    >>> gains = (1257.0, 15800.0)
    >>> observer = KalmanDisturbance.design(20.0, 0.01, *gains)
    >>> walk = KalmanDisturbance.walk(20.0, 0.01, velocity_noise=0.002, bandwidth=observer.bandwidth)
    >>> first, second = KalmanDisturbance.gains(20.0, 0.01, velocity_noise=0.002, disturbance_walk=walk)
    >>> controller = KalmanDisturbance(*gains, 0.01, inertia=20.0, velocity_gain=first, disturbance_gain=second)
    >>> torque = controller.step(0.1, 0.0, next_reference=0.101)
    """

    def __init__(
        self,
        proportional: float,
        integral: float,
        period: float,
        *,
        inertia: float,
        velocity_gain: float,
        disturbance_gain: float,
        delay: float = 0.0,
    ) -> None:
        feedback = check_gains(proportional, integral, period, delay)
        check_positive(inertia=inertia, velocity_gain=velocity_gain, disturbance_gain=disturbance_gain)
        if velocity_gain > 1.0:
            raise ValueError(f"velocity_gain = {velocity_gain} is not allowed: it must be above 0 and at most 1")
        parameters = KalmanDisturbanceParameters(
            feedback, float(inertia), float(velocity_gain), float(disturbance_gain), float(period)
        )
        super().__init__(parameters, period, initial_kalman_disturbance_state)

    @property
    def disturbance(self) -> float:
        """Estimated torque that opposes the commanded one, N m."""
        return float(self.state.observer.disturbance)

    @staticmethod
    def walk(inertia: float, period: float, velocity_noise: float, bandwidth: float) -> float:
        """Return the random walk (N m/sqrt(s)) for which the filter has a bandwidth (Hz)."""
        check_positive(inertia=inertia, period=period, velocity_noise=velocity_noise, bandwidth=bandwidth)
        return (2.0 * math.pi * bandwidth) ** 2 * inertia * velocity_noise * math.sqrt(period)

    @staticmethod
    def gains(inertia: float, period: float, velocity_noise: float, disturbance_walk: float) -> tuple[float, float]:
        """Return the settled gains, of velocity and disturbance, for a noise (rad/s) and a walk (N m/sqrt(s)).

        Arguments and errors are those of :func:`controllers.kalman_disturbance_gains`.
        """
        from controllers.design.kalman_gains import kalman_disturbance_gains

        return kalman_disturbance_gains(inertia, period, velocity_noise, disturbance_walk)

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
        """Return the margins of the loop with a filter, or the fastest filter that a margin allows.

        Parameters
        ----------
        inertia : float
            Assumed inertia, kg m^2.
        period : float
            Sampling period, s.
        proportional, integral : float
            Gains of the PI loop, N m s/rad and N m/rad.
        bandwidth : float, optional
            Bandwidth of the filter, Hz; see :meth:`walk`. By default the largest one that the margin allows.
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
        from controllers.design.compensations import kalman_compensation as compensation
        from controllers.design.observer_design import design_observer

        return design_observer(
            inertia, period, (proportional, integral), bandwidth, delay, maximum_sensitivity, compensation, velocity
        )
