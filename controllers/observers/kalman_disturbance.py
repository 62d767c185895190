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

from controllers.checks import check_positive
from controllers.declaration import argument, controller, portion, positive
from controllers.loops import Observing, PILoop, designing
from controllers.observers.inertia_observer import ObservedLoopState, observe
from controllers.pi import plausible_inputs
from controllers.plausibility import Guard
from controllers.registry import Inputs, Output, present_inertia
from controllers.torques import feed_ahead_and_back


def step_kalman_disturbance(
    parameters: "KalmanDisturbance", state: ObservedLoopState, inputs: Inputs
) -> tuple[Output, ObservedLoopState]:
    """Do one sample of the loop alone; see ``filter_and_feed_back``."""
    inputs, guard = plausible_inputs(parameters.feedback, state.feedback, inputs)
    return filter_and_feed_back(parameters, state, inputs, guard)


def filter_and_feed_back(
    parameters: "KalmanDisturbance", state: ObservedLoopState, inputs: Inputs, guard: Guard
) -> tuple[Output, ObservedLoopState]:
    """Do one sample: filter the period that ends, add the disturbance and the inertia's torque, then feedback."""
    inertia = present_inertia(inputs, parameters.inertia)
    scale = inertia / parameters.inertia  # 1 where none is given
    gains = (parameters.velocity_gain, parameters.disturbance_gain * scale)
    observer = observe(parameters.feedback, state, inputs, inertia, gains)
    output, feedback = feed_ahead_and_back(parameters, state, inputs, guard, observer.disturbance)
    return output, ObservedLoopState(feedback, observer, inputs.feedforward, inputs.reference)


@controller(step_kalman_disturbance, ObservedLoopState)
class KalmanDisturbance(PILoop, Observing):
    """``u = PI(e) + J dr/dt + d^``, ``d^`` from a Kalman filter of velocity and disturbance.

    ``e = reference + correction - velocity``; ``r`` is the reference alone. The prediction takes the real time since
    the last call; the gains are the settled ones of the nominal period, also after lost measurements, which are
    skipped.

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

    design = staticmethod(designing("kalman_compensation"))

    inertia: float = argument(positive, "Assumed inertia, kg m^2.")
    velocity_gain: float = argument(portion, "Fraction of the innovation that goes to the velocity; see ``gains``.")
    disturbance_gain: float = argument(
        positive, "Torque that the disturbance loses for each unit of innovation, N m s/rad; see ``gains``."
    )

    @staticmethod
    def walk(inertia: float, period: float, velocity_noise: float, bandwidth: float) -> float:
        """Compute the random walk (N m/sqrt(s)) for which the filter has a bandwidth (Hz)."""
        check_positive(inertia=inertia, period=period, velocity_noise=velocity_noise, bandwidth=bandwidth)
        return (2.0 * math.pi * bandwidth) ** 2 * inertia * velocity_noise * math.sqrt(period)

    @staticmethod
    def gains(inertia: float, period: float, velocity_noise: float, disturbance_walk: float) -> tuple[float, float]:
        """Compute the settled gains, of velocity and disturbance, for a noise (rad/s) and a walk (N m/sqrt(s)).

        Arguments and errors are those of :func:`controllers.kalman_disturbance_gains`.
        """
        from controllers.design.kalman_gains import kalman_disturbance_gains

        return kalman_disturbance_gains(inertia, period, velocity_noise, disturbance_walk)
