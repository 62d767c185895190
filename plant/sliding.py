"""The velocity at the end of an implicit step against static friction, ``w + kappa F(w) = free velocity``.

``F`` is set-valued at rest: below breakaway the joint rests exactly. Above, the speed is found by Newton's method,
for the shape factor 1 with one exponential in nearly all steps.
"""

import math
from typing import NamedTuple

from plant.friction import Stribeck, sliding_friction_and_slope

MAXIMUM_ITERATIONS = 80
RELATIVE_TOLERANCE = 1e-12  # Newton converges quadratically: the error left is about its square

UPDATES = 3
"""Corrections of the speed that share one exponential."""

LONGEST_UPDATE = 0.1
"""Largest correction that the series is tried for, Stribeck velocities."""

ERROR_LEFT = 1e-16
"""Error left by them, relative to the free speed: less than what rounding leaves."""


class Direction(NamedTuple):
    """Constants of the implicit step in one direction of motion, ``linear x + coulomb + excess exp(-x/Vs) = free``."""

    friction: Stribeck  # static friction map ``F``
    kappa: float  # what a unit of static friction takes off the velocity, rad/s per N m
    breakaway: float  # free speed up to which the joint rests, ``kappa Fs``, rad/s
    coulomb: float  # ``kappa Fc`` and ``kappa (Fs - Fc)``, rad/s
    excess: float
    linear: float  # ``1 + kappa sigma``, dimensionless
    per_linear: float  # its reciprocal
    per_velocity: float  # ``1/Vs``, s/rad


def direction_of(friction: Stribeck, kappa: float) -> Direction:
    """Return the constants of the step for a friction map and ``kappa`` in rad/s per N m."""
    linear = 1.0 + kappa * friction.viscous
    return Direction(
        friction=friction,
        kappa=kappa,
        breakaway=kappa * friction.stiction,
        coulomb=kappa * friction.coulomb,
        excess=kappa * (friction.stiction - friction.coulomb),
        linear=linear,
        per_linear=1.0 / linear,
        per_velocity=1.0 / friction.stribeck_velocity,
    )


def speed_in_direction(direction: Direction, free_speed: float, friction_torque: float) -> float:
    """Solve ``x + kappa F(x) = free_speed`` for the speed ``x > 0``, where ``free_speed`` is above breakaway.

    ``friction_torque`` is the friction (N m) in this direction before the step; with it the guess is off by no more
    than friction changes in a step. Around the guess the exponential is ``e exp(-y)`` with a small ``y``, whose series
    gives the residual of a corrected speed without another exponential. Where that is not enough to the last digit, as
    at a reversal, Newton's method goes on.
    """
    low = (free_speed - direction.breakaway) * direction.per_linear
    high = (free_speed - direction.coulomb) * direction.per_linear
    guess = min(max(free_speed - direction.kappa * friction_torque, low), high)
    if direction.friction.stribeck_shape == 1.0:
        falling = direction.excess * math.exp(-guess * direction.per_velocity)
        slope = direction.linear - falling * direction.per_velocity
        per_slope = 1.0 / slope if slope > 0.0 else math.inf
        residual = direction.linear * guess + (direction.coulomb - free_speed) + falling
        first = -residual * per_slope * direction.per_velocity
        if abs(first) < LONGEST_UPDATE:
            ratio = falling * direction.per_velocity * per_slope
            allowed = ERROR_LEFT * free_speed * direction.per_velocity
            y = first
            for _ in range(UPDATES):
                square = y * y
                corrected = first - ratio * square * (0.5 - y * (1.0 / 6.0 - y * (1.0 / 24.0)))
                left = ratio * abs(y) * (abs(corrected - y) + square * square)  # of the iteration, and of the series
                y = corrected
                if left <= allowed:
                    return min(max(guess + y * direction.friction.stribeck_velocity, low), high)
    return sliding_speed(direction.friction, free_speed, direction.kappa, guess)


def next_speed(
    low: float, high: float, speed: float, residual: float, slope: float
) -> tuple[float, float, float, bool]:
    """Return the bracket ``[low, high]`` of a root and the speed (rad/s) after one step of Newton's method in it.

    Of a rising function of the speed, residual (rad/s) and slope are given. The speed is the middle of the bracket
    where Newton's method leaves it; last comes whether it is the root.
    """
    if residual > 0.0:
        high = speed
    else:
        low = speed
    candidate = speed - residual / slope
    if abs(candidate - speed) <= RELATIVE_TOLERANCE * speed:
        return low, high, min(max(candidate, low), high), True
    if not low < candidate < high:
        candidate = 0.5 * (low + high)
    return low, high, candidate, False


def sliding_speed(friction: Stribeck, free_speed: float, kappa: float, guess: float) -> float:
    """Solve ``x + kappa F(x) = free_speed`` for the speed ``x > 0`` by Newton's method inside a bracket.

    Needs ``free_speed > kappa Fs``, so that a root exists. ``guess`` is a speed near the solution, rad/s.
    """
    viscous_part = 1.0 + kappa * friction.viscous
    low = (free_speed - kappa * friction.stiction) / viscous_part
    high = (free_speed - kappa * friction.coulomb) / viscous_part
    speed = min(max(guess, low), high)
    for _ in range(MAXIMUM_ITERATIONS):
        torque, torque_slope = sliding_friction_and_slope(friction, speed)
        residual = speed + kappa * torque - free_speed
        if residual > 0.0:
            high = speed
        else:
            low = speed
        slope = 1.0 + kappa * torque_slope
        candidate = speed - residual / slope if slope > 0.0 else low
        if slope > 0.0 and abs(candidate - speed) <= RELATIVE_TOLERANCE * free_speed:
            return min(max(candidate, low), high)
        if candidate <= low or candidate >= high:
            candidate = 0.5 * (low + high)
        speed = candidate
    return speed


def velocity_under_friction(
    forward: Stribeck, backward: Stribeck, free_velocity: float, kappa: float, guess: float
) -> float:
    """Solve ``w + kappa F(w) = free_velocity`` for the velocity ``w``, rad/s, with ``F`` set-valued at rest.

    ``kappa`` is what a unit of static friction takes off the velocity, rad/s per N m; ``guess`` is a speed near the
    solution, rad/s. A joint at rest has a velocity of exactly zero.
    """
    if -kappa * backward.stiction <= free_velocity <= kappa * forward.stiction:
        return 0.0
    if free_velocity < 0.0:
        return -sliding_speed(backward, -free_velocity, kappa, guess)
    return sliding_speed(forward, free_velocity, kappa, guess)
