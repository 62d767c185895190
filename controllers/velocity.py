"""Velocity of a joint from the readings of an encoder.

An estimator is a named tuple of parameters with a kernel ``estimate(parameters, state, measurement, dt) -> (velocity,
state)``, which is given the real time since the last measurement, s. A measurement that is not finite gives "not a
number", which controllers count and skip, and leaves the state such that the next valid one is used to the full.

- *Direct*: a sensor of velocity.
- *Difference* of positions over the time between them. For an encoder of resolution ``r`` that passes many steps in a
  period the two rounding errors are independent, with a variance of ``r^2/12`` each: the velocity has a noise of
  ``r/(sqrt(6) Ts)``. It lags half a period behind.
- *Low-pass* ``wc/(s + wc)`` behind such a difference, which is the mean velocity since the last position; taken as
  constant over that time, it makes the low-pass exact for whatever time has passed.
- *Kalman* filter of the position (R. E. Kalman, 1960) for a joint whose acceleration is a random walk in continuous
  time (white jerk), sampled exactly; it does not lag behind a constant acceleration. The gains are the settled ones of
  the nominal period; the prediction takes the real one. Over lost measurements the filter predicts.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

from controllers.checks import check_finite, check_positive
from controllers.kernels.language import dispatched

Estimator = TypeVar("Estimator", bound=type)

VELOCITY_ESTIMATORS: dict[type, Callable[..., Any]] = {}
"""Kernel of each class of estimator: ``estimate(parameters, state, measurement, dt) -> (velocity, state)``."""

INITIAL_VELOCITY_STATES: dict[type, Callable[..., Any]] = {}
"""State of each class of estimator before its first sample: ``initial(parameters, position, velocity)``."""


def velocity_estimator(kernel: Callable[..., Any], initial: Callable[..., Any]) -> Callable[[Estimator], Estimator]:
    """Let loops, compiled ones included, use a class of parameters: an entry in each of the tables above."""

    def declare(cls: Estimator) -> Estimator:
        VELOCITY_ESTIMATORS[cls], INITIAL_VELOCITY_STATES[cls] = kernel, initial
        return cls

    return declare


estimate_velocity = dispatched(VELOCITY_ESTIMATORS)
estimate_velocity.__doc__ = "Compute the velocity (rad/s) by any estimator, as the tables above have it."


def initial_velocity_state(estimator: Any, position: float, velocity: float = 0.0) -> Any:
    """Return the state of an estimator one nominal period before its first sample.

    Parameters
    ----------
    estimator : NamedTuple
        The estimator.
    position : float
        Position that the first sample will measure, rad.
    velocity : float, optional
        Velocity at which the joint comes there, rad/s.

    Raises
    ------
    ValueError
        A value is not finite.
    TypeError
        A value is no number, or the estimator is of no known class.
    """
    check_finite(position=position, velocity=velocity)
    if type(estimator) not in INITIAL_VELOCITY_STATES:
        raise TypeError(f"estimator = {estimator!r} is not allowed: it must be an estimator of controllers.velocity")
    return INITIAL_VELOCITY_STATES[type(estimator)](estimator, float(position), float(velocity))


def pass_velocity(
    parameters: "DirectVelocity", state: "DirectVelocity", measurement: float, dt: float
) -> tuple[float, "DirectVelocity"]:
    """Pass a measured velocity (rad/s) on; it needs no state, the parameters stand for it."""
    return measurement if math.isfinite(measurement) else math.nan, state


@velocity_estimator(pass_velocity, lambda parameters, position, velocity: parameters)
class DirectVelocity(NamedTuple):
    """The measurement is a velocity already."""

    period: float  # nominal sampling period, s; of no consequence


def direct_velocity(period: float) -> DirectVelocity:
    """Return the estimator for a sensor of velocity and a nominal period in s."""
    check_positive(period=period)
    return DirectVelocity(float(period))


class DifferenceState(NamedTuple):
    """State of a difference."""

    position: float  # last valid position, rad
    elapsed: float  # time from there to the last sample, s


def difference_positions(
    parameters: "DifferenceVelocity", state: DifferenceState, measurement: float, dt: float
) -> tuple[float, DifferenceState]:
    """Compute the mean velocity (rad/s) since the last valid position."""
    elapsed = state.elapsed + dt
    if not math.isfinite(measurement):
        return math.nan, DifferenceState(state.position, elapsed)
    return (measurement - state.position) / elapsed, DifferenceState(measurement, 0.0)


@velocity_estimator(
    difference_positions,
    lambda parameters, position, velocity: DifferenceState(position - velocity * parameters.period, 0.0),
)
class DifferenceVelocity(NamedTuple):
    """Difference of positions."""

    period: float  # nominal sampling period, s; only the state at the start depends on it


def difference_velocity(period: float) -> DifferenceVelocity:
    """Return the estimator by differences for a nominal period in s; ``ValueError`` where it is not positive."""
    check_positive(period=period)
    return DifferenceVelocity(float(period))


class LowPassState(NamedTuple):
    """State of a difference behind a low-pass."""

    position: float  # last valid position, rad
    elapsed: float  # time from there to the last sample, s
    velocity: float  # velocity behind the low-pass, rad/s


def filter_positions(
    parameters: "LowPassVelocity", state: LowPassState, measurement: float, dt: float
) -> tuple[float, LowPassState]:
    """Compute the velocity (rad/s) behind the low-pass."""
    elapsed = state.elapsed + dt
    if not math.isfinite(measurement):
        return math.nan, LowPassState(state.position, elapsed, state.velocity)
    mean = (measurement - state.position) / elapsed
    velocity = state.velocity - math.expm1(-parameters.pole * elapsed) * (mean - state.velocity)
    return velocity, LowPassState(measurement, 0.0, velocity)


@velocity_estimator(
    filter_positions,
    lambda parameters, position, velocity: LowPassState(position - velocity * parameters.period, 0.0, velocity),
)
class LowPassVelocity(NamedTuple):
    """Difference of positions behind a low-pass."""

    pole: float  # pole ``wc``, rad/s
    period: float  # nominal sampling period, s; only the state at the start depends on it


def low_pass_velocity(cutoff: float, period: float) -> LowPassVelocity:
    """Return the estimator by differences behind a low-pass of a corner frequency (Hz), for a nominal period in s.

    Raises
    ------
    ValueError
        A value is not positive.
    """
    check_positive(cutoff=cutoff, period=period)
    return LowPassVelocity(2.0 * math.pi * float(cutoff), float(period))


def low_pass_lag(cutoff: float, period: float) -> float:
    """Compute by how much such a velocity lags behind that of a joint that accelerates evenly, s.

    Half a period of the difference, and ``Ts k/(1 - k)`` of the low-pass with ``k = exp(-wc Ts)``: less than the
    ``1/wc`` of one in continuous time, as each difference counts as if it had been there for all of its period.
    """
    check_positive(cutoff=cutoff, period=period)
    return period * (0.5 + 1.0 / math.expm1(2.0 * math.pi * cutoff * period))


class KalmanVelocityState(NamedTuple):
    """Estimated motion of the joint."""

    position: float  # position, rad
    velocity: float  # velocity, rad/s
    acceleration: float  # acceleration, rad/s^2


def follow_positions(
    parameters: "KalmanVelocity", state: KalmanVelocityState, measurement: float, dt: float
) -> tuple[float, KalmanVelocityState]:
    """Predict over the time that has passed, and correct by a position (rad)."""
    position = state.position + dt * (state.velocity + 0.5 * dt * state.acceleration)
    velocity = state.velocity + dt * state.acceleration
    if not math.isfinite(measurement):
        return math.nan, KalmanVelocityState(position, velocity, state.acceleration)
    innovation = measurement - position
    velocity += parameters.velocity_gain * innovation
    return velocity, KalmanVelocityState(
        position + parameters.position_gain * innovation,
        velocity,
        state.acceleration + parameters.acceleration_gain * innovation,
    )


@velocity_estimator(
    follow_positions,
    lambda parameters, position, velocity: KalmanVelocityState(position - velocity * parameters.period, velocity, 0.0),
)
class KalmanVelocity(NamedTuple):
    """Kalman filter of the position."""

    position_gain: float  # fraction of the innovation that goes to the position
    velocity_gain: float  # fraction that goes to the velocity, 1/s
    acceleration_gain: float  # fraction that goes to the acceleration, 1/s^2
    period: float  # nominal sampling period, s


def kalman_velocity(
    position_gain: float, velocity_gain: float, acceleration_gain: float, period: float
) -> KalmanVelocity:
    """Return the estimator by a Kalman filter.

    Parameters
    ----------
    position_gain, velocity_gain, acceleration_gain : float
        Settled gains of position (at most 1), velocity (1/s) and acceleration (1/s^2), as
        :func:`controllers.kalman_velocity_gains` computes them.
    period : float
        Nominal sampling period, s.

    Raises
    ------
    ValueError
        A value is not positive, or the position's gain above 1.
    """
    check_positive(
        position_gain=position_gain, velocity_gain=velocity_gain, acceleration_gain=acceleration_gain, period=period
    )
    if position_gain > 1.0:
        raise ValueError(f"position_gain = {position_gain} is not allowed: it must be at most 1")
    return KalmanVelocity(float(position_gain), float(velocity_gain), float(acceleration_gain), float(period))
