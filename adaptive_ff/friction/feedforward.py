"""Model feedforward: the torque that the reference needs, friction lag included.

``u_ff = J dw_ref/dt + f_ref + offset`` with ``tau df_ref/dt + f_ref = F(w_ref)``, ``F`` without the offset. The
torque is held over a period, so what is computed is its mean over the coming period, with the reference taken as linear
in between: the inertia part is ``J`` times the difference of the reference, the friction part is the integral of the
lagged friction, with the static friction taken as linear in time as well, split where the reference reverses. This
needs the reference one sample ahead; where that is not known, the last slope of the reference is continued.

A drive with a computation delay applies the torque later; it is then computed for where the reference will be by that
time, continued along its slope.

Where the model has a presliding distance ``s``, bristles bend before they slide: the fractions of Coulomb friction and
stiction, ``y = g, h``, follow over the path, ``dy/dx = (F - y)/s``, which is integrated over segments of a period, and
bending is damped: ``c exp(-(w/Vs)^2) s (dU/dt)/Vs`` is added, with ``U = g + h``. The lag in time comes after. This is
the LuGre model with ``s = F/sigma_0`` and ``c = sigma_1 Vs``, but that ``s`` does not depend on the speed.

A reference at rest has no direction. Where it comes to rest most of the Coulomb friction of the last direction is held
for a while, as the joint holds it: bristles stay bent, and under a position loop the joint stays where it stopped. The
rest fades with the lag. The offset is a constant, which no lag changes; it is fed forward at rest as well. A joint that
creeps holds less of it, :func:`released`.

Where the reference reverses, friction can be held in the same way until the reference is beyond zero by a speed,
:func:`turning_speed`. Friction that is turned too early throws a joint that still slides, by ``2 F/J`` times the time;
turned too late it leaves a joint at rest that sticks anyway. Controllers that feed a model ask for that; by itself
friction turns where the reference does.
"""

import math
from typing import NamedTuple

from adaptive_ff.friction.model import TorqueModel, directed_friction, friction_parts, stiction_fraction
from controllers import Inputs, acts_on_plan

HELD = 0.87
"""Share of the Coulomb friction that is held where the plan comes to rest; held in full, noise would push the joint."""

FADING, BENT_FADING = 0.32, 1.0
"""Time constants with which it fades, s: without a presliding distance, and with one (bent bristles spring back)."""

TURNED = 0.027
"""Speed at which a reversed reference turns friction, over the change of speed that friction makes in a period."""

SEGMENTS = 4
"""Pieces of a period over which friction behind a lag over the path is integrated."""


class FeedforwardState(NamedTuple):
    """State of the feedforward, by default at rest."""

    friction: float = 0.0  # lagged friction torque ``f_ref`` without the offset, N m
    reference: float = 0.0  # last reference, rad/s
    started: bool = False  # whether there was one
    slip: float = 0.0  # fraction of Coulomb friction behind the lag over the path, of a model with presliding
    adhesion: float = 0.0  # fraction of stiction behind it


def turning_speed(model: TorqueModel, inertia: float, period: float) -> float:
    """Return the speed of a reversed reference that turns friction, rad/s, for an inertia (kg m^2) and a period (s)."""
    return TURNED * max(model.coulomb, model.stiction) / inertia * period if inertia > 0.0 else 0.0


def resting_friction(model: TorqueModel, friction: float, duration: float) -> tuple[float, float]:
    """Return integral (N m s) and end (N m) of the friction while the reference rests.

    At most ``HELD`` of the Coulomb friction is held and fades with ``FADING``; what is more fades with the lag. Bent
    bristles hold all of it, which fades with ``BENT_FADING``.
    """
    held, fading = min(max(friction, -HELD * model.coulomb), HELD * model.coulomb), FADING
    if model.presliding > 0.0:
        held, fading = friction, BENT_FADING
    excess, faded = friction - held, -math.expm1(-duration / fading)
    integral, friction = held * fading * faded, held * (1.0 - faded)
    if model.friction_lag > 0.0:
        settled = -math.expm1(-duration / model.friction_lag)
        integral += excess * model.friction_lag * settled
        friction += excess * (1.0 - settled)
    return integral, friction


def released(model: TorqueModel, state: FeedforwardState, fraction: float, duration: float) -> FeedforwardState:
    """Return the state after a period (s) at rest of a joint that holds only a fraction of what it would hold.

    What is more fades with the lag.
    """
    if fraction >= 1.0:
        return state
    least = fraction * (max(model.coulomb, model.stiction) if model.presliding > 0.0 else HELD * model.coulomb)
    excess = state.friction - min(max(state.friction, -least), least)
    if model.friction_lag > 0.0:
        excess *= -math.expm1(-duration / model.friction_lag)
    left = state.friction - excess
    return state._replace(friction=left)


def lagged_ramp(friction: float, first: float, last: float, lag: float, duration: float) -> tuple[float, float]:
    """Return integral (N m s) and end (N m) of what follows a ramp with a lag.

    Parameters
    ----------
    friction : float
        What follows, at the start, N m.
    first, last : float
        The ramp at the start and the end, N m.
    lag : float
        Lag, s; without any it is the ramp itself.
    duration : float
        Duration, s.
    """
    if lag <= 0.0 or duration <= 0.0:
        return 0.5 * (first + last) * duration, last
    rate = (last - first) / duration
    settled = -math.expm1(-duration / lag)  # fraction of the way to the ramp's start that it goes
    integral = (first + 0.5 * rate * duration) * duration + (friction - first) * lag * settled
    integral += rate * lag * (lag * settled - duration)
    return integral, last + (friction - first) * (1.0 - settled) - rate * lag * settled


def bent_friction(model: TorqueModel, slip: float, adhesion: float, velocity: float, direction: float) -> float:
    """Return the friction behind the lag over the path, with the micro-damping, N m."""
    ratio = velocity / model.stribeck_velocity
    damping = math.exp(-ratio * ratio) * abs(ratio) * (direction - slip - adhesion)
    _, one_sided = friction_parts(model, abs(velocity))
    sliding = model.coulomb * slip + model.stiction * adhesion + model.viscous * velocity
    return sliding + model.micro_damping * damping + one_sided


def coming_plan(state: FeedforwardState, inputs: Inputs, delay: float) -> tuple[float, float]:
    """Return the plan at the start and at the end of the period in which a torque computed now will act, rad/s.

    Parameters
    ----------
    state : FeedforwardState
        Knows the last reference.
    inputs : Inputs
        Inputs of the sample. Where that part of the plan is not among them it is extrapolated from now and the next
        sample, through stops and corners as well.
    delay : float
        Computation delay of the drive, periods.
    """
    if acts_on_plan(inputs):
        return inputs.acting_reference, inputs.next_acting_reference
    reference, next_reference = inputs.reference, inputs.next_reference
    if not math.isfinite(next_reference):
        next_reference = 2.0 * reference - state.reference if state.started else reference
    shift = delay * (next_reference - reference)
    return reference + shift, next_reference + shift


def is_plan_at_rest(state: FeedforwardState, inputs: Inputs, delay: float) -> bool:
    """Tell whether the plan rests over the period in which a torque computed now will act; see :func:`coming_plan`."""
    start, end = coming_plan(state, inputs, delay)
    return start == 0.0 and end == 0.0


def friction_along(
    model: TorqueModel,
    friction: float,
    slip: float,
    adhesion: float,
    start: float,
    end: float,
    duration: float,
    turned: float = 0.0,
) -> tuple[float, float, float, float]:
    """Let friction, bent parts too, follow a motion that does not reverse; return its integral, it, and the parts.

    Friction of the other direction is held up to the speed ``turned`` (rad/s) by a model without presliding.
    """
    direction, bends = start + end, model.presliding > 0.0
    held = friction * direction < 0.0 and max(abs(start), abs(end)) < turned and not bends
    if direction == 0.0 or held or (bends and duration <= 0.0):
        integral, friction = resting_friction(model, friction, duration)
        return integral, friction, slip, adhesion
    if not bends:
        first = directed_friction(model, abs(start), direction)
        last = directed_friction(model, abs(end), direction)
        integral, friction = lagged_ramp(friction, first, last, model.friction_lag, duration)
        return integral, friction, slip, adhesion
    sign, segment, total = math.copysign(1.0, direction), duration / SEGMENTS, 0.0
    static = bent_friction(model, slip, adhesion, start, sign)
    for i in range(SEGMENTS):
        speed = abs(start + (end - start) * (i + 0.5) / SEGMENTS)
        fraction = stiction_fraction(speed, model.stribeck_velocity, model.stribeck_shape)
        settled = -math.expm1(-speed * segment / model.presliding)
        slip += settled * (sign * (1.0 - fraction) - slip)
        adhesion += settled * (sign * fraction - adhesion)
        velocity = start + (end - start) * (i + 1.0) / SEGMENTS
        last = bent_friction(model, slip, adhesion, velocity, sign)
        integral, friction = lagged_ramp(friction, static, last, model.friction_lag, segment)
        total += integral
        static = last
    return total, friction, slip, adhesion


def step_feedforward(
    model: TorqueModel,
    state: FeedforwardState,
    inputs: Inputs,
    period: float,
    delay: float = 0.0,
    inertia: float = math.nan,
    turned: float = 0.0,
) -> tuple[float, FeedforwardState]:
    """Return the torque (N m) for the coming period, or for the one that a delay makes of it, and the new state.

    Parameters
    ----------
    model : TorqueModel
        The joint.
    state : FeedforwardState
        The state.
    inputs : Inputs
        Inputs of the sample, of which the plan alone matters here.
    period : float
        Length of the coming period, s.
    delay : float, optional
        Computation delay of the drive, periods.
    inertia : float, optional
        Inertia in the present configuration, kg m^2, in the place of the model's; not a number where that holds.
    turned : float, optional
        Speed of a reversed reference up to which friction of the last direction is held, rad/s.
    """
    moved = inertia if math.isfinite(inertia) else model.inertia
    start, end = coming_plan(state, inputs, delay)
    friction, slip, adhesion = state.friction, state.slip, state.adhesion
    if start * end < 0.0:
        turn = period * start / (start - end)
        before, friction, slip, adhesion = friction_along(model, friction, slip, adhesion, start, 0.0, turn, turned)
        rest = period - turn
        after, friction, slip, adhesion = friction_along(model, friction, slip, adhesion, 0.0, end, rest, turned)
        integral = before + after
    else:
        integral, friction, slip, adhesion = friction_along(model, friction, slip, adhesion, start, end, period, turned)
    torque = (moved * (end - start) + integral) / period + model.offset
    return torque, FeedforwardState(friction, inputs.reference, True, slip, adhesion)
