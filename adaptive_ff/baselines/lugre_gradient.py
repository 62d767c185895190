"""PI loop with a LuGre feedforward whose parameters a gradient method tunes while it works.

After the idea of F. Altpeter, M. Grunenberg, P. Myszkowski, R. Longchamp, "Auto-tuning of feedforward friction
compensation based on the gradient method" (2000); its text could not be compared, and no number of it is claimed. The
friction of a LuGre model along the plan ``r`` is fed forward, and its parameters ``p`` descend along the gradient of
the squared tracking error:

    dy/dt = sigma0 (r - |r| y/g(r)),   g(r) = Fc + (Fs - Fc) exp(-|r/Vs|^delta),   f = y + sigma2 r + offset
    dp/dt = -rate e de/dp,             de/dp = -G df/dp,                            G = s / (J s^2 + Kp s + Ki)

``y`` is the torque of the bristles; ``G`` is what the loop makes of a torque. The sensitivities ``dy/dp`` are the exact
derivatives of the discrete law, all along the plan: noise of the measurement is in ``e`` alone.

As chosen here:

- *Parameters*: inertia, ``sigma2``, offset, ``Fc``, ``Fs`` and ``sigma0``; ``Vs`` and ``delta`` are assumed. There is
  no damping ``sigma1`` of the bristles. What is known at the start is the inertia; ``sigma0`` begins with a given one.
- *Gradient* normalised: with a unit ``s_i`` of each parameter, ``dp_i = share s_i^2 v_i e/(floor^2 + sum (s v)^2)`` and
  ``v = G df/dp``; the floor keeps a joint at rest from learning noise.
- ``G`` is that of the assumed inertia and the loop without delay, sampled as the loop is.
- Learning pauses where the measurement failed or the drive did not give what was asked.
- Inertia and ``sigma0`` stay within a range, ``Fc`` above zero, ``Fs`` at ``Fc`` or above, ``sigma2`` not negative.
"""

import math
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.baselines.refusal import was_refused
from adaptive_ff.friction.bounds import INERTIA_RANGE, VISCOUS_SHARE
from adaptive_ff.friction.feedforward import FeedforwardState, coming_plan
from adaptive_ff.friction.identifying import IdentifyingController
from adaptive_ff.friction.model import adhesion_share
from controllers import (
    ESTIMATES,
    STEPS,
    Inputs,
    Output,
    PIParameters,
    PIState,
    check_gains,
    check_positive,
    feed_back,
    initial_pi_state,
    plausible_inputs,
    present_inertia,
    with_feedforward,
)
from controllers.arrays import MutableArray

NAMES = ("inertia", "viscous", "offset", "coulomb", "stiction", "stiffness")
"""What is tuned: kg m^2, N m s/rad, N m, N m, N m, N m/rad."""

PARAMETERS = len(NAMES)
INERTIA, VISCOUS, OFFSET, COULOMB, STICTION, STIFFNESS = range(PARAMETERS)
"""Places of the parameters; those from ``COULOMB`` on act through the bristles."""

STIFFNESS_RANGE = 100.0
"""``sigma0`` is assumed to lie within this factor of the one that it begins with."""

LEAST_SHARE = 1e-3
"""Least Coulomb friction, as a share of the unit of torque: the bristles need some level to slip at."""


class LuGreGradientParameters(NamedTuple):
    """Parameters of the controller.

    Attributes
    ----------
    feedback : PIParameters
        The PI loop.
    inertia : float
        Inertia that the feedback was designed for, kg m^2.
    period : float
        Nominal period, s.
    stribeck_velocity, stribeck_shape : float
        Assumed ``Vs`` (rad/s) and ``delta``.
    stiffness : float
        First ``sigma0``, N m/rad.
    scale : ndarray, shape (5,)
        Unit in which each parameter is tuned, of its expected size; that of ``sigma0`` is not in it.
    torque_scale : float
        Unit of torque, N m.
    floor : float
        What is added to the size of the sensitivities, rad/s.
    rate : float
        Learning rate, 1/s.
    damping, spring : float
        Gains of the loop in ``G`` over the inertia, per period: ``Kp T/J`` and ``Ki T^2/J``.
    """

    feedback: PIParameters
    inertia: float
    period: float
    stribeck_velocity: float
    stribeck_shape: float
    stiffness: float
    scale: NDArray[np.float64]
    torque_scale: float
    floor: float
    rate: float
    damping: float
    spring: float


class LuGreGradientState(NamedTuple):
    """State of the controller; its arrays are changed in place.

    Attributes
    ----------
    feedback : PIState
        State of the PI loop.
    parameters : ndarray, shape (6,)
        Parameters of the feedforward.
    bristles : float
        Torque ``y`` of the bristles, N m.
    slopes : ndarray, shape (6,)
        Derivatives of that torque by each parameter.
    sensitivities : ndarray, shape (6,)
        ``G df/dp``: derivatives of the velocity by each parameter.
    integrals : ndarray, shape (6,)
        Second state of ``G`` for each, as velocities.
    reference : float
        Last reference, rad/s.
    enabled : bool
        Whether the parameters are tuned.
    """

    feedback: PIState
    parameters: MutableArray
    bristles: float
    slopes: MutableArray
    sensitivities: MutableArray
    integrals: MutableArray
    reference: float
    enabled: bool


def initial_lugre_gradient_state(block: LuGreGradientParameters) -> LuGreGradientState:
    """Return the state of a controller that knows nothing but the assumed inertia."""
    parameters = np.zeros(PARAMETERS)
    parameters[INERTIA] = block.inertia
    parameters[COULOMB] = parameters[STICTION] = LEAST_SHARE * block.torque_scale
    parameters[STIFFNESS] = block.stiffness
    zeros = (np.zeros(PARAMETERS), np.zeros(PARAMETERS), np.zeros(PARAMETERS))
    return LuGreGradientState(initial_pi_state(block.feedback), parameters, 0.0, *zeros, 0.0, True)


@register_jitable
def unit_of(block: LuGreGradientParameters, parameters: NDArray[np.float64], place: int) -> float:
    """Return the unit in which a parameter is tuned; that of ``sigma0``, which spans decades, is its present value."""
    return parameters[place] if place == STIFFNESS else block.scale[place]  # type: ignore[no-any-return]


@register_jitable
def descend_in_place(block: LuGreGradientParameters, state: LuGreGradientState, error: float, duration: float) -> None:
    """Move the parameters along the gradient of the squared error (rad/s) over a period (s)."""
    found, least = state.parameters, LEAST_SHARE * block.torque_scale
    size = block.floor * block.floor
    for i in range(PARAMETERS):
        scaled = unit_of(block, found, i) * state.sensitivities[i]
        size += scaled * scaled
    share = -math.expm1(-block.rate * duration)
    for i in range(PARAMETERS):
        unit = unit_of(block, found, i)
        found[i] += share * unit * unit * state.sensitivities[i] * error / size
    found[INERTIA] = min(max(found[INERTIA], block.inertia / INERTIA_RANGE), block.inertia * INERTIA_RANGE)
    found[STIFFNESS] = min(max(found[STIFFNESS], block.stiffness / STIFFNESS_RANGE), block.stiffness * STIFFNESS_RANGE)
    found[VISCOUS] = max(found[VISCOUS], 0.0)
    found[COULOMB] = max(found[COULOMB], least)
    found[STICTION] = max(found[STICTION], found[COULOMB])


@register_jitable
def bend_in_place(block: LuGreGradientParameters, state: LuGreGradientState, velocity: float, adhesion: float) -> float:
    """Advance the bristles and their derivatives over a period of constant velocity; return their torque after it.

    With ``g`` constant the law is ``y+ = g d + (y - g d) k``, ``k = exp(-sigma0 |v| T/g)``, ``d = sgn v``.

    Parameters
    ----------
    block, state : NamedTuple
        Parameters and state; the derivatives are changed in place.
    velocity : float
        Planned velocity over the period, rad/s.
    adhesion : float
        Share of stiction in ``g`` at this velocity.
    """
    values, slopes = state.parameters, state.slopes
    level = values[COULOMB] + (values[STICTION] - values[COULOMB]) * adhesion
    way = 0.0 if velocity == 0.0 else math.copysign(1.0, velocity)
    distance = abs(velocity) * block.period
    decay = values[STIFFNESS] * distance / level
    keep = math.exp(-decay)
    open_gap = (state.bristles - level * way) * keep
    by_level = way * (1.0 - keep) + open_gap * decay / level
    slopes[COULOMB] = by_level * (1.0 - adhesion) + slopes[COULOMB] * keep
    slopes[STICTION] = by_level * adhesion + slopes[STICTION] * keep
    slopes[STIFFNESS] = slopes[STIFFNESS] * keep - open_gap * distance / level
    return level * way + open_gap  # type: ignore[no-any-return]


@register_jitable
def filter_in_place(block: LuGreGradientParameters, state: LuGreGradientState, place: int, torque: float) -> None:
    """Pass the derivative of the torque by a parameter through ``G``, sampled as the loop samples it."""
    state.integrals[place] += block.spring * state.sensitivities[place]
    pushed = block.period / block.inertia * torque
    state.sensitivities[place] += pushed - block.damping * state.sensitivities[place] - state.integrals[place]


@register_jitable
def step_lugre_gradient(
    block: LuGreGradientParameters, state: LuGreGradientState, inputs: Inputs
) -> tuple[Output, LuGreGradientState]:
    """Do one sample: tune by the last error, feed the friction of the coming period forward, then feedback."""
    inputs, guard = plausible_inputs(block.feedback, state.feedback, inputs)
    last, values = state.feedback, state.parameters
    refused = was_refused(block.feedback, last, inputs.realised_torque, block.torque_scale)
    if state.enabled and last.samples > 0 and not refused and math.isfinite(inputs.velocity):
        descend_in_place(block, state, inputs.reference + inputs.correction - inputs.velocity, inputs.dt)
    past = FeedforwardState(0.0, state.reference, last.samples > 0)
    start, end = coming_plan(past, inputs, block.feedback.delay)
    velocity, slope = 0.5 * (start + end), (end - start) / block.period
    for i in range(COULOMB, PARAMETERS):
        filter_in_place(block, state, i, 0.5 * state.slopes[i])
    adhesion = adhesion_share(abs(velocity), block.stribeck_velocity, block.stribeck_shape)
    bristles = bend_in_place(block, state, velocity, adhesion)
    filter_in_place(block, state, INERTIA, slope)
    filter_in_place(block, state, VISCOUS, velocity)
    filter_in_place(block, state, OFFSET, 1.0)
    for i in range(COULOMB, PARAMETERS):  # the other half of the mean over the period
        state.sensitivities[i] += 0.5 * block.period / block.inertia * state.slopes[i]
    friction = 0.5 * (state.bristles + bristles) + values[VISCOUS] * velocity + values[OFFSET]
    torque = present_inertia(inputs, values[INERTIA]) * slope + friction
    output, feedback = feed_back(block.feedback, last, with_feedforward(inputs, torque), guard)
    return output, state._replace(feedback=feedback, parameters=values, bristles=bristles, reference=inputs.reference)


@register_jitable
def write_lugre_gradient(block: LuGreGradientParameters, state: LuGreGradientState, row: NDArray[np.float64]) -> None:
    """Write the parameters into a row."""
    for i in range(PARAMETERS):
        row[i] = state.parameters[i]


STEPS[LuGreGradientParameters] = step_lugre_gradient
ESTIMATES[LuGreGradientParameters] = write_lugre_gradient


class LuGreGradient(IdentifyingController):
    """``u = PI(e) + J dr/dt + y + sigma2 r + offset``, LuGre bristles ``y(r)``, ``dp/dt = rate e G df/dp``.

    Parameters
    ----------
    proportional, integral : float
        Gains of the PI loop, N m s/rad and N m/rad; the proportional one is positive.
    period : float
        Nominal sampling period, s.
    inertia : float
        Inertia that the feedback was designed for, kg m^2; the first estimate.
    stribeck_velocity, stribeck_shape : float
        Pre-estimated ``Vs`` (rad/s) and ``delta``.
    stiffness : float
        First stiffness ``sigma0`` of the bristles, N m/rad.
    rate : float
        Learning rate, 1/s. It loses its stability at some ``2.2 floor^2 Kp/J``.
    floor : float, optional
        What is added to the size of the sensitivities, as a share of ``Vs``.
    delay : float, optional
        Computation delay of the drive, sampling periods.

    Raises
    ------
    ValueError
        A value is out of range.
    """

    estimate_names = NAMES

    def __init__(
        self,
        proportional: float,
        integral: float,
        period: float,
        *,
        inertia: float,
        stribeck_velocity: float,
        stribeck_shape: float = 1.0,
        stiffness: float,
        rate: float,
        floor: float = 1.2,
        delay: float = 0.0,
    ) -> None:
        feedback = check_gains(proportional, integral, period, delay)
        check_positive(
            proportional=proportional,
            inertia=inertia,
            stribeck_velocity=stribeck_velocity,
            stribeck_shape=stribeck_shape,
        )
        check_positive(stiffness=stiffness, rate=rate, floor=floor)
        torque = float(proportional * stribeck_velocity)
        scale = [inertia, VISCOUS_SHARE * proportional, torque, torque, torque]
        parameters = LuGreGradientParameters(
            feedback=feedback,
            inertia=float(inertia),
            period=float(period),
            stribeck_velocity=float(stribeck_velocity),
            stribeck_shape=float(stribeck_shape),
            stiffness=float(stiffness),
            scale=np.array(scale, dtype=float),
            torque_scale=torque,
            floor=float(floor * stribeck_velocity),
            rate=float(rate),
            damping=min(float(proportional * period / inertia), 1.0),  # so that ``G`` is stable whatever the gains
            spring=min(float(integral * period * period / inertia), 0.25),
        )
        super().__init__(parameters, period, initial_lugre_gradient_state)
