"""Lag of the feedforward, tuned by the tracking error that reversals leave.

The feedforward has a lag of its own beside the identified friction lag ``L_i``, which stays as it is. Near the lag
``L`` that leaves the least tracking error, the error is ``e = s (L - lag) + noise`` with the slope

    s = G(z) du/dlag,    lag d(du/dlag)/dt + du/dlag = -df_ref/dt

where ``df_ref/dt`` is the rate of the friction fed forward and ``G`` is what the loop of joint and PI makes of a
torque, with the assumed inertia, held torques, the computation delay and the lag of the measured velocity. ``L`` is the
least-squares fit over a fading memory, with the identified lag as prior, of the standard deviation ``d``:

    L = (S(v s (e + s lag)) + L_i/d^2) / (S(v s^2) + 1/d^2),    lag = L + late
    late = min(L_i, 10 ms) / (1 + N L_i^2/10)

``S`` is a fading sum over the samples. The weight ``v`` of an equation is the larger, the smaller the errors are around
it. ``N`` is the information about the lag so far, ``S(v s^2)`` without fading and with that of the first guess.

- *Why a lag of its own*: at a reversal friction changes its sign, and what the feedforward misses of it is nearly all
  that is left of the error. The torque of a drive is held over a period, noise shakes the joint while it turns, a gear
  gives way: with the true friction lag the feedforward is a few milliseconds early or late.
- *Bias*: the slope comes from the reference alone, so noise does not bias the fit. Friction that depends on the
  velocity is left out of ``G``, which makes the slope some 20 % too small and leaves the zero of the mean of ``s e``
  where it is. Where an observer takes part of the error away, ``e`` is the error without it
  (``watching.unobserved_error``).
- *Prior*: ``d`` is a share of the period. In a fast loop noise may hide the lag from the identification, which then
  drifts, in minutes to 0.1 s on a joint without a lag. While the data hold no information about the lag, ``d`` is at
  least 3 ms.
- *Late on purpose*: until the errors hold information about the lag, the feedforward is late by up to 10 ms. Before the
  first reversals the identified lag is a guess, and a joint whose friction is turned ``dt`` too early is thrown by
  ``2 Fc dt/J``; too late it sticks, and only the plan runs away, by ``dt`` times its acceleration.
- *Condition*: the torque of this controller moves the joint. A controller that only watches must not tune the lag.

The idea of tuning by the error behind the loop's own response follows the sensitivity approach to adaptive
feedforward, B. Widrow and E. Walach, "Adaptive Inverse Control" (Wiley, 2008), there as filtered-x.
"""

import math
from typing import NamedTuple

from numba.extending import register_jitable

from adaptive_ff.model.loop_response import LoopResponse, advance_loop_response
from controllers import PIParameters, delay_line, delayed, remember

PRIOR_DEVIATION = 0.3
"""Standard deviation ``d`` of the best lag from an identified one that the data hold information about, in periods."""

HIDDEN_DEVIATION = 0.003
"""Least value of ``d``, s, where the data hold no information about the lag: that of a loop of 100 Hz.

The identified lag may have any value then. With the standard deviation of the identified lag at every time, encoders of
4096 counts at 100 Hz and machines in cascades tracked better in the median, but on single references worse than PI.
"""

LATE = 0.010
"""Largest time by which the feedforward is late on purpose, before the errors hold information about the lag, s ..."""

HALVES = 10.0
"""... and the information about the lag that halves it, times the square of the identified lag."""

LONGEST = 10.0
"""Longest memory of the fit, in memories of the estimator ..."""

GROWTH = 0.5
"""... and its length as a share of the time learnt: what was fitted to a bad model must go."""

FIRST = 0.5
"""Time that must have been learnt before the fit begins, in memories of the estimator."""

CLIP = 3.0
"""Errors are clipped at this many times their root mean square around reversals."""

LEAST_LEFT = 0.25
"""Least share of the mean squared error that the best lag is assumed to leave."""

MOVED = 0.3
"""Where the identified lag has moved by this share of itself and a period, what was fitted before is dropped."""

YOUNG = 5.0
"""Time learnt up to which that happens, in memories of the estimator; later the fit is the more reliable one."""

LEAST_SUM = 1e-100
"""Sums at or below this come from a joint at rest for very long, or from no error at all: nothing to learn."""


class Evidence(NamedTuple):
    """Fading sums over the errors, with the slope ``s`` and the error ``e``.

    Attributes
    ----------
    information, weighted : float
        Sums of ``s^2`` and of ``s (e + s lag)``, both over the level of the error: the fit.
    energy, squares, cross, fourth : float
        Sums of ``s^2``, ``s^2 e^2``, ``s^3 e``, ``s^4``: the level of the error.
    since : float
        Identified lag when the sums began, s.
    """

    information: float
    weighted: float
    energy: float
    squares: float
    cross: float
    fourth: float
    since: float


class TimingState(NamedTuple):
    """State of the tuning.

    Attributes
    ----------
    sensitivity : float
        Change of the friction fed forward with the lag, N m/s, at the end of the coming period.
    velocity, integral : float
        What the loop makes of it: change of the error with the lag, rad/s^2, and of the integral, N m/s.
    slope : float
        The former as the measured velocity shows it.
    sensitivities, commands : tuple of float
        Mean sensitivity over a period, and torque of the feedback to it, the newest first, as far back as the drive
        may still apply them.
    evidence : Evidence
        Fading sums over the errors so far.
    lag : float
        Lag of the feedforward, s.
    seen : float
        Information ``N`` about the lag so far, 1/s^2: of the first guess, and of all errors, also of what was dropped
        since.
    """

    sensitivity: float
    velocity: float
    integral: float
    slope: float
    sensitivities: tuple[float, ...]
    commands: tuple[float, ...]
    evidence: Evidence
    lag: float
    seen: float


def initial_timing_state(feedback: PIParameters, lag: float, deviation: float) -> TimingState:
    """Return the state for a joint at rest, with a lag (s) to begin with and its standard deviation (s)."""
    line = delay_line(feedback.delay)
    return TimingState(
        sensitivity=0.0,
        velocity=0.0,
        integral=0.0,
        slope=0.0,
        sensitivities=line,
        commands=line,
        evidence=empty_evidence(lag),
        lag=lag,
        seen=1.0 / deviation**2,
    )


@register_jitable
def empty_evidence(identified: float) -> Evidence:
    """Return the sums as they begin, while the identified lag is this, s."""
    return Evidence(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, identified)


@register_jitable
def with_evidence(state: TimingState, evidence: Evidence, lag: float, seen: float) -> TimingState:
    """Return the state with other evidence, lag (s) of the feedforward, and information seen so far (1/s^2)."""
    return state._replace(evidence=evidence, lag=lag, seen=seen)


@register_jitable
def lag_torque(lag: float, lagged: float, torque: float, duration: float) -> tuple[float, float]:
    """Return the mean over a period of a torque (N m) behind a low-pass with a lag (s), and its value at the end.

    The torque is constant over the period; ``lagged`` is the value at its start.
    """
    if lag <= 0.0:
        return torque, torque
    share = -math.expm1(-duration / lag)
    gap = lagged - torque
    return torque + gap * share * lag / duration, torque + gap * (1.0 - share)


@register_jitable
def advance_response(
    state: TimingState, feedback: PIParameters, inertia: float, velocity_lag: float, duration: float
) -> TimingState:
    """Advance the loop's response to a change of the lag over the period that has ended.

    Parameters
    ----------
    state : TimingState
        The state.
    feedback : PIParameters
        The PI loop.
    inertia : float
        Inertia that it was designed for, kg m^2.
    velocity_lag : float
        Time by which the measured velocity lags, s.
    duration : float
        Length of the period, s.
    """
    response = LoopResponse(state.velocity, state.slope, state.integral, state.commands)
    sensitivity = delayed(state.sensitivities, feedback.delay)
    response = advance_loop_response(response, feedback, inertia, velocity_lag, sensitivity, duration)
    return state._replace(
        velocity=response.velocity, integral=response.integral, slope=response.measured, commands=response.commands
    )


@register_jitable
def learn_timing(state: TimingState, error: float, learnt: float, memory: float, duration: float) -> TimingState:
    """Return the state after the tracking error of a sample, which is added to the fading sums.

    The weight of an equation is ``v = S(s^2) / max(S(s^2 e^2) - S(s^3 e)^2/S(s^4), S(s^2 e^2)/4)``, with sums that fade
    with the memory of the estimator: the inverse of the mean squared error around reversals that the lag which suits
    these errors best leaves, at least a quarter of theirs. An error is limited to 3 times its root mean square there.

    Parameters
    ----------
    state : TimingState
        The state.
    error : float
        Reference less measured velocity, without an observer's help, rad/s.
    learnt : float
        Time for which the estimator has learnt, s, more than zero.
    memory : float
        Memory of the estimator, s.
    duration : float
        Time since the last sample, s.
    """
    known, slope = state.evidence, state.slope
    square = slope * slope
    keep = math.exp(-duration / memory)
    energy = keep * known.energy + square
    squares = keep * known.squares + square * error * error
    cross = keep * known.cross + square * slope * error
    fourth = keep * known.fourth + square * square
    keep = math.exp(-duration / min(LONGEST * memory, GROWTH * learnt))
    information, weighted = keep * known.information, keep * known.weighted
    seen = state.seen
    if squares > LEAST_SUM and fourth > LEAST_SUM:
        limit = CLIP * math.sqrt(squares / energy)
        left = squares - cross * cross / fourth  # by the lag that would suit these errors best
        weight = energy / max(left, LEAST_LEFT * squares)
        information += weight * square
        seen += weight * square
        weighted += weight * slope * (min(max(error, -limit), limit) + slope * state.lag)
    evidence = Evidence(information, weighted, energy, squares, cross, fourth, known.since)
    return with_evidence(state, evidence, state.lag, seen)


@register_jitable
def drop_stale_evidence(state: TimingState, identified: float, period: float, young: bool) -> TimingState:
    """Return the state with the sums begun anew, if the identified lag has moved much since they began.

    It has where ``|L_i - L_0| > 0.3 L_0 + T``, with the identified lag ``L_0`` when the sums began and the period
    ``T``, while the estimator is young. Far from the best lag the error is not linear in it, so what was fitted there
    is misleading. Until an error has been added, the sums begin anew at every sample.

    Parameters
    ----------
    state : TimingState
        The state.
    identified : float
        Identified friction lag, s.
    period : float
        Sampling period, s.
    young : bool
        Whether the estimator is young; later what was fitted is the more reliable.
    """
    evidence = state.evidence
    moved = abs(identified - evidence.since)
    if evidence.energy == 0.0 or (young and moved > MOVED * evidence.since + period):
        return with_evidence(state, empty_evidence(identified), state.lag, state.seen)
    return state


@register_jitable
def best_lag(state: TimingState, identified: float, largest: float, period: float, *, hidden: bool) -> float:
    """Return the least-squares lag ``L`` of the feedforward after the errors so far, from zero to the largest, s.

    Parameters
    ----------
    state : TimingState
        The state; it is left as it is.
    identified, largest : float
        Identified friction lag, the prior of the fit, and the largest possible one, s.
    period : float
        Sampling period, s.
    hidden : bool
        Whether the data hold no information about the lag.
    """
    deviation = max(PRIOR_DEVIATION * period, HIDDEN_DEVIATION if hidden else 0.0)
    prior = 1.0 / (deviation * deviation)
    evidence = state.evidence
    # a difference, not a weighted mean of the two: without evidence the identified lag must come out bit for bit
    correction = evidence.weighted - evidence.information * identified
    lag = identified + correction / (evidence.information + prior)
    return min(max(lag, 0.0), largest)


@register_jitable
def lateness(state: TimingState, identified: float) -> float:
    """Return by how much the feedforward is late on purpose, s: the less, the more is known of the lag.

    It is ``min(L_i, 10 ms) / (1 + N L_i^2/10)`` for the identified lag ``L_i`` (s).
    """
    return min(identified, LATE) / (1.0 + state.seen * identified * identified / HALVES)


@register_jitable
def note_friction(state: TimingState, start: float, end: float, lag: float, period: float) -> TimingState:
    """Note what is fed forward over the coming period.

    Parameters
    ----------
    state : TimingState
        The state.
    start, end : float
        Friction fed forward at the start and the end of the period, N m.
    lag : float
        Lag that it is computed with, s.
    period : float
        Length of the period, s.
    """
    mean, sensitivity = lag_torque(lag, state.sensitivity, (start - end) / period, period)
    sensitivities = remember(state.sensitivities, mean)
    return state._replace(sensitivity=sensitivity, sensitivities=sensitivities, lag=lag)
