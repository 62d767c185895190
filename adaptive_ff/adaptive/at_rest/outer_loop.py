"""A joint at rest behind a position loop: errors within a count of the encoder are no errors.

**The integral.** The planned position at rest is hardly ever a reading of the encoder, so the correction ``c`` is never
zero. The integral winds up on it until the joint moves by a count, the feedback kicks it back, and it begins again.
Each kick is as large as that of the PI loop, but their number depends on the bristles: where the joint came to rest
with less torque there are up to three times as many.

At rest the correction changes by counts alone. So the least change ``h`` (rad/s) that comes again and again, against a
measured motion, is one count of the encoder, and the encoder cannot have seen a smaller error. While the plan rests,
the integral leaves out ``max(-h, min(c, h))``. The joint then rests within a count and a half of the plan. A correction
that changes by ever smaller steps, as one of a noisy position does, is left as it is; so is one that the joint did not
make, such as a joystick's.

**The proportional part.** A joint at rest on the edge between two readings goes to and fro between them. A velocity
made of the encoder is then a count in a period each time, however little the joint has moved. The proportional gain
makes a kick of it that throws the joint back over the edge; on bristles such kicks hold it there for minutes, although
the integral draws it away. So a play as wide as ``h`` follows the correction at rest, and the feedback sees only that
part of a measured motion that leaves the play: nothing of a count there and back, all of a motion that goes on. For the
first second at rest, while the joint settles and its bristles relax, the feedback sees all of it.
"""

from typing import NamedTuple

from numba.extending import register_jitable

ENOUGH = 4
"""Changes of the same least size that make a count: two kicks, there and back."""

ANSWER = 0.5
"""Largest change that answers a motion, in measured velocities: a position loop makes ``Kv T`` of it, less than 0.2."""

SAME = 0.01
"""Changes whose sizes differ by a smaller share are the same."""

SETTLED = 1.0
"""Time at rest from which on a count there and back is hidden, s.

With 0 s a joint of 20 kg m^2 on bristles of 1e5 N m/rad that rests for 0.5 s between its moves would track 1.2 to 1.6
times worse at 1 kHz (seeds 101 to 108, 1 to 5).
"""

TINY = 1e-9
"""Change of the correction below which it is rounding, rad/s."""


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
    play : float
        Where the correction is in the play, from its middle, rad/s.
    rested : float
        For how long the plan has rested, s; ``SETTLED`` at most.
    """

    correction: float
    step: float
    seen: int
    play: float
    rested: float


def initial_outer_loop() -> OuterLoop:
    """Return the state of a loop of which nothing is known."""
    return OuterLoop(0.0, 0.0, 0, 0.0, 0.0)


@register_jitable
def answers(state: OuterLoop, correction: float, velocity: float) -> bool:
    """Tell whether a correction has changed because the joint moved, by the measured velocity (rad/s)."""
    change = correction - state.correction
    return change * velocity < 0.0 and TINY <= abs(change) < ANSWER * abs(velocity)


@register_jitable
def note_correction(state: OuterLoop, correction: float, velocity: float, rests: bool, duration: float) -> OuterLoop:
    """Return the state after a correction and a measured velocity (rad/s), and a period (s) of rest or not."""
    if not rests:
        return OuterLoop(correction, state.step, state.seen, 0.0, 0.0)
    rested = min(state.rested + duration, SETTLED)
    if not answers(state, correction, velocity):
        return state._replace(correction=correction, rested=rested)
    play, change = play_after(state, correction), abs(correction - state.correction)
    if state.seen == 0 or change < (1.0 - SAME) * state.step:
        return OuterLoop(correction, change, 1, 0.0, rested)
    if change > (1.0 + SAME) * state.step:
        return OuterLoop(correction, state.step, state.seen, play, rested)
    return OuterLoop(correction, state.step, min(state.seen + 1, ENOUGH), play, rested)


@register_jitable
def play_after(state: OuterLoop, correction: float) -> float:
    """Return where a correction (rad/s) that the joint made is in the play, from its middle, rad/s."""
    return max(-0.5 * state.step, min(state.play + correction - state.correction, 0.5 * state.step))


@register_jitable
def unseen_velocity(state: OuterLoop, correction: float, velocity: float, rests: bool) -> float:
    """Return the part of the measured velocity that is none, rad/s; ``state`` is that before the correction."""
    known = state.seen == ENOUGH and state.rested == SETTLED
    if not (rests and known and answers(state, correction, velocity)):
        return 0.0
    return velocity * (play_after(state, correction) - state.play) / (correction - state.correction)


@register_jitable
def unseen_error(state: OuterLoop, rests: bool) -> float:
    """Return the part of the last correction that the integral leaves out, rad/s."""
    if not rests or state.seen < ENOUGH:
        return 0.0
    return max(-state.step, min(state.correction, state.step))
