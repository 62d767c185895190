"""Checks of what an adaptive controller is made with and given; messages name argument, value and what is allowed."""

import math

import numpy as np

from adaptive_ff.adaptive.tuning import LIMITS, Tuning
from adaptive_ff.friction.model import FURTHER
from controllers import check_positive
from controllers.arrays import NDArray
from controllers.checks import check_finite, check_numbers
from controllers.plausibility import LARGEST_VELOCITY, inertia_bounds

Array = NDArray[np.float64]

MOST_REGRESSORS = 20
"""Most further regressors: with some 25 columns and more, all of them are learnt worse."""

LARGEST_REGRESSOR = 1e6
"""Largest further regressor: they are of the size of one, and from far larger ones no estimator goes on."""


def further_names(count: int, ripples: int = 0) -> tuple[str, ...]:
    """Return the names of the sizes of so many further regressors, or raise ``ValueError`` for no such number."""
    if isinstance(count, bool) or not isinstance(count, int | np.integer) or not 0 <= count <= MOST_REGRESSORS:
        raise ValueError(f"regressors = {count} is not allowed: it must be a whole number from 0 to {MOST_REGRESSORS}")
    if 2 * ripples + count > MOST_REGRESSORS:
        raise ValueError(
            f"regressors = {count} is not allowed: with {ripples} ripple_periods, two columns each, it must be "
            f"{MOST_REGRESSORS - 2 * ripples} at most"
        )
    return tuple(f"{FURTHER}{number}" for number in range(1, count + 1))


def check_machine(proportional: float, inertia: float, stribeck_velocity: float) -> None:
    """Raise ``ValueError`` for an inertia (kg m^2) or a Stribeck velocity (rad/s) that no machine of the loop has.

    The messages name no units: a controller does not know whether its axis turns or is linear.
    """
    check_positive(proportional=proportional, inertia=inertia, stribeck_velocity=stribeck_velocity)
    least, most = inertia_bounds(proportional)
    if not least < inertia < most:
        raise ValueError(
            f"inertia = {inertia} is not allowed with proportional = {proportional}: it must be between {least:g} and "
            f"{most:g}"
        )
    if stribeck_velocity > LARGEST_VELOCITY:
        raise ValueError(
            f"stribeck_velocity = {stribeck_velocity} is not allowed: it must be {LARGEST_VELOCITY:g} at most"
        )


def check_gear_and_limit(gear_ratio: float, torque_limit: float | None) -> None:
    """Raise ``ValueError`` for a gear ratio that is zero or not finite, or a limit (N m) that is not positive."""
    torque_limit = math.inf if torque_limit is None else torque_limit
    check_numbers(gear_ratio=gear_ratio, torque_limit=torque_limit)
    if not (math.isfinite(gear_ratio) and gear_ratio != 0.0):
        raise ValueError(f"gear_ratio = {gear_ratio} is not allowed: it must be finite and not zero")
    if not torque_limit > 0.0:
        raise ValueError(f"torque_limit = {torque_limit} N m is not allowed: it must be positive")


def slowed(crossover: float, delay: float) -> float:
    """Return the fastest pole of the observer (rad/s) around a loop of a crossover (rad/s) and a delay (s).

    A delay costs the observer's loop the phase that it costs the feedback, once more.
    """
    return crossover / (1.0 + 2.0 * delay * crossover)


def checked_tuning(tuning: Tuning | None) -> Tuning:
    """Return the constants; raise ``TypeError`` for what is no record of them, ``ValueError`` for one out of range."""
    if tuning is None:
        return Tuning()
    if not isinstance(tuning, Tuning):
        raise TypeError(f"tuning = {tuning!r} is not allowed: it must be a Tuning")
    for name, value in tuning._asdict().items():
        check_finite(**{f"tuning.{name}": value})
        least, most = LIMITS.get(name, (0.0, math.inf))
        if not least <= value <= most:
            raise ValueError(f"tuning.{name} = {value} is not allowed: it must be from {least:g} to {most:g}")
    return tuning


def checked_memory(memory: float | None, tuning: Tuning) -> float:
    """Return the memory, s of motion."""
    if memory is None:
        return tuning.memory
    check_positive(memory=memory)
    return float(memory)


def checked_fraction(friction_share: float) -> float:
    """Return how much of the friction is fed, from 0 to 1."""
    check_finite(friction_share=friction_share)
    if not 0.0 <= friction_share <= 1.0:
        raise ValueError(f"friction_share = {friction_share} is not allowed: it must be from 0 to 1")
    return float(friction_share)


def observer_pole(bandwidth: float | None, tuning: Tuning) -> float:
    """Return the fastest pole of the observer, rad/s, for a bandwidth in Hz."""
    if bandwidth is None:
        return tuning.fastest
    check_positive(observer_bandwidth=bandwidth)
    return 2.0 * math.pi * float(bandwidth)


def checked_noise(velocity_noise: float) -> float:
    """Return a standard deviation of the measured velocity, zero where it is unknown."""
    check_numbers(velocity_noise=velocity_noise)
    if not 0.0 <= velocity_noise <= LARGEST_VELOCITY:
        raise ValueError(
            f"velocity_noise = {velocity_noise} is not allowed: it must be from 0 (unknown) to {LARGEST_VELOCITY:g}"
        )
    return float(velocity_noise)


def refuse_large(name: str, values: Array) -> None:
    """Raise ``ValueError`` where a regressor is too large; one that is not finite is none."""
    large = values[(np.abs(values) > LARGEST_REGRESSOR) & np.isfinite(values)]
    if large.size > 0:
        raise ValueError(
            f"{name} = {large[0]:g} is not allowed: they should be of the size of one, from {-LARGEST_REGRESSOR:g} to "
            f"{LARGEST_REGRESSOR:g} at most"
        )


def write_finite(held: Array, values: Array) -> None:
    """Write regressors over those that hold; of one that is not finite the last one holds."""
    np.copyto(held, values, where=np.isfinite(values))
