"""One sample of the adaptive controller.

    u = PI(r + correction - w) + sum_i theta_i psi_i + g d

First the period that has ended: responses of the loop, gate, learning. Then the coming one: feedforward, observer, what
passes between them and the integral so that the torque does not jump; then the PI loop.
"""

import math
from typing import NamedTuple

import numpy as np

from adaptive_ff.adaptive.coming import coming_reference, following_reference, limited_mean, without_rounding
from adaptive_ff.adaptive.feed import Fed, feed_in_place, next_gain
from adaptive_ff.adaptive.learn import (
    begin_in_place,
    distance_apart,
    grown_unit,
    learn_in_place,
    next_noise,
    next_watch,
    speed_level,
)
from adaptive_ff.adaptive.observe import gate, judged, observed
from adaptive_ff.adaptive.state import (
    FED,
    OBSERVED,
    OBSERVER,
    AdaptiveParameters,
    AdaptiveState,
    Interval,
    Noise,
    Observer,
)
from adaptive_ff.friction.columns import INERTIA
from adaptive_ff.learning.response import advance_response, put_in
from controllers import (
    MONITORS,
    STEPS,
    Inputs,
    Output,
    PIParameters,
    acts_on_plan,
    feed_back,
    plausible_inputs,
    remember,
    with_feedforward,
    with_realised_torque,
    with_reference,
)
from controllers.arrays import NDArray
from controllers.pi import asked_torque, unwound_integral


class Period(NamedTuple):
    """The period that has ended.

    Attributes
    ----------
    filtered, error : float
        Reference as it is measured, and the error, rad/s.
    torque : float
        Torque that acted, N m.
    cut : float
        What of it was not asked for, N m.
    leap : float
        Change of the reference that was not foreseen, as it is measured, rad/s.
    measured : bool
        Whether there is a velocity.
    level : float
        Speed below which the joint may stand, rad/s.
    """

    filtered: float
    error: float
    torque: float
    cut: float
    leap: float
    measured: bool
    level: float


class Learnt(NamedTuple):
    """What a sample has taught."""

    observer: Observer
    noise: Noise
    interval: Interval
    weight: float
    innovation: float


def end_period(parameters: AdaptiveParameters, state: AdaptiveState, inputs: Inputs) -> Period:
    """Return what is known of the period that has ended."""
    lag, duration, first = parameters.machine.velocity_lag, inputs.dt, state.feedback.samples == 0
    follows = duration / (duration + lag)
    filtered = inputs.reference
    if not first:
        filtered = state.filtered + follows * (inputs.reference - state.filtered)
    measured = math.isfinite(inputs.velocity)
    error = filtered + inputs.correction - inputs.velocity if measured else 0.0
    asked = asked_torque(parameters.feedback, state.feedback)
    cut = inputs.realised_torque - asked if not first and math.isfinite(inputs.realised_torque) else 0.0
    leap = 0.0
    if not first and not acts_on_plan(inputs):
        foreseen = (state.foreseen - state.last_reference) * (duration / parameters.period)
        leap = follows * (inputs.reference - state.last_reference - foreseen)
    level = speed_level(parameters, state, parameters.tuning.standing)
    return Period(filtered, error, asked + cut, cut, leap, measured, level)


def learn_from(parameters: AdaptiveParameters, state: AdaptiveState, inputs: Inputs, period: Period) -> Learnt:
    """Advance the responses, the gate and, after each interval, the estimates."""
    pi, machine, duration, count = parameters.feedback, parameters.machine, inputs.dt, state.psi.size
    observer, noise, interval, weight, innovation = state.observer, state.noise, state.interval, state.weight, 0.0
    if state.feedback.samples == 0:
        return Learnt(observer, noise, interval, weight, innovation)
    follows, measured, response = duration / (duration + machine.velocity_lag), period.measured, state.response
    for i in range(count):
        leap = period.leap / (follows * duration) if i == INERTIA else 0.0
        response_now = advance_response(response, i, leap, pi, machine.inertia, follows, duration, measured)
        state.sums[i] += response_now
    fed = advance_response(response, count + FED, period.cut, pi, machine.inertia, follows, duration, measured)
    brought = advance_response(response, count + OBSERVED, 0.0, pi, machine.inertia, follows, duration, measured)
    had = advance_response(response, count + OBSERVER, 0.0, pi, machine.inertia, follows, duration, measured)
    apart = 0.0
    if measured:
        observer = judged(observer, period.error + had, brought, min(1.0, duration / parameters.tuning.fade))
        apart = distance_apart(inputs.velocity, period.filtered, period.level)
    interval = Interval(
        interval.error + period.error,
        interval.output + (period.error + fed if measured else 0.0),
        interval.apart + apart,
        interval.duration + duration,
        interval.samples + 1,
    )
    if interval.samples >= machine.span or not measured:
        if measured:
            noise = next_noise(noise, parameters.tuning, interval.error / interval.samples, interval.duration)
        for i in range(count):
            state.sums[i] /= interval.samples
        if state.enabled and state.rested * pi.integral <= pi.proportional:
            weight, innovation = learn_in_place(parameters, state, noise, interval, inputs.reference != 0.0, measured)
        for i in range(count):
            state.sums[i] = 0.0
        interval = Interval(0.0, 0.0, 0.0, 0.0, 0)
    return Learnt(observer, noise, interval, weight, innovation)


def observe(
    parameters: AdaptiveParameters,
    state: AdaptiveState,
    inputs: Inputs,
    period: Period,
    observer: Observer,
    rests: bool,
) -> tuple[float, float]:
    """Return the observed torque (N m) and its gain; both stay while nothing can be observed."""
    moves = abs(inputs.velocity) > speed_level(parameters, state, parameters.tuning.moving)
    known = period.measured and state.measured and state.feedback.samples > 0
    if not known or not math.isfinite(inputs.realised_torque) or (rests and not moves):
        return observer.torque, observer.gain
    change = (period.error - period.leap - state.error) / inputs.dt
    torque = observed(parameters, state, period.torque, period.error, change, inputs.dt)
    return torque, gate(parameters, observer, speed_level(parameters, state, 1.0))


def step_adaptive(parameters: AdaptiveParameters, state: AdaptiveState, inputs: Inputs) -> tuple[Output, AdaptiveState]:
    """Do one sample: learn from the period that has ended, feed forward for the coming one, then feedback."""
    inputs, guard = plausible_inputs(parameters.feedback, state.feedback, inputs)
    pi, machine, tuning = parameters.feedback, parameters.machine, parameters.tuning
    samples, duration = state.feedback.samples, inputs.dt
    inputs = without_rounding(inputs, tuning.resting * math.exp(parameters.prior.mean[parameters.prior.mean.size - 1]))
    given = inputs
    if samples == 0:
        begin_in_place(parameters, state)
    if samples > 0 and not math.isfinite(inputs.realised_torque) and machine.torque_known:
        inputs = with_realised_torque(inputs, limited_mean(state.feedback.commands, pi.delay, machine.torque_limit))
    period = end_period(parameters, state, inputs)
    learnt = learn_from(parameters, state, inputs, period)
    following = following_reference(state.last_reference, state.earlier_reference, samples, inputs)
    start, end = coming_reference(inputs, following, pi.delay)
    placed = state.placed or math.isfinite(inputs.position)
    position = inputs.position
    if not math.isfinite(position):
        position = state.position + duration * state.last_reference
    middle = position + (pi.delay + 0.5) * parameters.period * start if placed else math.nan
    fed = feed_in_place(parameters, state, inputs, start, end, middle)
    rests = inputs.reference == 0.0 and start == 0.0 and end == 0.0
    torque, gain = observe(parameters, state, inputs, period, learnt.observer, rests)
    fades = math.exp(-duration / tuning.short_memory) if inputs.reference != 0.0 else 1.0
    peak = max(abs(inputs.reference), state.peak * fades)
    fed_gain = next_gain(parameters, state, peak, fed.largest, duration)
    observer, passed, of_observer = pass_torque(pi, state, fed, learnt.observer, torque, gain, fed_gain)
    feedback = state.feedback._replace(integral=state.feedback.integral - passed)
    unwound = unwound_integral(pi, feedback, inputs) - feedback.integral
    total = fed_gain * (fed.torque + observer.gain * observer.torque)
    count = state.psi.size
    put_in(state.response, count + FED, total, passed - unwound)
    put_in(state.response, count + OBSERVED, fed_gain * observer.torque, -fed_gain * fed.change)
    put_in(state.response, count + OBSERVER, fed_gain * observer.gain * observer.torque, of_observer)
    given_loop = with_reference(with_feedforward(inputs, fed.known + total - inputs.feedforward), period.filtered)
    output, feedback = feed_back(pi, feedback, given_loop, guard)
    command = min(max(output.torque, -machine.torque_limit), machine.torque_limit)
    unit = grown_unit(parameters, state, abs(output.torque - fed.known - fed_gain * observer.gain * observer.torque))
    return Output(command, output.feedforward), state._replace(
        feedback=feedback,
        friction=fed.friction,
        weight=learnt.weight,
        noise=learnt.noise,
        interval=learnt.interval,
        observer=observer,
        watch=next_watch(state.watch, learnt.innovation, given, tuning.short_memory),
        unit=unit,
        filtered=period.filtered,
        error=period.error if period.measured else state.error,
        last_reference=inputs.reference,
        earlier_reference=state.last_reference if samples > 0 else inputs.reference,
        foreseen=following,
        peak=peak,
        position=position if placed else 0.0,
        placed=placed,
        measured=period.measured,
        steady=fed.steady,
        held=fed.held,
        sliding=fed.sliding,
        rested=state.rested + duration if rests else 0.0,
        modelled=remember(state.modelled, fed.known + fed_gain * (fed.torque + fed.kept)),
        fed_gain=fed_gain,
    )


def pass_torque(
    pi: PIParameters, state: AdaptiveState, fed: Fed, observer: Observer, torque: float, gain: float, fed_gain: float
) -> tuple[Observer, float, float]:
    """Return the observer after the sample, the torque that the integral passes on, and the observer's part of that.

    Both torques are in N m, and zero of a loop without an integral.

    What new estimates feed they take from the observer, and where that is off from the integral; so does friction that
    is held at standstill, and a gain that opens.
    """
    old, change = observer.gain, fed.change
    torque -= change
    passed = fed.standing + (1.0 - old) * change + (gain - old) * torque
    own = fed_gain * ((gain - old) * torque - old * change) + (fed_gain - state.fed_gain) * gain * torque
    passed = fed_gain * passed + (fed_gain - state.fed_gain) * (fed.torque + gain * torque - passed)
    if pi.integral <= 0.0:
        passed, own = 0.0, 0.0
    return Observer(torque, gain, observer.error, observer.product, observer.brought), passed, own


def write_monitors(parameters: AdaptiveParameters, state: AdaptiveState, row: NDArray[np.float64]) -> None:
    """Write probability of the loud mode, gain of the observer, and observed torque that is fed (N m) in a row."""
    row[0] = state.weight
    row[1] = state.observer.gain
    row[2] = state.observer.gain * state.observer.torque


STEPS[AdaptiveParameters] = step_adaptive
MONITORS[AdaptiveParameters] = write_monitors
