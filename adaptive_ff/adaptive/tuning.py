"""Every constant of the adaptive controller, in one record that can be set for each controller."""

import math
from typing import NamedTuple

LIMITS = {
    **dict.fromkeys(("growth", "largest_ratio"), (1.0, math.inf)),
    **dict.fromkeys(("shortest_lag", "longest_lag", "model_deviation"), (1e-6, math.inf)),
    "distances": (1.0, 10.0),
}
"""Least and largest value of a constant; of the others it is zero and infinite."""


class Tuning(NamedTuple):
    """Constants of filter, prior, observer and standstill; the defaults suit loops of 100 Hz to 2 kHz.

    Attributes
    ----------
    quiet, loud : float
        White torque that no column explains, in units of friction, squared, times s, in the two modes of the filter.
    load_walk : float
        Random walk of a load (push, payload) in the loud mode, in units of friction, squared, per second.
    memory, short_memory : float
        Time in which estimates return to the prior, s of motion, in the two modes; the second is also the memory of
        the peak of the reference, s of motion, and of what a diagnosis needs, s.
    switching : float
        Rate at which the mode in force changes, 1/s; a diagnosis judges a joint from the time between on.
    clip : float
        Standard deviations from which on an innovation counts less (Huber).
    span : float
        Length of an interval that is learnt from at once, in time constants ``J/Kp`` of the loop.
    noise_memory : float
        Memory of the level of the measurement noise, s.
    least_noise : float
        Least noise, in changes of velocity that the unit of friction makes in an interval.
    standing : float
        Speed below which a joint may stand, in standard deviations of the noise.
    inertia_deviation, viscous_deviation, lag_deviation, velocity_deviation : float
        Prior standard deviations: of the inertia over the assumed one, of the viscous coefficient over ``Kp``, and of
        the logarithms of friction lag and Stribeck velocity.
    spread, excess, slip_fraction : float
        Prior of the friction, whose total has a standard deviation of one unit of friction: standard deviations of its
        parts at a given total, and of stiction beyond Coulomb friction; and the part that needs no path.
    asymmetry : float
        Prior standard deviation of what differs by direction, over that of the mean.
    load : float
        The same of a load that is there from the start, in units of friction.
    first_unit : float
        Unit of friction before any torque, ``Kp Vs``.
    growth : float
        Factor by which the unit of friction grows in a sample at most.
    largest_ratio : float
        Largest inertia and Stribeck velocity over the assumed ones, and these over the least ones.
    longest_guess, shortest_lag, longest_lag : float
        Bounds of the friction lag, s; its first guess is ``J/Kp``, but at most the first of them.
    distance_ratio, distances : float
        Presliding distances are ``Vs J/Kp`` times so many powers of it, from 1 on.
    model_deviation, map_deviation : float
        Standard deviations where a model or a first map of friction comes without: of each value, and of each number.
    least_deviation : float
        Least standard deviation of what a model says, in units of it.
    hold : float
        Speed beyond zero at which friction turns, in changes of velocity that friction makes in a period.
    slow : float
        Peak of the reference over ``F/Kp`` below which a loop is left alone; from twice as much on it is not.
    resting : float
        Speed below which a reference rests, in Stribeck velocities.
    moving : float
        Speed above which a joint moves though its reference rests, in standard deviations of the noise.
    believed : float
        Error that the observer explains before anything is measured, in Stribeck velocities.
    explained : float
        Coefficient of determination of the error by the response to the observed torque, from which its gain is one.
    fastest : float
        Pole of the observer at most, rad/s.
    observed_fraction : float
        Fraction of the lacking torque that is observed: the rest bounds it beside an unknown lag.
    fade : float
        Time in which the feedforward fades in or out, and memory of the observer's gate, s.
    """

    quiet: float = 1e-4
    loud: float = 2e-3
    load_walk: float = 0.3
    memory: float = 6000.0
    short_memory: float = 100.0
    switching: float = 0.1
    clip: float = 3.0
    span: float = 0.25
    noise_memory: float = 0.5
    least_noise: float = 1e-4
    standing: float = 3.0
    inertia_deviation: float = 0.3
    viscous_deviation: float = 0.4
    lag_deviation: float = 0.5
    velocity_deviation: float = 0.3
    spread: float = 0.5
    excess: float = 0.5
    slip_fraction: float = 0.5
    asymmetry: float = 0.2
    load: float = 0.5
    first_unit: float = 0.3
    growth: float = 1.1
    largest_ratio: float = 10.0
    longest_guess: float = 0.03
    shortest_lag: float = 0.001
    longest_lag: float = 0.1
    distance_ratio: float = 4.0
    distances: float = 4.0
    model_deviation: float = 0.2
    map_deviation: float = 0.05
    least_deviation: float = 0.01
    hold: float = 0.018
    slow: float = 0.05
    resting: float = 1e-6
    moving: float = 20.0
    believed: float = 0.05
    explained: float = 0.5
    fastest: float = 100.0
    observed_fraction: float = 0.85
    fade: float = 1.0
