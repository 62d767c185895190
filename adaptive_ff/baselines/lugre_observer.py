"""PI loop with friction compensation by a LuGre observer.

C. Canudas de Wit, H. Olsson, K. J. Astrom, P. Lischinsky, "A New Model for Control of Systems with Friction" (1995),
the observer-based compensation of its velocity loop: the bristles' deflection cannot be measured, so the model runs
beside the joint and is corrected by the tracking error,

    dz/dt = v - sigma0 |v|/g(v) z + k e,     f = sigma0 z + sigma2 v,      u = PI(e) + J dr/dt + f.

Variants: the velocity ``v`` is the planned one, since a measured one with noise shakes the bristles of a stiff model at
every rest; the sign of the correction is that of an error ``e = r - w`` here. The equation is solved exactly for a
velocity that is constant over the period. ``k`` in rad per rad: a share of the error's integral.
"""

import math
from typing import NamedTuple

from numba.extending import register_jitable

from adaptive_ff.friction.feedforward import FeedforwardState, coming_plan
from adaptive_ff.friction.model import TorqueModel, directed_friction
from controllers import (
    ESTIMATES,
    STEPS,
    Controller,
    Inputs,
    Output,
    PIParameters,
    PIState,
    check_gains,
    check_positive,
    feed_back,
    initial_pi_state,
    plausible_inputs,
    slope_torque,
    with_feedforward,
    without_estimates,
)


class LuGreObserverParameters(NamedTuple):
    """Parameters of the loop with a LuGre observer.

    Attributes
    ----------
    feedback : PIParameters
        The PI loop.
    model : TorqueModel
        Static friction and inertia that are assumed.
    stiffness : float
        Stiffness ``sigma0`` of the bristles, N m/rad.
    gain : float
        Gain ``k`` of the observer.
    period : float
        Nominal period, s.
    """

    feedback: PIParameters
    model: TorqueModel
    stiffness: float
    gain: float
    period: float


class LuGreObserverState(NamedTuple):
    """State of the loop with a LuGre observer.

    Attributes
    ----------
    feedback : PIState
        State of the PI loop.
    bristles : float
        Torque ``sigma0 z`` of the bristles, N m.
    reference : float
        Last reference, rad/s.
    """

    feedback: PIState
    bristles: float
    reference: float


def initial_lugre_observer_state(block: LuGreObserverParameters) -> LuGreObserverState:
    """Return the state of a loop at rest."""
    return LuGreObserverState(initial_pi_state(block.feedback), 0.0, 0.0)


@register_jitable
def bent(bristles: float, level: float, stiffness: float, velocity: float, push: float, duration: float) -> float:
    """Return the bristles' torque (N m) after a constant velocity, with a correction ``push`` (rad/s) on top.

    The exact solution of ``dy/dt = sigma0 (v + push) - sigma0 |v|/level y``, bounded by the level.
    """
    decay = stiffness * abs(velocity) / level
    drive = stiffness * (velocity + push)
    if decay * duration < 1e-9:
        after = bristles + drive * duration
    else:
        settled = drive / decay
        after = settled + (bristles - settled) * math.exp(-decay * duration)
    return min(max(after, -level), level)


@register_jitable
def step_lugre_observer(
    block: LuGreObserverParameters, state: LuGreObserverState, inputs: Inputs
) -> tuple[Output, LuGreObserverState]:
    """Do one sample: advance the bristles over the coming period, feed their torque forward, then feedback."""
    inputs, guard = plausible_inputs(block.feedback, state.feedback, inputs)
    last, model = state.feedback, block.model
    past = FeedforwardState(0.0, state.reference, last.samples > 0, 0.0, 0.0)
    start, end = coming_plan(past, inputs, block.feedback.delay)
    velocity = 0.5 * (start + end)
    speed = abs(velocity)
    sliding = directed_friction(model, speed, velocity)  # with its sign, viscous part and all
    viscous = (model.viscous + (model.viscous_asymmetry if velocity > 0.0 else -model.viscous_asymmetry)) * velocity
    level = max(abs(sliding - viscous), 1e-9)
    if velocity == 0.0:
        level, viscous = max(model.stiction, 1e-9), 0.0
    valid = math.isfinite(inputs.velocity)
    push = block.gain * (inputs.reference + inputs.correction - inputs.velocity) if valid else 0.0
    after = bent(state.bristles, level, block.stiffness, velocity, push, block.period)
    friction = 0.5 * (state.bristles + after) + viscous + model.offset
    inertia = slope_torque(model.inertia, inputs, state.reference, last.samples > 0, block.period)
    output, feedback = feed_back(block.feedback, last, with_feedforward(inputs, inertia + friction), guard)
    return output, LuGreObserverState(feedback, after, inputs.reference)


STEPS[LuGreObserverParameters] = step_lugre_observer
ESTIMATES[LuGreObserverParameters] = without_estimates


class LuGreObserver(Controller):
    """``u = PI(e) + J dr/dt + f``, ``f = sigma0 z + sigma2 r``, ``dz/dt = r - sigma0 |r|/g z + k e``: LuGre observer.

    Parameters
    ----------
    proportional, integral : float
        Gains of the PI loop, N m s/rad and N m/rad.
    period : float
        Nominal sampling period, s.
    model : TorqueModel
        Static friction and inertia that are assumed; its lag is not used. Coulomb friction is positive.
    stiffness : float
        Stiffness ``sigma0`` of the bristles, N m/rad.
    gain : float, optional
        Gain ``k`` of the observer, zero or more.
    delay : float, optional
        Computation delay of the drive, sampling periods.

    Raises
    ------
    ValueError
        A value is out of range.
    """

    def __init__(
        self,
        proportional: float,
        integral: float,
        period: float,
        model: TorqueModel,
        *,
        stiffness: float,
        gain: float = 0.0,
        delay: float = 0.0,
    ) -> None:
        feedback = check_gains(proportional, integral, period, delay)
        check_positive(stiffness=stiffness, coulomb=model.coulomb)
        if not 0.0 <= gain < math.inf:
            raise ValueError(f"gain = {gain} is not allowed: it must be finite and not negative")
        numbers = TorqueModel(*(float(value) for value in model))
        parameters = LuGreObserverParameters(feedback, numbers, float(stiffness), float(gain), float(period))
        super().__init__(parameters, period, initial_lugre_observer_state)
