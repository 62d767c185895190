"""One time step of an elastic joint with backlash and hysteresis in its gear.

    Jm dwm/dt = u - f - offset - T          T = k s + H[s] + c ds/dt
    Jl dwl/dt = T                           s = theta - p,  |p| <= gap/2

Motor and link are those of :mod:`plant.elastic`; the spring between them has a gap in series. ``p`` is where in the gap
the spring's end is: the play operator of the twist ``theta``, since the end has no mass, so that it moves only where it
touches nothing and no torque acts (``T = 0``), and a side can only push. ``H`` is the stop operator, one Maxwell
element beside the spring: it goes with a stiffness ``H0/reach`` until it slips at ``+-H0``. Together they are the lost
motion of a gear: a gap, and a torque that depends on where the twist came from. M. Ruderman, F. Hoffmann, T. Bertram,
"Modeling and identification of elastic robot joints with hysteresis and backlash" (2009), describe joints by such
parts; the equations above are what is simulated here.

Discretised as :mod:`plant.elastic`, with which the step agrees where there is neither gap nor hysteresis: spring and
inertias by the trapezoidal rule, friction at the motor by implicit Euler. Over a step the torque of the gear is a
rising function of the twist after it, made of at most five straight segments (either side of the gap, in it, the
element sticking or slipping). On each of them the step is the elastic joint's; they are walked through from the twist
before the step. Of first order in the period, as a segment that ends within a step is taken for all of it.
"""

import math
from typing import Literal, NamedTuple

from plant.elastic import GearFields, changed_elastic, check_elastic_period, motor_and_link, sensed_elastic
from plant.fields import NonNegative, Positive
from plant.friction import Stribeck
from plant.registry import register
from plant.step import friction_at

SEGMENTS = 5
"""Straight segments of the torque as a function of the twist after a step."""

NEVER = 1e9
"""Twist that is never reached, rad: where an element without torque slips."""


class BacklashParameters(NamedTuple):
    """What the step needs to know of a joint with backlash."""

    motor_inertia: float  # inertia on either side of the gear, kg m^2, both on the joint's side
    link_inertia: float
    friction: Stribeck  # static friction map of forward and of backward motion of the motor
    backward: Stribeck
    offset: float  # constant torque against the motor's, N m, of either sign
    friction_lag: float  # friction lag ``tau``, s, zero or more
    link_stiffness: float  # stiffness ``k`` of the spring, N m/rad
    link_damping: float  # damping ``c`` of the spring, N m s/rad
    half_gap: float  # half of the free play, rad
    hysteresis: float  # torque ``H0`` at which the element slips, N m
    hysteresis_stiffness: float  # stiffness of the element, N m/rad; zero where there is none


class BacklashState(NamedTuple):
    """State of a joint with backlash."""

    velocity: float  # velocity of the link, rad/s
    friction_torque: float  # friction torque ``f`` at the motor, N m, without the offset
    position: float  # position of the motor, rad
    motor_velocity: float  # velocity of the motor, rad/s
    twist: float  # position of the motor less that of the link, rad
    wind: float  # twist ``s`` of the spring, rad; the rest of the twist is the place in the gap
    hysteresis_torque: float  # torque ``H`` of the element, N m


def wound(joint: BacklashParameters, state: BacklashState, winding: float) -> float:
    """Return the torque ``H`` of the element, N m, after the spring has been wound further (rad)."""
    torque = state.hysteresis_torque + joint.hysteresis_stiffness * winding
    return min(max(torque, -joint.hysteresis), joint.hysteresis)


def free_winding(joint: BacklashParameters, state: BacklashState, rate: float) -> float:
    """Return by how much (rad) the spring winds where its end is free: ``k s + H + c ds/dt = 0`` after the step.

    ``rate`` is ``c/h``, N m/rad.
    """
    held = joint.link_stiffness * state.wind
    stiffness = joint.link_stiffness + rate
    winding = -(held + state.hysteresis_torque) / (stiffness + joint.hysteresis_stiffness)
    after = state.hysteresis_torque + joint.hysteresis_stiffness * winding
    if after > joint.hysteresis:
        return -(held + joint.hysteresis) / stiffness
    if after < -joint.hysteresis:
        return -(held - joint.hysteresis) / stiffness
    return winding


def knots(joint: BacklashParameters, state: BacklashState, free: float) -> tuple[float, float, float, float]:
    """Return by how much the twist grows (rad) where the gap ends, below and above, and where the element slips.

    ``free`` is the winding of a spring whose end is free, rad.
    """
    below = state.wind + free - joint.half_gap - state.twist
    above = state.wind + free + joint.half_gap - state.twist
    low, high = -NEVER, NEVER
    if joint.hysteresis_stiffness > 0.0:
        low = (-joint.hysteresis - state.hysteresis_torque) / joint.hysteresis_stiffness
        high = (joint.hysteresis - state.hysteresis_torque) / joint.hysteresis_stiffness
    low += (below if low < free else above) - free
    high += (below if high < free else above) - free
    return below, above, low, high


def in_order(a: float, b: float, c: float, d: float) -> tuple[float, float, float, float]:
    """Return four numbers in ascending order, where ``a <= b`` and ``c <= d``."""
    lowest, inner = min(a, c), max(a, c)
    highest, other = max(b, d), min(b, d)
    return lowest, min(inner, other), max(inner, other), highest


def segment(
    joint: BacklashParameters, state: BacklashState, free: float, rate: float, growth: float
) -> tuple[float, float]:
    """Return level (N m) and stiffness (N m/rad) of the gear's mean torque over a step at a growth of the twist (rad).

    On this straight segment the torque is ``level + stiffness growth``.
    """
    below, above, low, high = knots(joint, state, free)
    before = joint.link_stiffness * state.wind + state.hysteresis_torque
    if below <= growth <= above and below < above:
        after = joint.link_stiffness * (state.wind + free) + wound(joint, state, free)
        return 0.5 * (before + after) + rate * free, 0.0
    place = joint.half_gap if growth > above else -joint.half_gap
    start = state.twist - place - state.wind  # by how much the spring winds if the twist stays
    if low <= growth <= high:
        stiffness = 0.5 * (joint.link_stiffness + joint.hysteresis_stiffness) + rate
        return before + stiffness * start, stiffness
    limit = joint.hysteresis if growth > high else -joint.hysteresis
    stiffness = 0.5 * joint.link_stiffness + rate
    return before + 0.5 * (limit - state.hysteresis_torque) + stiffness * start, stiffness


def step_backlash(joint: BacklashParameters, state: BacklashState, torque: float, period: float) -> BacklashState:
    """Advance a joint with backlash by a solver period (s) under constant torque (N m)."""
    motor, link = state.motor_velocity, state.velocity
    lag_divisor = joint.friction_lag + period
    carried = joint.friction_lag * state.friction_torque / lag_divisor
    half = 0.5 * period
    rate = joint.link_damping / period
    free = free_winding(joint, state, rate)
    below, above, low, high = knots(joint, state, free)
    first, second, third, last = in_order(below, above, low, high)
    ends = (-math.inf, first, second, third, last, math.inf)
    probes = (first - 1.0, 0.5 * (first + second), 0.5 * (second + third), 0.5 * (third + last), last + 1.0)
    guess = half * (motor - link)
    place = 0
    for i in range(1, SEGMENTS):
        if guess > ends[i]:
            place += 1
    next_motor, next_link, growth, static_friction = motor, link, 0.0, 0.0
    for _ in range(SEGMENTS):
        level, stiffness = segment(joint, state, free, rate, probes[place])
        next_motor, next_link, static_friction = motor_and_link(
            joint, state, torque - joint.offset - carried, period, level, half * stiffness
        )
        growth = half * (motor - link + next_motor - next_link)
        if growth > ends[place + 1]:
            place += 1
        elif growth < ends[place]:
            place -= 1
        else:
            break
    winding = free
    if growth > above:
        winding = state.twist + growth - joint.half_gap - state.wind
    elif growth < below:
        winding = state.twist + growth + joint.half_gap - state.wind
    return BacklashState(
        next_link,
        carried + period * static_friction / lag_divisor,
        state.position + half * (motor + next_motor),
        next_motor,
        state.twist + growth,
        state.wind + winding,
        wound(joint, state, winding),
    )


def initial_backlash(joint: BacklashParameters, velocity: float) -> BacklashState:
    """Return the state of a joint that has moved at a velocity (rad/s) for long, in the middle of its gap."""
    friction = friction_at(joint.friction, joint.backward, velocity)
    return BacklashState(velocity, friction, 0.0, velocity, 0.0, 0.0, 0.0)


class BacklashJoint(GearFields):
    """Parameters of a simulated elastic joint with backlash and hysteresis in its gear, checked.

    Further fields are those of :class:`plant.ElasticJoint`.
    """

    kind: Literal["backlash"] = "backlash"  # kind of joint
    # free play between motor and link, from one side to the other, rad on the joint's side, zero or more
    gap: NonNegative
    # torque that the gear's hysteresis adds to or takes from the spring's, N m, zero or more
    hysteresis: NonNegative = 0.0
    # twist within which a reversal takes the hysteresis from zero to all of it, rad, positive
    hysteresis_reach: Positive = 0.001

    @property
    def parameters(self) -> BacklashParameters:
        """The parameters as the step takes them."""
        return BacklashParameters(
            *self.motor_and_link,
            half_gap=0.5 * self.gap,
            hysteresis=self.hysteresis,
            hysteresis_stiffness=self.hysteresis / self.hysteresis_reach,
        )


def check_backlash_period(joint: BacklashParameters, period: float) -> None:
    """Refuse a solver period that does not suit the elastic joint with the stiffness of the element that sticks."""
    stiffness = joint.link_stiffness + joint.hysteresis_stiffness
    check_elastic_period(joint._replace(link_stiffness=stiffness), period)


register(
    BacklashParameters,
    BacklashState,
    step_backlash,
    initial_backlash,
    check_backlash_period,
    changed_elastic,
    sensed=sensed_elastic,
)
