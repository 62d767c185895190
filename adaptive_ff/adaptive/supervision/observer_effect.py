"""Whether the observer helps: the error that there is, against the one that the loop would make without it.

    rho = (<e^2> - s^2) / <ehat^2 + c^2>,    h = 1 - sat((rho - 1.05) / 0.15)

``e`` is the error that the feedback sees, ``s`` the noise of the measured velocity, ``ehat = G(res)`` the error that
the PI loop would make of the residual, ``c`` what an outer loop adds to the plan, ``<.>`` a mean over 1 s. An observer
takes a part of the residual away, so what is left is less than the PI loop would leave: 0.1 to 0.7 of it on joints of
all kinds, hardly ever more than all of it. Where it is far more, the loop oscillates with what the observer feeds back.
So it does where a filter makes a velocity of an encoder with few counts and lags by more than has been told: with 4096
counts in a turn and a Kalman filter the error is five times that of the PI loop alone.

The share ``h`` of the gain falls at once while the observer is in use and the error is 0.12 of the plan's largest speed
or more, and rises by at most 1 in 20 s.

Noise that a filter has made slow (:mod:`adaptive_ff.adaptive.supervision.colour`) is in ``e`` and ``ehat`` alike, and
neither the gates nor ``rho`` tell it from what is to be observed: an encoder of 2^13 to 2^16 counts behind a Kalman
filter at 1 kHz leaves an observer in use that makes of the counts up to twice the error of PI alone, with ``rho`` at
0.8 to 1.2. There it must help: beside such noise, with means over 0.3 s of use and errors of any size,

    h = 1 - sat((rho - 0.8) / 0.15)

for a share of its own, and once let go of it stays so, for a small gain helps little. It is used all the same while
what it observes is much of the friction ``F``: as far as ``max(<d^2>, d^2/4)`` is one to two times ``(0.3 F)^2``, with
a mean over 0.3 s. Without that a load of 80 N m that comes later leaves 0.2 to 0.8 of PI's error for good with 2^16
counts, and friction is not trusted any more; with it 0.2 to 0.3 (0.15 to 0.2 for an observer that need not help).
Where an outer loop asks for a correction the error is what that asks for, and nothing is asked of the observer.

So it must where the error is a steady oscillation of any size, clear of the noise, as ``kappa`` below tells one: a
velocity whose error turns with the joint (a resolver, a tachometer, a disc that is not round) is taken for a torque and
followed, and beyond the band of the loop that leaves as much of the error that is measured, and up to 1.9 times the
true one. How much torque is observed does not count there, since such a ripple feigns any; what comes as a load makes
an error of one sign first. On motion one way joints with 0.5 to 1 % of the speed 60 and 120 times a turn settle at
0.69 and 1.50 of PI without it, with it at 1.13 and 2.27 (rows ``sensor_ripple_60`` and ``_120``, seeds 101 to 106). Of
890 drawn joints, machines, cascades and drives that saturate 28 change, by 1.00 in the geometric mean (seeds 101 and
201). With cogging of half the Coulomb friction every 0.02 rad, told wrong, the error is 1.25 times that without it,
0.76 of PI's. Within the band of the loop such an observer makes less of the error that is measured, and nothing tells
it from one that helps.

On the built-in joint at 1, 2 and 5 ms with 2^13 to 2^18 counts (112 runs, seeds 101 to 108) 17 have a window above 1.2
times PI's error, without it 56, and what they settle at is 1.18 times better in the geometric mean; the constants are
on a plateau. Not used: a level of the noise for the gates that is that of the means (as many windows, since at
reversals they open all the same).

A lag that nobody tells, of the drive's current loop or of a filter of the velocity, makes an observer oscillate that
would be stable without it, and then ``ehat`` holds the oscillation as well: what the observer feeds back comes late,
and looks like a disturbance. The error itself tells. What reversals, loads and hunting joints leave of it are pulses,

    kappa = <e^4> / <e^2>^2

is 4 and more of them, 3 of noise, and 1.5 of a sine. Where the observer is in use, ``kappa`` is below 2.4, the mean
error little beside that, and its square more than 0.04^2 of that of the plan's largest speed and four times the noise,
it oscillates: a ceiling on ``h`` falls by 4 in a second, and rises by 1 in 300 s only, since the lag stays. With a lag
of 20 ms the built-in joint settles at 0.28 of PI without that, with it at 1.2 to 3.3 (seeds 101 to 104); of 682
scenarios and drawn joints without such a lag 29 change at all, by a factor of 1.00 in the geometric mean. What does not
last as long as these means is told by its first half cycles (:mod:`adaptive_ff.adaptive.supervision.ringing`). A joint
that oscillates without the observer as well gets it back (:mod:`adaptive_ff.adaptive.supervision.acquittal`).
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
"""Length of the means, s: single reversals, at which a joint sticks and does not answer as predicted, do not count."""

SHORT = 0.3
"""Length of the means where the noise is coloured, s: of time in use alone."""

WORSE = 1.05
"""Squared error that there is over the predicted one, from which on the observer is held back ..."""

FAR_WORSE = 1.2
"""... and from which on it is not used."""

LITTLE, NOTHING = 0.8, 0.95
"""The same where the noise is coloured, of errors of any size while the observer is in use."""

LARGE = 0.12
"""Error over the largest speed of the plan from which on it counts: a loop that oscillates makes such ones.

Of a small one it matters little what made it; with all counted, joints on steep curves lost up to a tenth.
"""

IN_USE = 0.5
"""Gain of the observer from which on the error tells of it."""

RETURN = 20.0
"""Time in which the share rises from zero to one, s."""

STEADY = 2.4
"""Fourth moment of the error over the square of the second one, below which it is that of a steady oscillation ..."""

ABOUT_ZERO = 0.25
"""... unless this share of its mean square is that of its mean."""

NOTICED = 0.04
"""Error over the largest speed of the plan from which on an oscillation counts ..."""

LOUD = 4.0
"""... and its square over the variance of the noise."""

LETS_GO, FORGIVES = 0.25, 300.0
"""Times in which the ceiling on the share falls from one to zero while the loop oscillates, and rises again, s."""


class ObserverEffect(NamedTuple):
    """What is known of the effect of the observer.

    Attributes
    ----------
    error_squared : float
        Mean squared error that the feedback sees, rad^2/s^2.
    expected_squared : float
        Mean square of what it would be without the observer, rad^2/s^2.
    share : float
        Share ``h`` of its gain that the observer is used with.
    mean : float
        Mean error that the feedback sees, rad/s.
    fourth : float
        Mean of its fourth power, rad^4/s^4.
    ceiling : float
        Largest share, which an oscillation has left.
    ringing : Ringing
        Half cycles of the error.
    swift : Ringing
        Short half cycles of the error.
    acquittal : Acquittal
        What the error does without the observer.
    help : float
        Share of its gain that the observer is used with beside noise that a filter has made slow, or an oscillation.
    used_squared, used_expected : float
        Short means of the squared error, without noise, and of ``ehat^2`` while it is in use, rad^2/s^2.
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
    """Return the state of an observer of which nothing bad is known."""
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
    """Take the error of a sample into account.

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
        Whether what the drive gives is known: beside a limit a joint oscillates without an observer, and more with one.
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
    if used and oscillating and may_be_blamed(state.acquittal):
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
    """Return the state with an observer held back where it does not help beside coloured noise or an oscillation.

    Parameters
    ----------
    state : ObserverEffect
        The state.
    error, predicted, correction, variance, gain, duration : float
        As of :func:`advance_effect`. With an outer loop the error is what that asks for as well: it tells nothing here.
    coloured : bool
        Whether the noise of the measured velocity is coloured; a steady oscillation counts like that.
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
    """Return the share of an observer with which an error, squared, is a share of what is expected without it.

    Up to a share ``least`` of it that is one, and from ``most`` on zero.
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
    """Return the state with the half cycles of the error after a sample.

    Parameters
    ----------
    state : ObserverEffect
        The state.
    error, variance, duration : float
        As of :func:`advance_effect`.
    beside : Background
        What short half cycles are judged beside.
    far : float
        Error that neither friction nor a load makes, rad/s.
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
def blame_for_ringing(
    state: ObserverEffect, variance: float, beside: Background, peak: float, gain: float, falls: bool
) -> ObserverEffect:
    """Return the state with an observer that is slower, or out of use, where the loop rings with it.

    Parameters
    ----------
    state : ObserverEffect
        The state, with the half cycles of :func:`follow_half_cycles`.
    variance, peak, gain : float
        As of :func:`advance_effect`.
    beside : Background
        What short half cycles are judged beside.
    falls : bool
        Whether friction falls so steeply that a joint rings by itself.
    """
    ringing, swift = state.ringing, state.swift
    share, ceiling = state.share, state.ceiling
    if falls and ringing.blamed:
        share, ceiling, ringing = 1.0, 1.0, without_half_cycles(False)
    elif gain > IN_USE * state.share and not falls and may_be_blamed(state.acquittal):
        swiftly = rings_swiftly(swift, beside, peak)
        if swiftly and not swift.blamed:
            swift = slowed(swift)
        elif (swiftly and not beside.coloured) or rings(ringing, variance, peak):
            share, ceiling, ringing = 0.0, 0.0, without_half_cycles(True)
    return state._replace(share=share, ceiling=ceiling, ringing=ringing, swift=swift)


@register_jitable
def may_be_blamed(acquittal: Acquittal) -> bool:
    """Return whether an oscillation may be the observer's: where the joint oscillates without it as well, it is not."""
    return acquittal.stage != TRIED and acquittal.stage != ACQUITTED


@register_jitable
def steadily_oscillates(state: ObserverEffect, variance: float) -> bool:
    """Tell whether the error is a steady oscillation of any size, clear of noise with a variance (rad^2/s^2)."""
    squared = state.error_squared
    return oscillates(squared - variance, state.mean, squared, state.fourth, variance, 0.0)


@register_jitable
def oscillates(beyond_noise: float, mean: float, squared: float, fourth: float, variance: float, peak: float) -> bool:
    """Tell whether an error is a steady oscillation.

    Parameters
    ----------
    beyond_noise : float
        Its mean square without that of the noise of the measurement, rad^2/s^2.
    mean, squared, fourth : float
        Its mean (rad/s), mean square (rad^2/s^2) and mean fourth power (rad^4/s^4).
    variance : float
        Variance of the noise, rad^2/s^2.
    peak : float
        Largest speed of the plan of late, rad/s.
    """
    clear = max(NOTICED * NOTICED * peak * peak, LOUD * variance)
    return beyond_noise > clear and fourth < STEADY * squared * squared and mean * mean < ABOUT_ZERO * squared
