"""Friction that goes on rising with the speed, told apart from the limit of a drive.

Such friction (a thick grease, or a sign of the velocity that a simulation smooths) looks like torque that the drive
does not give: at every larger speed more is asked for than was proven. But torque that never acts winds up whatever
speed the joint has. Friction is one curve over the speed, through or above zero and bent down. So a line is fitted to
resistance ``R`` over speed, from the last 25 integral times of motion, and accepted if

    r^2 > 0.6,    0 < (dR/d|w|) |w|_mean/R_mean < 1

with the correlation ``r``. Above the mean speed the resistance ``R_p`` is then raised along the line, by a factor of 4
at most (:func:`risen`).

- *After something is proven*, the line is fitted to motion in which the joint follows.
- *Before*, it is fitted to all motion, and judged only while a drive has seemed to saturate, so that the feedback is
  alone, and after 25 integral times of motion. Sooner, drives that do saturate are fed friction that never acts
  (windows of 74 times PI's error).

Evidence: of 60 drives that saturate and were doubted for so long (seeds 101 and 201) the line of one would be accepted;
of multisines against ``Fc tanh(w/width)``, with a width of 0.05 and 0.2 rad/s, those of all seven are. With 0.2 rad/s
the controller settles at 24 to 28 times better than PI, as with the torque of the drive reported. Taken for a limit,
that friction leaves it at 1.3 times on two of four references (seeds 105 to 108).
"""

from typing import NamedTuple

from numba.extending import register_jitable

MEMORY = 25.0
"""Time of motion that counts, and after which a drive that has seemed to saturate is judged, integral times.

With 12 the first 5 s of the joints with a width of 0.2 rad/s are at 3.4 times better than PI, not at 2, but one of 200
drives that do saturate settles below PI (seed 201).
"""

LIKE_ONE_CURVE = 0.6
"""Least ``r^2`` of resistance and speed, for an accepted line."""

FURTHEST = 4.0
"""Largest factor by which the line raises a resistance."""


class RisingResistance(NamedTuple):
    """Moments of resistance and speed.

    Attributes
    ----------
    lasted : float
        Time of motion that they are taken over, s.
    speed, resistance : float
        Means, rad/s and N m.
    speed_variance, covariance, resistance_variance : float
        Variances and covariance of the two, rad^2/s^2, N m rad/s and N^2 m^2.
    believed : bool
        Whether the line is used before any torque is proven.
    """

    lasted: float
    speed: float
    resistance: float
    speed_variance: float
    covariance: float
    resistance_variance: float
    believed: bool


def initial_rising_resistance() -> RisingResistance:
    """Return the state before any motion."""
    return RisingResistance(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, False)


@register_jitable
def advance_rising_resistance(
    state: RisingResistance, speed: float, resistance: float, integral_time: float, duration: float
) -> RisingResistance:
    """Return the moments after a period (s) of motion at a speed (rad/s) against a resistance (N m)."""
    share = duration / (duration + min(state.lasted, MEMORY * integral_time))
    faster, more = speed - state.speed, resistance - state.resistance
    return RisingResistance(
        state.lasted + duration,
        state.speed + share * faster,
        state.resistance + share * more,
        (1.0 - share) * (state.speed_variance + share * faster * faster),
        (1.0 - share) * (state.covariance + share * faster * more),
        (1.0 - share) * (state.resistance_variance + share * more * more),
        state.believed,
    )


@register_jitable
def rises(state: RisingResistance) -> bool:
    """Tell whether the line is accepted: the resistance is one curve over the speed, as rising friction is."""
    covariance = state.covariance
    alike = covariance * covariance > LIKE_ONE_CURVE * state.speed_variance * state.resistance_variance
    return covariance > 0.0 and alike and covariance * state.speed < state.speed_variance * state.resistance


@register_jitable
def can_be_judged(state: RisingResistance, integral_time: float) -> bool:
    """Tell whether there has been enough motion since the last judgement, for an integral time (s)."""
    return state.lasted > MEMORY * integral_time


@register_jitable
def judged(state: RisingResistance) -> RisingResistance:
    """Return the moments with the line accepted or rejected; motion before now does not count any more."""
    return state._replace(lasted=0.0, believed=rises(state))


@register_jitable
def risen(state: RisingResistance, resistance: float, speed: float, proven: bool) -> float:
    """Return a resistance (N m), proven or usual, raised along the line for a speed (rad/s)."""
    if speed <= state.speed or not (proven or state.believed) or not rises(state):
        return resistance
    line = state.resistance + state.covariance / state.speed_variance * (speed - state.speed)
    return min(max(resistance, line), FURTHEST * resistance)
