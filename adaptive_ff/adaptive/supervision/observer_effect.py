"""Whether the observer helps: the error that there is, compared with the one that the PI loop would make without it.

    rho = (<e^2> - s^2) / <ehat^2 + c^2>,    h = 1 - sat((rho - 1.05) / 0.15)

``e`` is the error that the feedback sees, ``s`` the standard deviation of the noise of the measured velocity,
``ehat = G(res)`` the error that the PI loop would make of the residual, ``c`` what an outer loop adds to the plan,
``<.>`` a mean over 1 s, and ``h`` the share of its gain with which the observer is used. The observer is *in use* where
its gain is more than half of what that share allows.

An observer takes away a part of the residual, so it leaves less than the PI loop would: 0.1 to 0.7 of it on joints of
all kinds, hardly ever more than all of it. Where it leaves far more, the loop oscillates with what it feeds back. Four
rules follow from that. Each lowers a share of the gain, or slows the observer. Rules 1 and 3 begin once the noise is
known, and 1 to 3 skip samples at which the joint stands although its plan moves.

**1. More error than without it.** ``h`` falls at once while the observer is in use and the error beyond the noise is
more than 0.12 of the plan's largest speed. It rises by at most 1 in 20 s. Example: an encoder with 4096 counts in a
turn, behind a Kalman filter that lags by more than was specified, has five times the error of the PI loop alone.

**2. No help beside coloured noise, or in a steady oscillation.** Noise that a filter has made slow
(:mod:`adaptive_ff.adaptive.supervision.colour`) is in ``e`` and ``ehat`` alike. Neither the gates nor rule 1 tell it
from a torque: with an encoder of 2^13 to 2^16 counts behind a Kalman filter at 1 kHz the observer makes up to twice
PI's error out of counts, at ``rho`` from 0.8 to 1.2. So beside such noise the observer must help:

    h' = 1 - sat((rho' - 0.8) / 0.15),    rho' = (<e^2> - s^2) / <ehat^2>

- The means are over 0.3 s in use, and errors of any size count. ``h'`` is a second share beside ``h``. It rises by at
  most 1 in 20 s; but once it is small the observer stays off, since a small gain helps little.
- *Much observed torque is used all the same*: as far as ``max(<d^2>, d^2/4)``, with a mean over 0.3 s, is one to two
  times ``(0.3 F)^2``, with the observed torque ``d`` and the friction ``F`` at breakaway. Otherwise a load of 80 N m
  that comes later leaves 0.2 to 0.8 of PI's error for good with 2^16 counts, and friction is not trusted any more. With
  this it leaves 0.2 to 0.3 (0.15 to 0.2 for an observer that need not help).
- *Behind an outer loop* that asks for a correction, the error is what it asks for, and this rule is off.
- *Evidence*: built-in joint at 1, 2 and 5 ms with 2^13 to 2^18 counts (112 runs, seeds 101 to 108). 17 runs have a
  window above 1.2 times PI's error, without the rule 56, and the settled error is 1.18 times smaller in the geometric
  mean. The constants are on a plateau. Not used: a noise level for the gates that is that of the means. It leaves as
  many windows, since at reversals the gates open all the same.

The observer must help in a steady oscillation as well (``kappa`` of rule 3), of any size, if it is clear of the noise.
A resolver, a tachometer or an eccentric disc gives a velocity whose error turns with the joint. The observer takes it
for a torque and follows it. Beyond the bandwidth of the loop that leaves as much measured error as before, and up to
1.9 times the true one.

- The exception for much observed torque does not apply here, since such a ripple feigns any torque. A load makes an
  error of one sign first, which is no oscillation.
- *Evidence*: along one-way motion, joints whose measured velocity ripples by 0.5 to 1 % of the speed 60 and 120 times a
  turn settle at 1.13 and 2.27 times better than PI, without the rule at 0.69 and 1.50 (rows ``sensor_ripple_60`` and
  ``_120``, seeds 101 to 106). Of 890 drawn joints, machines, cascades and drives that saturate 28 change, by 1.00 in
  the geometric mean (seeds 101 and 201).
- *Cost*: with cogging of half the Coulomb friction every 0.02 rad, and a wrong period given for it, the error is 1.25
  times that without the rule, 0.76 of PI's.
- *Limit*: within the bandwidth of the loop the observer does lower the measured error of such a ripple, and nothing
  distinguishes it from an observer that helps.

**3. A steady oscillation.** An unspecified lag, of the drive's current loop or of a filter of the velocity, makes the
loop oscillate with the observer, though it is stable without it. ``ehat`` contains that oscillation as well, since
torque that comes late looks like a disturbance. So the shape of the error decides:

    kappa = <e^4> / <e^2>^2

Reversals, loads and hunting joints leave pulses, with ``kappa`` of 4 and more; noise has 3, a sine 1.5. The error
oscillates steadily if ``kappa < 2.4``, ``<e>^2 < 0.25 <e^2>``, and ``<e^2> - s^2`` is more than 0.04^2 times the square
of the plan's largest speed and more than ``4 s^2``. While it does and the observer is in use, a ceiling on ``h`` falls
by 4 in a second. It rises by only 1 in 300 s, since the lag stays.

- *Evidence*: with a lag of 20 ms the built-in joint settles at 1.2 to 3.3 times better than PI, without the rule at
  0.28 (seeds 101 to 104). Of 682 scenarios and drawn joints without such a lag 29 change at all, by a factor of 1.00 in
  the geometric mean.
- A joint that oscillates without the observer as well gets it back
  (:mod:`adaptive_ff.adaptive.supervision.acquittal`).

**4. Ringing** shorter than these means is detected by its first half cycles
(:mod:`adaptive_ff.adaptive.supervision.ringing`, :mod:`adaptive_ff.adaptive.supervision.swift_ringing`).
"""

from typing import NamedTuple

from numba.extending import register_jitable

from adaptive_ff.adaptive.supervision.acquittal import (
    ACQUITTED,
    CLEAR,
    GUILTY,
    NONE,
    TRIED,
    WAITS,
    Acquittal,
    advance_acquittal,
    initial_acquittal,
)
from adaptive_ff.adaptive.supervision.ringing import (
    Ringing,
    advance_ringing,
    initial_ringing,
    rings,
    without_half_cycles,
)
from adaptive_ff.adaptive.supervision.swift_ringing import Background, advance_swift, rings_swiftly, slowed

WINDOW = 1.0
"""Length of the means, s: long enough that a single reversal, where a joint sticks unpredicted, weighs little."""

SHORT = 0.3
"""Length of the means of rule 2, s: of time in use alone."""

WORSE = 1.05
"""Mean squared error over the predicted one from which on the observer is held back ..."""

FAR_WORSE = 1.2
"""... and from which on it is switched off."""

LITTLE, NOTHING = 0.8, 0.95
"""The same two limits of rule 2, for errors of any size while the observer is in use."""

LARGE = 0.12
"""Least error of rule 1 (rms), over the largest speed of the plan: a loop that oscillates makes such large ones.

With errors of any size counted, joints on steep curves would lose up to a tenth.
"""

IN_USE = 0.5
"""Gain over the shares of it that are allowed, from which on the observer is in use and the error shows its effect."""

RETURN = 20.0
"""Time in which a share rises from zero to one, s."""

STEADY = 2.4
"""``kappa`` below which the error is a steady oscillation ..."""

ABOUT_ZERO = 0.25
"""... unless the square of its mean is this share of its mean square, or more."""

NOTICED = 0.04
"""Least error of an oscillation that counts (rms), over the largest speed of the plan ..."""

LOUD = 4.0
"""... and its least mean square, over the variance of the noise."""

LETS_GO, FORGIVES = 0.25, 300.0
"""Times in which the ceiling of rule 3 falls from one to zero while the loop oscillates, and rises again, s."""


class ObserverEffect(NamedTuple):
    """What is known of the effect of the observer.

    Attributes
    ----------
    error_squared : float
        Mean squared error that the feedback sees, rad^2/s^2.
    expected_squared : float
        Mean square of the error that is expected without the observer, rad^2/s^2.
    share : float
        Share ``h`` of its gain that the observer is used with.
    mean : float
        Mean error that the feedback sees, rad/s.
    fourth : float
        Mean fourth power of the error that the feedback sees, rad^4/s^4.
    ceiling : float
        Ceiling on ``share``, which an oscillation lowers.
    ringing : Ringing
        Half cycles of the error.
    swift : Ringing
        Short half cycles of the error.
    acquittal : Acquittal
        Trial of an observer that was switched off for an oscillation.
    help : float
        Share ``h'`` of its gain that the observer is used with beside coloured noise, or in a steady oscillation.
    used_squared, used_expected : float
        Short means of the squared error, without noise, and of ``ehat^2`` while the observer is in use, rad^2/s^2.
    """

    error_squared: float
    expected_squared: float
    share: float
    mean: float
    fourth: float
    ceiling: float
    ringing: Ringing
    swift: Ringing
    acquittal: Acquittal
    help: float
    used_squared: float
    used_expected: float


def initial_effect() -> ObserverEffect:
    """Return the state before the first sample: the observer is used in full."""
    return ObserverEffect(
        error_squared=0.0,
        expected_squared=0.0,
        share=1.0,
        mean=0.0,
        fourth=0.0,
        ceiling=1.0,
        ringing=initial_ringing(),
        swift=initial_ringing(),
        acquittal=initial_acquittal(),
        help=1.0,
        used_squared=0.0,
        used_expected=0.0,
    )


@register_jitable
def advance_effect(
    state: ObserverEffect,
    error: float,
    predicted: float,
    correction: float,
    variance: float,
    peak: float,
    gain: float,
    believed: bool,
    duration: float,
) -> ObserverEffect:
    """Return the state after a sample: rules 1 and 3, and the trial of an observer that is switched off.

    Parameters
    ----------
    state : ObserverEffect
        The state.
    error, predicted, correction : float
        Error that the feedback sees, error ``ehat``, and what an outer loop asks for, rad/s.
    variance : float
        Variance of the measured velocity, rad^2/s^2.
    peak : float
        Largest speed of the plan of late, rad/s.
    gain : float
        Gain with which the observer was fed back.
    believed : bool
        Whether the drive has probably given all torque that was asked for. At a limit of the drive a joint oscillates
        without the observer, and more with it, so no trial begins there.
    duration : float
        Length of the period, s.
    """
    weight = duration / (WINDOW + duration)
    error_squared = state.error_squared + weight * (error * error - state.error_squared)
    expected = predicted * predicted + correction * correction
    expected_squared = state.expected_squared + weight * (expected - state.expected_squared)
    mean = state.mean + weight * (error - state.mean)
    fourth = state.fourth + weight * (error * error * error * error - state.fourth)
    beyond_noise = error_squared - variance
    used, forgiven = gain > IN_USE * state.share, 0.0 if state.ringing.blamed else duration / FORGIVES
    ceiling, ringing, share = min(1.0, state.ceiling + forgiven), state.ringing, state.share
    oscillating = oscillates(beyond_noise, mean, error_squared, fourth, variance, peak)
    if used and oscillating and may_be_the_cause(state.acquittal):
        ceiling = max(0.0, min(ceiling, state.share) - duration / LETS_GO)
    clear = believed and oscillating and beyond_noise > CLEAR * variance
    let_go = ringing.blamed or ceiling < IN_USE
    squared = max(0.0, error * error - variance)
    acquittal = advance_acquittal(state.acquittal, squared, expected, clear, let_go, ringing.blamed, gain, duration)
    if acquittal.stage == TRIED and state.acquittal.stage == WAITS:
        ceiling, share, ringing = 1.0, 1.0, without_half_cycles(False)
    elif acquittal.stage == GUILTY and state.acquittal.stage == TRIED:
        ceiling, ringing = 0.0, without_half_cycles(acquittal.blamed)
    share = min(ceiling, share + duration / RETURN)
    if used and beyond_noise > LARGE * LARGE * peak * peak:
        share = min(share, helpful_share(beyond_noise, expected_squared, WORSE, FAR_WORSE))
    return ObserverEffect(
        error_squared=error_squared,
        expected_squared=expected_squared,
        share=share,
        mean=mean,
        fourth=fourth,
        ceiling=ceiling,
        ringing=ringing,
        swift=state.swift,
        acquittal=acquittal,
        help=state.help,
        used_squared=state.used_squared,
        used_expected=state.used_expected,
    )


@register_jitable
def demand_help(
    state: ObserverEffect,
    error: float,
    predicted: float,
    correction: float,
    variance: float,
    gain: float,
    coloured: bool,
    duration: float,
) -> ObserverEffect:
    """Return the state after a sample: rule 2, an observer that must help.

    Parameters
    ----------
    state : ObserverEffect
        The state.
    error, predicted, correction, variance, gain, duration : float
        As of :func:`advance_effect`. Samples at which an outer loop asks for a correction are left out.
    coloured : bool
        Whether the noise of the measured velocity is coloured.
    """
    help = min(1.0, state.help + duration / RETURN)
    squared, expected = state.used_squared, state.used_expected
    if gain > IN_USE * state.share * state.help and correction == 0.0:
        weight = duration / (SHORT + duration)
        squared += weight * (error * error - variance - squared)
        expected += weight * (predicted * predicted - expected)
        if coloured or steadily_oscillates(state, variance):
            help = min(help, helpful_share(squared, expected, LITTLE, NOTHING))
    return state._replace(help=help, used_squared=squared, used_expected=expected)


@register_jitable
def helpful_share(squared: float, expected: float, least: float, most: float) -> float:
    """Return the share of its gain that an observer deserves: one up to a ratio ``least``, zero from ``most`` on.

    The ratio is that of the mean squared error to the one expected without the observer (both rad^2/s^2).
    """
    ratio = squared / (expected + NONE)
    return max(0.0, min(1.0, (most - ratio) / (most - least)))


@register_jitable
def follow_half_cycles(
    state: ObserverEffect,
    error: float,
    variance: float,
    beside: Background,
    far: float,
    turned: bool,
    time_constant: float,
    duration: float,
) -> ObserverEffect:
    """Return the state with the half cycles of the error after a sample (rule 4).

    Parameters
    ----------
    state : ObserverEffect
        The state.
    error, variance, duration : float
        As of :func:`advance_effect`.
    beside : Background
        Noise and friction with which short half cycles are compared.
    far : float
        Error of :func:`adaptive_ff.adaptive.supervision.ringing.far_error`, rad/s.
    turned : bool
        Whether the plan has changed its sign, with which half cycles begin anew.
    time_constant : float
        Inertia over proportional gain, s.
    """
    ringing = without_half_cycles(state.ringing.blamed) if turned else state.ringing
    swift = without_half_cycles(state.swift.blamed) if turned else state.swift
    return state._replace(
        ringing=advance_ringing(ringing, error, variance, far, time_constant, duration),
        swift=advance_swift(swift, error, beside.variance, time_constant, duration),
    )


@register_jitable
def restrain_ringing(
    state: ObserverEffect, variance: float, beside: Background, peak: float, gain: float, falls: bool
) -> ObserverEffect:
    """Return the state with an observer that is slowed, or switched off, where the loop rings with it (rule 4).

    An observer that was switched off for ringing is used again once friction is found to fall steeply.

    Parameters
    ----------
    state : ObserverEffect
        The state, with the half cycles of :func:`follow_half_cycles`.
    variance, peak, gain : float
        As of :func:`advance_effect`.
    beside : Background
        Noise and friction with which short half cycles are compared.
    falls : bool
        Whether friction falls so steeply with the velocity that the joint sticks and slips by itself.
    """
    ringing, swift = state.ringing, state.swift
    share, ceiling = state.share, state.ceiling
    if falls and ringing.blamed:
        share, ceiling, ringing = 1.0, 1.0, without_half_cycles(False)
    elif gain > IN_USE * state.share and not falls and may_be_the_cause(state.acquittal):
        swiftly = rings_swiftly(swift, beside, peak)
        if swiftly and not swift.blamed:
            swift = slowed(swift)
        elif (swiftly and not beside.coloured) or rings(ringing, variance, peak):
            share, ceiling, ringing = 0.0, 0.0, without_half_cycles(True)
    return state._replace(share=share, ceiling=ceiling, ringing=ringing, swift=swift)


@register_jitable
def may_be_the_cause(acquittal: Acquittal) -> bool:
    """Tell whether an oscillation may be the observer's doing: not during its trial, nor once it was acquitted."""
    return acquittal.stage != TRIED and acquittal.stage != ACQUITTED


@register_jitable
def steadily_oscillates(state: ObserverEffect, variance: float) -> bool:
    """Tell whether the error is a steady oscillation of any size, clear of noise with a variance (rad^2/s^2)."""
    squared = state.error_squared
    return oscillates(squared - variance, state.mean, squared, state.fourth, variance, 0.0)


@register_jitable
def oscillates(beyond_noise: float, mean: float, squared: float, fourth: float, variance: float, peak: float) -> bool:
    """Tell whether an error is a steady oscillation, by its ``kappa``, mean and size (rule 3).

    Parameters
    ----------
    beyond_noise : float
        Mean square of the error less the variance of the noise, rad^2/s^2.
    mean, squared, fourth : float
        Mean (rad/s), mean square (rad^2/s^2) and mean fourth power (rad^4/s^4) of the error.
    variance : float
        Variance of the noise, rad^2/s^2.
    peak : float
        Largest speed of the plan of late, rad/s.
    """
    clear = max(NOTICED * NOTICED * peak * peak, LOUD * variance)
    return beyond_noise > clear and fourth < STEADY * squared * squared and mean * mean < ABOUT_ZERO * squared
