"""Parameters and state of the adaptive controller."""

from typing import NamedTuple

import numpy as np

from adaptive_ff.adaptive.tuning import Tuning
from adaptive_ff.friction.columns import FrictionState, Hypothesis, column_count, initial_friction_state
from adaptive_ff.learning.kalman import LOOP, Estimate, Prior
from adaptive_ff.learning.response import Response, initial_response
from controllers import PIParameters, PIState, initial_pi_state
from controllers.arrays import MutableArray, packed, unpacked
from controllers.delay import delay_line

FED, OBSERVED, OBSERVER, RESPONSES = range(4)
"""Places of further responses, after the columns: to all that is fed, to the observed torque, to what of it is fed."""


class Machine(NamedTuple):
    """What is known of joint, drive and sensor.

    Attributes
    ----------
    inertia : float
        Inertia that the loop was designed for, kg m^2.
    velocity_lag : float
        Lag of the measured velocity, s.
    velocity_noise : float
        Standard deviation of its noise, rad/s; zero where that is unknown.
    torque_limit : float
        Largest torque, N m.
    torque_known : bool
        Whether the drive is known to give what it is asked for, up to the limit.
    includes_inertia : bool
        Whether the known torque includes that of the inertia along the reference.
    memory : float
        Time in which estimates return to the prior, s of motion.
    first_unit : float
        Unit of friction before any torque, N m.
    observer_pole : float
        Pole of the observer, rad/s.
    span : int
        Samples that are learnt from at once.
    friction_share : float
        What of the friction is fed, from 0 to 1.
    offset : float
        Torque that the integral begins with, N m.
    """

    inertia: float
    velocity_lag: float
    velocity_noise: float
    torque_limit: float
    torque_known: bool
    includes_inertia: bool
    memory: float
    first_unit: float
    observer_pole: float
    span: int
    friction_share: float
    offset: float


class AdaptiveParameters(NamedTuple):
    """Parameters of the adaptive controller: loop, machine, what torque consists of, prior, constants, period in s."""

    feedback: PIParameters
    machine: Machine
    hypothesis: Hypothesis
    prior: Prior
    tuning: Tuning
    period: float


class Noise(NamedTuple):
    """Level of the measurement noise from second differences of the mean errors of intervals.

    Attributes
    ----------
    variance : float
        Variance of a mean, (rad/s)^2; at first that of a sample as it was given, zero where it was not.
    last, before : float
        The last two means, rad/s.
    means : int
        Means so far, up to two.
    """

    variance: float
    last: float
    before: float
    means: int


class Interval(NamedTuple):
    """Sums over the samples since the last update of the estimates.

    Attributes
    ----------
    error, output, apart : float
        Sums of the error and of the regressed output, rad/s, and of how far the joint is from its reference.
    duration : float
        Time, s.
    samples : int
        Samples.
    """

    error: float
    output: float
    apart: float
    duration: float
    samples: int


class Observer(NamedTuple):
    """Observer of the torque that the feedforward lacks.

    Attributes
    ----------
    torque : float
        Observed torque, N m.
    gain : float
        Gain with which it is fed, from 0 to 1.
    error, product, brought : float
        Means of the squared error without it, of its product with the response to the observed torque, and of that
        response squared, (rad/s)^2.
    """

    torque: float
    gain: float
    error: float
    product: float
    brought: float


class Watch(NamedTuple):
    """What a diagnosis needs to know.

    Attributes
    ----------
    innovation : float
        Last innovation over its standard deviation.
    square, product : float
        Means of its square, and of its product with the one before.
    torque_known, plan_known : bool
        Whether the torque that acted, and the reference at the next sample, were ever given.
    moved : float
        Time with a reference that is not zero, s.
    """

    innovation: float
    square: float
    product: float
    torque_known: bool
    plan_known: bool
    moved: float


class AdaptiveState(NamedTuple):
    """State of the adaptive controller; arrays are changed in place.

    Attributes
    ----------
    feedback : PIState
        State of the PI loop.
    friction, response : FrictionState, Response
        Memory of the columns, and responses of the loop to them.
    estimate : Estimate
        States of the loop and coefficients.
    given : ndarray
        The coefficients that are fed.
    psi, sums : ndarray, shape (n,)
        Columns of the coming period, and sums over an interval of the responses to them.
    work, multipliers : ndarray
        Room for computations.
    regressors : ndarray
        Further known regressors.
    weight : float
        Probability of the loud mode.
    noise, interval, observer, watch : Noise, Interval, Observer, Watch
        See there.
    unit : float
        Unit of friction: half of the largest torque so far, N m.
    filtered, error : float
        Reference as it is measured, and the last error, rad/s.
    last_reference, earlier_reference, foreseen : float
        The last two references, and what the next one was expected to be, rad/s.
    peak : float
        Peak of the reference, rad/s.
    position : float
        Last position, rad.
    placed, measured : bool
        Whether a position, and the last velocity, were given.
    steady : float
        Torque that the integral holds in the mean, N m.
    held, sliding : float
        Friction that stays at standstill, bent over paths or held there, and all friction along the reference, N m.
    rested : float
        Time for which the reference has rested, s.
    modelled : tuple of float
        Known torque and feedforward, N m, the newest first.
    enabled, feedforward_enabled : bool
        Whether estimates adapt, and whether they are fed.
    fed_gain : float
        Gain of what is fed, from 0 to 1.
    """

    feedback: PIState
    friction: FrictionState
    response: Response
    estimate: Estimate
    given: MutableArray
    psi: MutableArray
    sums: MutableArray
    work: MutableArray
    multipliers: MutableArray
    regressors: MutableArray
    weight: float
    noise: Noise
    interval: Interval
    observer: Observer
    watch: Watch
    unit: float
    filtered: float
    error: float
    last_reference: float
    earlier_reference: float
    foreseen: float
    peak: float
    position: float
    placed: bool
    measured: bool
    steady: float
    held: float
    sliding: float
    rested: float
    modelled: tuple[float, ...]
    enabled: bool
    feedforward_enabled: bool
    fed_gain: float


def initial_adaptive_state(parameters: AdaptiveParameters) -> AdaptiveState:
    """Return the state of a controller at rest that knows its prior."""
    count, unit, pi = column_count(parameters.hypothesis), parameters.machine.first_unit, parameters.feedback
    offset = parameters.machine.offset
    believed = (parameters.tuning.believed * np.exp(parameters.prior.mean[-1])) ** 2
    units = np.where(parameters.prior.scaled, unit, 1.0)
    mean = np.concatenate([np.zeros(LOOP), parameters.prior.mean * units])
    covariance = np.zeros((mean.size, mean.size))
    covariance[LOOP:, LOOP:] = unpacked(parameters.prior.covariance) * np.outer(units, units)
    return AdaptiveState(
        feedback=initial_pi_state(pi)._replace(integral=offset),
        friction=initial_friction_state(parameters.hypothesis),
        response=initial_response(count + RESPONSES, pi.delay),
        estimate=Estimate(mean, packed(covariance)),
        given=mean[LOOP:-2].copy(),
        psi=np.zeros(count),
        sums=np.zeros(count),
        work=np.zeros(mean.size),
        multipliers=np.zeros(count),
        regressors=np.zeros(parameters.hypothesis.regressors),
        weight=0.5,
        noise=Noise(parameters.machine.velocity_noise**2, 0.0, 0.0, 0),
        interval=Interval(0.0, 0.0, 0.0, 0.0, 0),
        observer=Observer(0.0, 0.0, believed, believed, believed),
        watch=Watch(0.0, 0.0, 0.0, False, False, 0.0),
        unit=unit,
        filtered=0.0,
        error=0.0,
        last_reference=0.0,
        earlier_reference=0.0,
        foreseen=0.0,
        peak=0.0,
        position=0.0,
        placed=False,
        measured=False,
        steady=offset,
        held=0.0,
        sliding=0.0,
        rested=0.0,
        modelled=delay_line(pi.delay),
        enabled=True,
        feedforward_enabled=True,
        fed_gain=1.0,
    )
