"""PI loop with a feed-forward friction observer: elasto-plastic friction along a reference, an observer around it.

After the idea of M. Ruderman, "Tracking control of motor drives using feed-forward friction observer (FFFO)" (2013),
with his two-state dynamic friction model with elasto-plasticity; the text could not be compared, and no number of it is
claimed. The model runs along the planned motion, so that its friction is ahead of that of the joint and free of noise;
a Luenberger observer of velocity and remaining torque corrects it:

    q = q_r + (d - q_r) z (1 - ln z),   z = min(|x - x_r|/s, 1),   tau df/dt + f = q g(r) + sigma r
    dw^/dt = (u - f - d^)/J + l1 (w - w^),   dd^/dt = -l2 (w - w^),   u = PI(e) + J dr/dt + f + d^

``x`` is the planned position, ``x_r`` that of the last reversal, ``q_r`` the fraction of friction mobilised there and
``d`` the direction of motion.

As chosen here: the model is a fixed one, as from a data sheet; at standstill, friction fades as in
:mod:`adaptive_ff.friction.feedforward`; the observer is the one of
:mod:`controllers.observers.kalman_disturbance`, whose gains make a second-order filter of it. For ``s -> 0`` the
friction is that of the lagged Stribeck model.
"""

import math
from typing import Any, NamedTuple

from adaptive_ff.baselines.observed_model import WAITING
from adaptive_ff.friction.feedforward import FeedforwardState, coming_plan, lagged_ramp, resting_friction
from adaptive_ff.friction.model import TorqueModel, checked_model, directed_friction
from controllers.declaration import argument, controller, derived, positive
from controllers.delay import delayed, remember
from controllers.loops import Observing, PILoop
from controllers.observers.inertia_observer import ObservedLoopState
from controllers.observers.kalman_disturbance import KalmanDisturbance, filter_and_feed_back
from controllers.pi import plausible_inputs
from controllers.registry import Inputs, Output, with_feedforward


class PreslidingState(NamedTuple):
    """State of elasto-plastic friction along a reference."""

    friction: float  # friction torque ``f`` without the offset, N m
    turned: float  # mobilised fraction ``q_r`` at the last reversal, from -1 to 1
    travel: float  # displacement since then, rad, at most ``s`` either way; its sign is the direction of motion


class FrictionObserverState(NamedTuple):
    """State of the controller."""

    feedback: ObservedLoopState
    presliding: PreslidingState = PreslidingState(0.0, 0.0, 0.0)
    line: tuple[float, ...] = WAITING  # torques fed forward that wait for the delay of the drive, N m, newest first


def mobilised_fraction(presliding: float, turned: float, travel: float) -> float:
    """Return the mobilised fraction ``q`` of friction after a displacement (rad) from a reversal."""
    part = min(abs(travel) / presliding, 1.0)
    if part == 0.0:
        return turned
    return turned + (math.copysign(1.0, travel) - turned) * part * (1.0 - math.log(part))


def mobilised_friction(model: TorqueModel, fraction: float, speed: float, way: float) -> float:
    """Return the torque ``q g + sigma r`` (N m) at a speed (rad/s) in a direction, for a mobilised fraction."""
    viscous = math.copysign(model.viscous * speed, way) + model.viscous_asymmetry * speed
    return fraction * abs(directed_friction(model, speed, way) - viscous) + viscous


def mobilised_ramp(
    model: TorqueModel,
    friction: float,
    fractions: tuple[float, float],
    velocities: tuple[float, float],
    duration: float,
) -> tuple[float, float]:
    """Return integral (N m s) and end (N m) of the lagged friction while fraction and velocity (rad/s) go evenly."""
    way = velocities[0] + velocities[1]
    first = mobilised_friction(model, fractions[0], abs(velocities[0]), way)
    last = mobilised_friction(model, fractions[1], abs(velocities[1]), way)
    return lagged_ramp(friction, first, last, model.friction_lag, duration)


def presliding_friction(
    model: TorqueModel, presliding: float, state: PreslidingState, start: float, end: float, duration: float
) -> tuple[float, PreslidingState]:
    """Let elasto-plastic friction follow a motion that does not reverse, from one velocity (rad/s) to another.

    Returned are the integral of the friction torque (N m s) and the state at the end.
    """
    way = start + end
    if way == 0.0:
        integral, friction = resting_friction(model, state.friction, duration)
        return integral, PreslidingState(friction, state.turned, state.travel)
    turned, travel = state.turned, state.travel
    if way * travel < 0.0:
        turned, travel = mobilised_fraction(presliding, turned, travel), 0.0
    distance, left = 0.5 * abs(way) * duration, presliding - abs(travel)
    integral, friction, first = 0.0, state.friction, mobilised_fraction(presliding, turned, travel)
    if 0.0 < left < distance:  # it breaks away on the way
        steady, part = 2.0 * start / way, left / distance
        breakaway = 2.0 * part / (steady + math.sqrt(steady * steady + 4.0 * (1.0 - steady) * part))
        speed = start + breakaway * (end - start)
        integral, friction = mobilised_ramp(
            model, friction, (first, math.copysign(1.0, way)), (start, speed), breakaway * duration
        )
        start, duration, first = speed, (1.0 - breakaway) * duration, math.copysign(1.0, way)
    travel = min(max(travel + math.copysign(distance, way), -presliding), presliding)
    last = mobilised_fraction(presliding, turned, travel)
    further, friction = mobilised_ramp(model, friction, (first, last), (start, end), duration)
    return integral + further, PreslidingState(friction, turned, travel)


def step_presliding(
    parameters: "FrictionObserver", state: PreslidingState, start: float, end: float
) -> tuple[float, PreslidingState]:
    """Return the mean friction (N m) over a period from one planned velocity (rad/s) to another, and the new state."""
    model, presliding, period = parameters.friction, parameters.presliding, parameters.feedback.period
    if start * end < 0.0:
        turn = period * start / (start - end)
        before, state = presliding_friction(model, presliding, state, start, 0.0, turn)
        after, state = presliding_friction(model, presliding, state, 0.0, end, period - turn)
        return (before + after) / period, state
    integral, state = presliding_friction(model, presliding, state, start, end, period)
    return integral / period, state


def step_friction_observer(
    parameters: "FrictionObserver", state: FrictionObserverState, inputs: Inputs
) -> tuple[Output, FrictionObserverState]:
    """Do one sample: friction along the reference, then the loop with its observer."""
    loop, last = parameters.feedback, state.feedback
    delay = loop.feedback.delay
    inputs, guard = plausible_inputs(loop.feedback, last.feedback, inputs)
    past = FeedforwardState(0.0, last.reference, last.feedback.samples > 0)
    start, end = coming_plan(past, inputs, delay)
    friction, presliding = step_presliding(parameters, state.presliding, start, end)
    aware = ObservedLoopState(last.feedback, last.observer, delayed(state.line, delay), last.reference)
    known = with_feedforward(inputs, friction + parameters.friction.offset)
    output, after = filter_and_feed_back(loop, aware, known, guard)
    return output, FrictionObserverState(after, presliding, remember(state.line, known.feedforward))


@controller(step_friction_observer, FrictionObserverState)
class FrictionObserver(PILoop, Observing):
    """``u = PI(e) + J dr/dt + f(r) + d^``: elasto-plastic friction, ``d^`` from a Luenberger observer."""

    model: TorqueModel = argument(
        checked_model,
        "The joint that is assumed; its inertia is the observer's and must be positive.",
        kw_only=False,
        kept=False,
    )
    presliding: float = argument(positive, "Displacement ``s`` after a reversal until the joint slides, rad.")
    velocity_gain: float = argument(
        positive, "Fraction of the innovation that goes to the velocity; see ``KalmanDisturbance.gains``.", kept=False
    )
    disturbance_gain: float = argument(
        positive, "Torque that the disturbance loses for each unit of innovation, N m s/rad.", kept=False
    )
    feedback: KalmanDisturbance = derived("The PI loop and its observer.")  # type: ignore[assignment]
    friction: TorqueModel = derived("The model without its inertia.")

    def derive(self) -> dict[str, Any]:
        """Return the loop with its observer, and the friction."""
        gains = self.proportional, self.integral, self.period
        observer = {"velocity_gain": self.velocity_gain, "disturbance_gain": self.disturbance_gain}
        loop = KalmanDisturbance(*gains, inertia=self.model.inertia, delay=self.delay, **observer)
        return {"feedback": loop.parameters, "friction": self.model._replace(inertia=0.0)}
