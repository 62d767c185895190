"""The sampled velocity loop in ``q = z^-1``: PI, an observer where there is one, delay and velocity filter.

Every margin of a loop is that of this open loop, whatever a design leaves free. With a nominal inertia and period of 1
and ``d`` periods of delay, the loop behind the inertia ``q^(1+d)/(1 - q)`` is

    L = F (C + S (1 - q))/(1 - S q^(1+d)) q^(1+d)/(1 - q),    C = Kp + Ki/(1 - q),

with the filter ``F`` that makes the measured velocity of the true one, and ``S`` that of an observer, see
:mod:`controllers.design.observer_design`; zero without one.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from controllers.design.velocity_filter import NO_FILTER, VelocityFilter

Polynomial = NDArray[Any]


class Compensation(NamedTuple):
    """The filter ``S`` as polynomials in ``q = z^-1``, falling powers."""

    numerator: Polynomial  # the polynomials
    denominator: Polynomial


NO_OBSERVER = Compensation(np.zeros(1), np.ones(1))
"""That of the PI loop alone."""


class SampledLoop(NamedTuple):
    """What a loop with an observer is designed for, made free of units by inertia and period."""

    proportional: float  # ``Kp Ts/J``
    integral: float  # ``Ki Ts^2/J``
    delay: int  # computation delay, whole periods
    velocity: VelocityFilter = NO_FILTER  # what the measured velocity is of the true one

    @property
    def feedback(self) -> Polynomial:
        """``C (1 - q)``."""
        return np.array([-self.proportional, self.proportional + self.integral])


def open_loop(loop: SampledLoop, compensation: Compensation = NO_OBSERVER) -> tuple[Polynomial, Polynomial]:
    """Return numerator and denominator of the open loop ``L``, polynomials in ``z``, falling powers."""
    difference = np.array([-1.0, 1.0])
    late = np.array([1.0, *([0.0] * (1 + loop.delay))])
    once = difference if loop.integral > 0.0 else np.ones(1)  # the factor that cancels without an integral
    feedback = loop.feedback if loop.integral > 0.0 else np.array([loop.proportional])
    direct = np.polymul(compensation.numerator, np.polymul(difference, once))
    late_and_measured = np.polymul(late, np.array(loop.velocity.numerator))
    numerator = np.polymul(np.polyadd(np.polymul(feedback, compensation.denominator), direct), late_and_measured)
    rest = np.polyadd(compensation.denominator, -np.polymul(compensation.numerator, late))
    denominator = np.polymul(np.polymul(rest, np.array(loop.velocity.denominator)), np.polymul(difference, once))
    size = max(numerator.size, denominator.size)
    # powers of q rise where those of z fall
    return np.pad(numerator, (size - numerator.size, 0))[::-1], np.pad(denominator, (size - denominator.size, 0))[::-1]


def sampled_loop(proportional: float, integral: float, delay: int, velocity: VelocityFilter = NO_FILTER) -> SampledLoop:
    """Return a loop free of units, its gains to twelve digits: joints of any inertia in equal loops share a design."""
    return SampledLoop(float(f"{proportional:.12g}"), float(f"{integral:.12g}"), delay, velocity)
