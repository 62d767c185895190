"""Learning: one update of the filter after each interval of samples.

    y = e + G fed = sum_i theta_i (G psi_i) + x_v + noise

Torque that no column explains is white, in two modes: little of it; or much of it, a load that walks at random, and a
short memory. A joint that is apart from its reference has friction that the reference does not tell: white torque of
the size of friction.
"""

import math

from adaptive_ff.adaptive.state import AdaptiveParameters, AdaptiveState, Interval, Noise, Watch
from adaptive_ff.adaptive.tuning import Tuning
from adaptive_ff.learning.kalman import (
    LOOP,
    Modes,
    constrain_in_place,
    flow_in_place,
    forget_loop_in_place,
    return_in_place,
    update_in_place,
)
from controllers import Inputs
from controllers.arrays import row_of


def next_noise(noise: Noise, tuning: Tuning, mean: float, duration: float) -> Noise:
    """Return the level after an interval of a duration (s) with a mean error (rad/s)."""
    variance = noise.variance
    if noise.means >= 2:
        second = mean - 2.0 * noise.last + noise.before
        value = second * second / 6.0
        if variance == 0.0:
            variance = value
        variance += min(1.0, duration / tuning.noise_memory) * (value - variance)
    return Noise(variance, mean, noise.last, min(noise.means + 1, 2))


def speed_level(parameters: AdaptiveParameters, state: AdaptiveState, deviations: float) -> float:
    """Return a speed in standard deviations of the noise of a sample, rad/s."""
    least = least_noise(parameters, state, parameters.period * parameters.machine.span)
    return deviations * math.sqrt(max(state.noise.variance, least) * parameters.machine.span)


def least_noise(parameters: AdaptiveParameters, state: AdaptiveState, duration: float) -> float:
    """Return the least variance of the noise of an interval of a duration (s), (rad/s)^2."""
    level = parameters.tuning.least_noise * state.unit * duration / parameters.machine.inertia
    return level * level


def distance_apart(velocity: float, reference: float, level: float) -> float:
    """Return how far friction at a velocity may be from that along the reference, from 0 (alike) to 1 (reversed).

    Both signs are taken as uncertain below a level, rad/s, above zero.
    """
    return 0.5 * abs(min(max(reference / level, -1.0), 1.0) - min(max(velocity / level, -1.0), 1.0))


def begin_in_place(parameters: AdaptiveParameters, state: AdaptiveState) -> None:
    """Forget the states of the loop, which belong to the motion before, at the first sample."""
    spread = parameters.tuning.load * state.unit if state.unit > parameters.machine.first_unit else 0.0
    forget_loop_in_place(state.estimate, spread)
    for i in range(state.given.size):
        state.given[i] = state.estimate.mean[LOOP + i]


def learn_in_place(
    parameters: AdaptiveParameters, state: AdaptiveState, noise: Noise, interval: Interval, moving: bool, known: bool
) -> tuple[float, float]:
    """Advance the filter by an interval; return the probability of the loud mode, and the normalised innovation."""
    tuning, pi, duration = parameters.tuning, parameters.feedback, interval.duration
    estimate, rate, innovation = state.estimate, duration / parameters.machine.inertia, 0.0
    lag, velocity = estimate.mean[estimate.mean.size - 2], estimate.mean[estimate.mean.size - 1]
    torque, apart = state.unit * rate, interval.apart / interval.samples
    proportional, integral = (pi.proportional, pi.integral * duration) if known else (0.0, 0.0)
    changes = min(0.5, tuning.switching * duration)
    weight = state.weight * (1.0 - changes) + (1.0 - state.weight) * changes
    flow_in_place(estimate, rate, proportional, integral, torque * torque * (apart * apart if known else 1.0))
    estimate.covariance[2] += weight * tuning.load_walk * state.unit * state.unit * duration
    if moving:
        pace = (1.0 - weight) / parameters.machine.memory + weight / tuning.short_memory
        return_in_place(estimate, parameters.prior, state.unit, math.exp(-duration * pace))
    white = torque * torque / duration
    modes = Modes(tuning.quiet * white, tuning.loud * white, weight)
    if known and noise.variance > 0.0:
        variance = max(noise.variance, least_noise(parameters, state, duration))
        y = interval.output / interval.samples
        innovation, weight = update_in_place(
            estimate, state.sums, y, variance, modes, tuning.clip, lag, velocity, state.work
        )
        constrain_in_place(estimate, parameters.prior, state.multipliers)
    else:
        estimate.covariance[0] += (1.0 - weight) * modes.quiet + weight * modes.loud
    return weight, innovation


def grown_unit(parameters: AdaptiveParameters, state: AdaptiveState, torque: float) -> float:
    """Return the unit of friction (N m), with which the prior grows: half of the largest torque but the observer's."""
    unit, prior = state.unit, parameters.prior
    if 0.5 * torque <= unit:
        return unit
    grown = min(0.5 * torque, parameters.tuning.growth * unit)
    squares = grown * grown - unit * unit
    covariance = state.estimate.covariance
    covariance[2] += parameters.tuning.load * parameters.tuning.load * squares
    for i in range(prior.mean.size):
        before, row = row_of(i), row_of(LOOP + i) + LOOP
        for j in range(i + 1):
            if prior.scaled[i] and prior.scaled[j]:
                covariance[row + j] += prior.covariance[before + j] * squares
    return grown


def next_watch(watch: Watch, innovation: float, inputs: Inputs, memory: float) -> Watch:
    """Return what a diagnosis needs after a sample; the innovation is in standard deviations, zero where none was."""
    square, product, last = watch.square, watch.product, watch.innovation
    if innovation != 0.0:
        weight = min(1.0, inputs.dt / memory)
        square += weight * (innovation * innovation - square)
        product += weight * (innovation * last - product)
        last = innovation
    return Watch(
        last,
        square,
        product,
        watch.torque_known or math.isfinite(inputs.realised_torque),
        watch.plan_known or math.isfinite(inputs.next_reference),
        watch.moved + (inputs.dt if inputs.reference != 0.0 else 0.0),
    )
