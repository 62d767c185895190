"""What an outer loop can tell of a joint at rest: no less than a count of its encoder.

The planned position at rest is hardly ever a reading of the encoder, so the correction ``c`` is never zero, and the
integral winds up on it until the joint moves by a count; the feedback kicks it back, and it begins again. How often,
is left to the bristles: each kick is as large as that of the PI loop, but where the joint came to rest with less
torque there are up to three times as many of them.

At rest the correction changes by counts alone. The least change ``h`` (rad/s) that comes again and again, against a
measured motion, is one count of the encoder. An error that is not larger is none that the encoder has seen: while the
plan rests, the integral leaves ``max(-h, min(c, h))`` out. The joint then rests within a count and a half of the plan.
A correction that changes by ever smaller steps, as one of a noisy position does, is left as it is, and so is one that
the joint did not make: a joystick's.
"""

from typing import NamedTuple

from numba.extending import register_jitable

ENOUGH = 4
"""Changes of the same least size that make a count: two kicks, there and back."""

ANSWER = 0.5
"""Largest change that answers a motion, in measured velocities: a position loop makes ``Kv T`` of it, less than 0.2."""

SAME = 0.01
"""Changes whose sizes differ by a smaller share are the same."""

TINY = 1e-9
"""A smaller change is one of the arithmetic, rad/s."""


class OuterLoop(NamedTuple):
    """What is known of the correction.

    Attributes
    ----------
    correction : float
        The last one, rad/s.
    step : float
        Least change of it at rest, rad/s.
    seen : int
        Times that it was seen; zero where there was none yet.
    """

    correction: float
    step: float
    seen: int


def initial_outer_loop() -> OuterLoop:
    """Return the state of a loop of which nothing is known."""
    return OuterLoop(0.0, 0.0, 0)


@register_jitable(forceinline=True)
def note_correction(state: OuterLoop, correction: float, velocity: float, rests: bool) -> OuterLoop:
    """Return the state after a correction and a measured velocity (rad/s), while the plan rests or not."""
    change = abs(correction - state.correction)
    answers = (correction - state.correction) * velocity < 0.0 and change < ANSWER * abs(velocity)
    if not (rests and answers) or change < TINY:
        return OuterLoop(correction, state.step, state.seen)
    if state.seen == 0 or change < (1.0 - SAME) * state.step:
        return OuterLoop(correction, change, 1)
    if change > (1.0 + SAME) * state.step:
        return OuterLoop(correction, state.step, state.seen)
    return OuterLoop(correction, state.step, min(state.seen + 1, ENOUGH))


@register_jitable(forceinline=True)
def unseen_error(state: OuterLoop, rests: bool) -> float:
    """Return the part of the last correction that the integral leaves out, rad/s."""
    if not rests or state.seen < ENOUGH:
        return 0.0
    return max(-state.step, min(state.correction, state.step))
