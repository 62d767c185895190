"""PI loop with friction compensation by a LuGre observer.

C. Canudas de Wit, H. Olsson, K. J. Astrom, P. Lischinsky, "A New Model for Control of Systems with Friction" (1995),
the observer-based compensation of its velocity loop: the bristles' deflection cannot be measured, so the model runs
beside the joint and is corrected by the tracking error,

    dz/dt = v - sigma0 |v|/g(v) z + k e,     f = sigma0 z + sigma2 v,      u = PI(e) + J dr/dt + f.

Variants: the velocity ``v`` is the planned one, since a measured one with noise shakes the bristles of a stiff model at
every rest; the sign of the correction is that of an error ``e = r - w`` here. The equation is solved exactly for a
velocity that is constant over the period. ``k`` in rad per rad: a fraction of the error's integral.
"""

import math
from typing import Any, NamedTuple

from adaptive_ff.friction.feedforward import FeedforwardState, coming_plan
from adaptive_ff.friction.model import TorqueModel, checked_model, directed_friction
from controllers.checks import check_positive
from controllers.declaration import argument, controller, not_negative, positive
from controllers.loops import PILoop
from controllers.pi import PIState, feed_back, plausible_inputs
from controllers.registry import Inputs, Output, with_feedforward
from controllers.torques import slope_torque


class LuGreObserverState(NamedTuple):
    """State of the loop with a LuGre observer."""

    feedback: PIState
    bristles: float = 0.0  # torque ``sigma0 z`` of the bristles, N m
    reference: float = 0.0  # last reference, rad/s


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


def step_lugre_observer(
    parameters: "LuGreObserver", state: LuGreObserverState, inputs: Inputs
) -> tuple[Output, LuGreObserverState]:
    """Do one sample: advance the bristles over the coming period, feed their torque forward, then feedback."""
    inputs, guard = plausible_inputs(parameters.feedback, state.feedback, inputs)
    last, model, period = state.feedback, parameters.model, parameters.period
    past = FeedforwardState(0.0, state.reference, last.samples > 0, 0.0, 0.0)
    start, end = coming_plan(past, inputs, parameters.feedback.delay)
    velocity = 0.5 * (start + end)
    speed = abs(velocity)
    sliding = directed_friction(model, speed, velocity)  # with its sign, viscous part and all
    viscous = (model.viscous + (model.viscous_asymmetry if velocity > 0.0 else -model.viscous_asymmetry)) * velocity
    level = max(abs(sliding - viscous), 1e-9)
    if velocity == 0.0:
        level, viscous = max(model.stiction, 1e-9), 0.0
    valid = math.isfinite(inputs.velocity)
    push = parameters.gain * (inputs.reference + inputs.correction - inputs.velocity) if valid else 0.0
    after = bent(state.bristles, level, parameters.stiffness, velocity, push, period)
    friction = 0.5 * (state.bristles + after) + viscous + model.offset
    inertia = slope_torque(model.inertia, inputs, state.reference, last.samples > 0, period)
    output, feedback = feed_back(parameters.feedback, last, with_feedforward(inputs, inertia + friction), guard)
    return output, LuGreObserverState(feedback, after, inputs.reference)


@controller(step_lugre_observer, LuGreObserverState)
class LuGreObserver(PILoop):
    """``u = PI(e) + J dr/dt + f``, ``f = sigma0 z + sigma2 r``, ``dz/dt = r - sigma0 |r|/g z + k e``."""

    model: TorqueModel = argument(
        checked_model,
        "Static friction and inertia that are assumed; its lag is not used. Coulomb friction is positive.",
        kw_only=False,
    )
    stiffness: float = argument(positive, "Stiffness ``sigma0`` of the bristles, N m/rad.")
    gain: float = argument(not_negative, "Gain ``k`` of the observer.", default=0.0)

    def derive(self) -> dict[str, Any]:
        """Check that the bristles have a level to slip at."""
        check_positive(coulomb=self.model.coulomb)
        return {}
