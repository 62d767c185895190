"""Parameters and state of the observer; see :mod:`adaptive_ff.adaptive.supervision.observer`."""

from typing import NamedTuple

from numba.extending import register_jitable

from adaptive_ff.adaptive.supervision.colour import Colour, initial_colour
from adaptive_ff.adaptive.supervision.noise_level import NoiseState, initial_noise
from adaptive_ff.adaptive.supervision.observer_effect import ObserverEffect, initial_effect
from adaptive_ff.model.loop_response import LoopResponse, initial_loop_response
from controllers import PIParameters, delay_line


class ObserverParameters(NamedTuple):
    """Parameters of the observer.

    Attributes
    ----------
    pole : float
        Pole ``p``, rad/s.
    standing_pole : float
        Pole while the joint stands and nothing has been learnt, rad/s.
    inertia : float
        Inertia that the feedback was designed for, kg m^2.
    velocity_lag : float
        Time by which the measured velocity lags behind the joint's, s.
    period : float
        Nominal period, s.
    """

    pole: float
    standing_pole: float
    inertia: float
    velocity_lag: float
    period: float


class ObserverState(NamedTuple):
    """State of the observer.

    Attributes
    ----------
    disturbance : float
        Observed torque ``d`` that the feedforward lacks, N m.
    gain : float
        Gain ``g`` with which it is fed back.
    velocity : float
        Last measured velocity, rad/s.
    reference : float
        Last reference behind the low-pass of the measured velocity, rad/s.
    lagged_torque : float
        Torque beyond the feedforward behind that low-pass, N m.
    fed : tuple of float
        Torques that were fed forward, N m, the newest first, as far back as the drive may still apply them.
    squared : float
        Short mean of ``d^2``, N^2 m^2.
    response : LoopResponse
        What the loop would make of the residual; its velocity is ``ehat``.
    predicted_squared : float
        Short mean of ``ehat^2``, rad^2/s^2.
    noise : NoiseState
        Noise of the measured velocity.
    error : float
        Error ``e_f`` that the feedback sees, behind a low-pass, rad/s.
    error_squared : float
        Short mean of ``e_f^2``, rad^2/s^2.
    quiet : float
        Slowly rising minimum of the short mean of ``ehat^2``, rad^2/s^2.
    stuck : float
        For how long the joint has stuck while its plan moves, s.
    away : float
        For how much longer it has been far away from its plan than near to it, s; zero at least.
    let_go : bool
        Whether the observer was off because the joint did not answer to it, and the joint has not moved since.
    effect : ObserverEffect
        Whether the observer helps.
    colour : Colour
        What of the noise changes slowly.
    unforeseen : float
        Change of ``reference`` that was not foreseen when the torque of the period was fed forward, rad/s.
    one_way : float
        For how long the plan has moved one way, s.
    """

    disturbance: float
    gain: float
    velocity: float
    reference: float
    lagged_torque: float
    fed: tuple[float, ...]
    squared: float
    response: LoopResponse
    predicted_squared: float
    noise: NoiseState
    error: float
    error_squared: float
    quiet: float
    stuck: float
    away: float
    let_go: bool
    effect: ObserverEffect
    colour: Colour
    unforeseen: float
    one_way: float


def initial_observer(feedback: PIParameters) -> ObserverState:
    """Return the state before the first sample: the noise is not known, so the gates are open."""
    line, response, noise = delay_line(feedback.delay), initial_loop_response(feedback), initial_noise()
    effect, colour = initial_effect(), initial_colour()
    return ObserverState(
        disturbance=0.0,
        gain=1.0,
        velocity=0.0,
        reference=0.0,
        lagged_torque=0.0,
        fed=line,
        squared=0.0,
        response=response,
        predicted_squared=0.0,
        noise=noise,
        error=0.0,
        error_squared=0.0,
        quiet=0.0,
        stuck=0.0,
        away=0.0,
        let_go=False,
        effect=effect,
        colour=colour,
        unforeseen=0.0,
        one_way=0.0,
    )


@register_jitable
def start_observer(state: ObserverState, reference: float, velocity: float) -> ObserverState:
    """Return the state at the first sample, from which on differences are taken."""
    return state._replace(velocity=velocity, reference=reference, unforeseen=0.0)
