"""Doubt about what is measured: samples that are finite and possible, and yet nothing to learn from.

A velocity far beyond any that was planned, a torque far beyond any that was seen, a plan that leaps, a time between
samples that is not the period's: sensors, drives and buses make such values. The feedback follows them, for they may be
true: along a plan that leaps the controller is the PI loop alone. What is learnt and fed forward does not: at such a
sample the model keeps the last plan, and after it nothing is learnt until the filters have forgotten it. A plan that
stays is taken for true after a second or so.

The plan for when a torque acts must go on where it said it would, or it is not used for some samples: half of it may be
right. Values that come and go for 2 s else throw a simulated joint so that it tracks twice worse half a minute later.
"""

import math
from typing import Any, NamedTuple

from numba.extending import register_jitable

from adaptive_ff.adaptive.faults.foresight import Foresight, advance_foresight, initial_foresight
from controllers import Guard, Inputs, acts_on_plan, with_next_reference, without_coming_plan

TOO_FAST = 10.0
"""A plan this many times the largest speed of the plan so far is doubted, so is a correction of it, ..."""

TOO_FAST_TO_BE_TRUE = 100.0
"""... a velocity this many times that speed (joints on steep Stribeck curves do leap, and teach much by it) ..."""

TOO_STRONG = 100.0
"""... and a torque this many times the largest one so far, or what the feedback answers to such a speed."""

LATE = 20.0
"""So is a time between samples beyond this many periods, or below that share of one."""

FORGOTTEN = 20.0
"""Time for which nothing is learnt after a doubtful sample, in time constants of the filters."""

GROWTH = 0.5
"""Time constant with which the speed that is thought possible grows while a plan stays beyond it, s."""

FADING = 10.0
"""Time constant with which it fades, s."""


ASIDE = 0.1
"""A coming plan goes on where it does not begin further than this from where the last one ended, in possible speeds."""

CONSISTENT = 5
"""Samples for which it must, after one at which it did not."""


class Doubt(NamedTuple):
    """What is thought possible, and for how long nothing is learnt.

    Attributes
    ----------
    speed : float
        Largest speed of the plan of late, rad/s.
    reference : float
        Last plan that was not doubted, rad/s.
    left : float
        For how long nothing is learnt yet, s.
    doubted : bool
        Whether the last sample was doubted.
    leapt : bool
        Whether it was for its plan.
    coming : float
        Where the plan for when the last torque acts ends; the plan of then where that is not known, rad/s.
    aside : int
        Samples for which the plan for when a torque acts is not used yet.
    foresight : Foresight
        How far the slope of a plan goes on that is not known ahead.
    """

    speed: float
    reference: float
    left: float
    doubted: bool
    leapt: bool
    coming: float
    aside: int
    foresight: Foresight


def initial_doubt() -> Doubt:
    """Return the state of one who has seen nothing."""
    return Doubt(
        speed=0.0,
        reference=0.0,
        left=0.0,
        doubted=False,
        leapt=False,
        coming=0.0,
        aside=0,
        foresight=initial_foresight(),
    )


@register_jitable
def leaps(reference: float, speed: float) -> bool:
    """Tell whether a plan (rad/s), not a number where it is not known, is far beyond a speed (rad/s)."""
    return abs(reference) > TOO_FAST * speed


@register_jitable
def possible_speed(block: Any, state: Any) -> float:
    """Return a speed (rad/s) that what has been seen of plan and motion shows to be possible."""
    speed: float = max(max(state.doubt.speed, state.estimator.levels.speed), block.estimator.form.stribeck_velocity)
    return speed


@register_jitable
def advance_doubt(block: Any, state: Any, inputs: Inputs, guard: Guard) -> Doubt:
    """Return the doubt about a sample.

    Parameters
    ----------
    block, state : NamedTuple
        Parameters and state of an adaptive controller.
    inputs : Inputs
        Inputs of the sample, checked.
    guard : Guard
        Memory of that check.
    """
    before, levels, possible = state.doubt, state.estimator.levels, possible_speed(block, state)
    strongest = TOO_STRONG * max(levels.torque, block.feedback.proportional * possible)
    speed = max(before.speed * math.exp(-inputs.dt / FADING), abs(inputs.reference))
    doubted = guard.faults > state.feedback.guard.faults
    doubted = doubted or not LATE * inputs.dt >= block.period or not inputs.dt <= LATE * block.period
    doubted = doubted or abs(inputs.velocity) > TOO_FAST_TO_BE_TRUE * possible
    doubted = doubted or abs(inputs.correction) > TOO_FAST * possible
    doubted = doubted or abs(inputs.realised_torque) > strongest or abs(inputs.feedforward) > strongest
    reference, leapt = inputs.reference, leaps(inputs.reference, possible) or leaps(inputs.next_reference, possible)
    if leapt:
        reference, speed = before.reference, possible * math.exp(min(inputs.dt, block.period) / GROWTH)
    coming, aside = inputs.reference, max(0, before.aside - 1)
    if acts_on_plan(inputs):
        coming = inputs.next_acting_reference
        if state.feedback.samples > 0 and abs(inputs.acting_reference - before.coming) > ASIDE * possible:
            aside = CONSISTENT
    slope = reference - before.reference if state.feedforward.started else 0.0
    following = math.nan if leapt else inputs.next_reference
    foresight = advance_foresight(before.foresight, reference, following, slope, inputs.dt)
    if doubted or leapt:
        return Doubt(
            speed=speed,
            reference=reference,
            left=FORGOTTEN / block.estimator.form.pole,
            doubted=True,
            leapt=leapt,
            coming=coming,
            aside=aside,
            foresight=foresight,
        )
    return Doubt(
        speed=speed,
        reference=reference,
        left=max(0.0, before.left - inputs.dt),
        doubted=False,
        leapt=False,
        coming=coming,
        aside=aside,
        foresight=foresight,
    )


@register_jitable
def believed_plan(block: Any, state: Any, doubt: Doubt, inputs: Inputs) -> Inputs:
    """Return the inputs without the plan for when the torque acts where that, or the plan now, leaps or does not go on.

    Several periods ahead it may be beyond all that has been seen as motion begins, so that alone is no cause for doubt.
    Where the next sample is not known, the plan goes on as far as it has before: one that has leapt, and is believed
    from now on, stands; extrapolated in full, it would leap once more.
    """
    if not math.isfinite(inputs.next_reference):
        inputs = with_next_reference(inputs, doubt.foresight.coming)
    possible = possible_speed(block, state)
    far = leaps(inputs.acting_reference, possible) or leaps(inputs.next_acting_reference, possible)
    return without_coming_plan(inputs) if far or doubt.leapt or doubt.aside > 0 else inputs


@register_jitable
def undoubted_inputs(doubt: Doubt, inputs: Inputs) -> Inputs:
    """Return the inputs as the model is to see them: of a doubtful sample no motion, of a leap the last plan.

    The torque of the drive stays: without it the filters would take what the feedback asked for, without a limit.
    """
    if not doubt.doubted:
        return inputs
    return inputs._replace(
        reference=doubt.reference,
        velocity=math.nan,
        next_reference=doubt.reference if doubt.leapt else inputs.next_reference,
        correction=0.0,
    )
