"""Doubt: samples that are finite and possible, and from which nothing must be learnt all the same.

Sensors, drives and buses now and then give a velocity far beyond any that was planned, a torque far beyond any that was
seen, a plan that leaps, or a time between samples that is not the period. The feedback follows such values, for they
may be true: along a plan that leaps the controller is the PI loop alone. What is learnt and fed forward does not:

- at a doubtful sample the model sees no velocity, and along a plan that leaps it keeps the last plan;
- after it, nothing is learnt until the filters of the identification have forgotten it;
- a plan that stays where it has leapt to is accepted after a second or so, since the speed that counts as possible
  grows meanwhile.

``acting_reference``, the plan for the time at which the torque acts, must begin where the last one ended. Where it does
not, it is ignored for five samples, since half of the values may be right. Without that, a simulated joint whose
``acting_reference`` comes and goes for 2 s is thrown, and tracks twice worse half a minute later.
"""

import math
from typing import Any, NamedTuple

from numba.extending import register_jitable

from adaptive_ff.adaptive.faults.foresight import Foresight, advance_foresight, initial_foresight
from controllers import Guard, Inputs, acts_on_plan, with_next_reference, without_coming_plan

TOO_FAST = 10.0
"""A plan or a correction of more than this many times the possible speed is doubtful, ..."""

TOO_FAST_TO_BE_TRUE = 100.0
"""... a velocity of more than this many times it (joints on steep Stribeck curves do leap, which teaches much), ..."""

TOO_STRONG = 100.0
"""... a torque of more than this many times the largest one so far, or the proportional torque for that speed, ..."""

LATE = 20.0
"""... and a time between samples of more than this many periods, or of less than a period divided by it."""

FORGOTTEN = 20.0
"""Time for which nothing is learnt after a doubtful sample, in time constants of the identification's filters."""

GROWTH = 0.5
"""Time constant with which the possible speed grows while a plan stays far beyond it, s."""

FADING = 10.0
"""Time constant with which the largest speed of the plan fades, s."""

ASIDE = 0.1
"""Largest distance of the beginning of ``acting_reference`` from where the last one ended, in possible speeds."""

CONSISTENT = 5
"""Number of samples for which ``acting_reference`` is ignored after one at which it began further away."""


class Doubt(NamedTuple):
    """Which speeds are possible, and for how long nothing is learnt.

    Attributes
    ----------
    speed : float
        Largest speed of the plan of late, rad/s.
    reference : float
        Last plan that was not doubted, rad/s.
    left : float
        Time for which nothing will be learnt, s.
    doubted : bool
        Whether the last sample was doubted.
    leapt : bool
        Whether it was doubted because its plan leapt.
    coming : float
        Where the last ``next_acting_reference`` was; the last plan where there was none, rad/s.
    aside : int
        Number of samples for which ``acting_reference`` will be ignored.
    foresight : Foresight
        How far the last slope of a plan is continued that is not known ahead.
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
    """Return the state before the first sample."""
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
    """Tell whether a plan (rad/s; not a number if it is not known, which is no leap) is far beyond a speed (rad/s)."""
    return abs(reference) > TOO_FAST * speed


@register_jitable
def possible_speed(block: Any, state: Any) -> float:
    """Return the possible speed (rad/s): the plan's largest, of late or filtered; at least the Stribeck velocity."""
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
    """Return the inputs without ``acting_reference`` if it, or the plan now, leaps or does not begin where it should.

    Several periods ahead, as motion begins, ``acting_reference`` may be beyond all that has been seen. So it is ignored
    then, but the sample is not doubted. Where the next plan is not known, it is foreseen
    (:mod:`adaptive_ff.adaptive.faults.foresight`): a plan that has leapt, and is accepted from now on, stays there;
    extrapolated along its full slope it would leap once more.
    """
    if not math.isfinite(inputs.next_reference):
        inputs = with_next_reference(inputs, doubt.foresight.coming)
    possible = possible_speed(block, state)
    far = leaps(inputs.acting_reference, possible) or leaps(inputs.next_acting_reference, possible)
    return without_coming_plan(inputs) if far or doubt.leapt or doubt.aside > 0 else inputs


@register_jitable
def undoubted_inputs(doubt: Doubt, inputs: Inputs) -> Inputs:
    """Return the inputs as the model is to see them: of a doubtful sample no velocity, of a leap the last plan.

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
