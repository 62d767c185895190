"""One implicit time step of a joint with two-state elasto-plastic friction: a presliding curve, then a lag.

After M. Ruderman, T. Bertram, "Two-state dynamic friction model with elasto-plasticity" (2013):

    J dw/dt = u - f - offset
    q = q_r + (d - q_r) z (1 - ln z),      z = min(|x - x_r|/s, 1)
    tau df/dt + f = q g(w) + sigma w

First state: ``q`` in [-1, 1], the fraction of friction that is mobilised. It depends on the displacement since the last
reversal at ``x_r``, where it was ``q_r``, and on the direction ``d`` of motion; after a displacement ``s`` it is ``d``:
sliding. Second state: ``f`` follows with the lag ``tau`` of the paper's (1). ``g(w) = Fc + (Fs - Fc) exp(-|w/Vs|^d)``
is the paper's (3) without its viscous part. For ``s -> 0`` this is the joint of :mod:`plant.step`.

Variant: the source lets the torque itself run along ``z (1 - ln z)`` from reversal to reversal; here the fraction does,
times the Stribeck curve. While the curve is constant both are the same; where it falls, the fraction keeps friction
rising with the displacement, so that the step has one solution. The published equations could not be compared word by
word.

Limits: only the last reversal is remembered. A cycle of displacement closes after some repetitions, but a torque that
vibrates around a mean below breakaway lets the joint creep, as with LuGre bristles.

With a lag the joint does not come to rest by itself: friction that rises with the displacement is a spring, and one
behind a lag feeds the vibration that it should stop (``J tau p^3 + J p^2 + k`` has unstable roots for every ``k``).
The vibration grows with ``s``; feedback of the velocity stops it.

Discretised by the implicit Euler method, of first order in the period.
"""

import math
from typing import Literal, NamedTuple

from plant.fields import NonNegative, Positive
from plant.friction import Stribeck, steepest_fall, yield_torque
from plant.joint import (
    FALLING,
    FrictionFields,
    check_gentle_at_rest,
    longest_gentle_period,
    longest_with_lag,
    refuse_period,
)
from plant.registry import register
from plant.sliding import MAXIMUM_ITERATIONS, next_speed
from plant.step import changed_joint, friction_at

UNDERFLOW = 1e-300
"""Fraction of the presliding displacement below which a step leaves the joint at rest: floats end soon after."""


class ElastoPlasticParameters(NamedTuple):
    """What the step needs to know of an elasto-plastic joint."""

    inertia: float  # inertia ``J``, kg m^2
    friction: Stribeck  # static friction map of forward and of backward motion
    backward: Stribeck
    offset: float  # constant torque against the motor's, N m, of either sign
    friction_lag: float  # friction lag ``tau``, s, zero or more
    presliding: float  # displacement ``s`` after a reversal until the joint slides, rad


class ElastoPlasticState(NamedTuple):
    """State of an elasto-plastic joint."""

    velocity: float  # velocity ``w``, rad/s
    friction_torque: float  # friction torque ``f``, N m, without the offset
    position: float  # position, rad
    turned: float  # mobilised fraction ``q_r`` at the last reversal, from -1 to 1
    travel: float  # displacement since then, rad, at most ``s`` either way; its sign is the direction of motion


def presliding_curve(fraction: float) -> tuple[float, float]:
    """Return ``z (1 - ln z)`` and its slope ``-ln z`` for a fraction ``z > 0`` of the presliding displacement."""
    if fraction >= 1.0:
        return 1.0, 0.0
    logarithm = math.log(fraction)
    return fraction * (1.0 - logarithm), -logarithm


def mobilised(presliding: float, turned: float, travel: float) -> float:
    """Return the mobilised fraction ``q`` after a displacement (rad) from a reversal."""
    if travel == 0.0:
        return turned
    rise, _ = presliding_curve(abs(travel) / presliding)
    return turned + ((1.0 if travel > 0.0 else -1.0) - turned) * rise


def mobilised_torque(
    joint: ElastoPlasticParameters, way: float, turned: float, travel: float, period: float, speed: float
) -> tuple[float, float]:
    """Return the torque (N m) that ``f`` follows after a step and its slope by the speed, in the direction of motion.

    That is 1 or -1. The mobilised fraction at the last reversal is positive where it opposes the motion, the
    displacement since then before the step (rad) not negative; the speed is that after the step, rad/s, positive.
    """
    rise, bend = presliding_curve((travel + period * speed) / joint.presliding)
    fraction = turned + (1.0 - turned) * rise
    curve = joint.friction if way * fraction > 0.0 else joint.backward  # of the direction that is opposed
    level, product = yield_torque(curve, speed)
    viscous = joint.friction.viscous if way > 0.0 else joint.backward.viscous
    fraction_slope = (1.0 - turned) * bend * period / joint.presliding
    return fraction * level + viscous * speed, fraction_slope * level + fraction * product / speed + viscous


def elasto_plastic_speed(
    joint: ElastoPlasticParameters,
    way: float,
    turned: float,
    travel: float,
    period: float,
    kappa: float,
    free: float,
    pull: float,
) -> float:
    """Solve ``x + kappa torque(x) = free`` for the speed ``x > 0`` after a step.

    ``pull > 0`` is ``free`` less ``kappa`` times the torque before the step. The left side rises at least half as fast
    as ``x`` (``check_elasto_plastic_period`` sees to it): the root is in ``[0, 2 pull]``.
    """
    low, high = 0.0, 2.0 * pull
    speed = pull
    for _ in range(MAXIMUM_ITERATIONS):
        torque, slope = mobilised_torque(joint, way, turned, travel, period, speed)
        residual = speed + kappa * torque - free
        low, high, speed, found = next_speed(low, high, speed, residual, 1.0 + kappa * slope)
        if found:
            break
    return speed


def step_elasto_plastic(
    joint: ElastoPlasticParameters, state: ElastoPlasticState, torque: float, period: float
) -> ElastoPlasticState:
    """Advance an elasto-plastic joint by a solver period (s) under constant torque (N m)."""
    divisor = joint.friction_lag + period
    kappa = period * period / (joint.inertia * divisor)
    carried = joint.friction_lag * state.friction_torque / divisor
    free = state.velocity + period / joint.inertia * (torque - joint.offset - carried)
    fraction = mobilised(joint.presliding, state.turned, state.travel)
    held = fraction * (joint.friction if fraction > 0.0 else joint.backward).stiction
    pull = free - kappa * held
    if abs(pull) * period < UNDERFLOW * joint.presliding:
        return ElastoPlasticState(0.0, carried + period * held / divisor, state.position, state.turned, state.travel)
    way = 1.0 if pull > 0.0 else -1.0
    turned, travel = state.turned, state.travel
    if way * travel < 0.0:
        turned, travel = fraction, 0.0
    speed = way * pull
    if speed < math.inf:
        speed = elasto_plastic_speed(joint, way, way * turned, way * travel, period, kappa, way * free, speed)
    mobilised_now, _ = mobilised_torque(joint, way, way * turned, way * travel, period, speed)
    return ElastoPlasticState(
        way * speed,
        carried + period * way * mobilised_now / divisor,
        state.position + period * way * speed,
        turned,
        way * min(way * travel + period * speed, joint.presliding),
    )


def initial_elasto_plastic(joint: ElastoPlasticParameters, velocity: float) -> ElastoPlasticState:
    """Return the state of a joint that has moved at a velocity (rad/s) for long; its position is zero."""
    way = 0.0 if velocity == 0.0 else math.copysign(1.0, velocity)
    friction = friction_at(joint.friction, joint.backward, velocity)
    return ElastoPlasticState(velocity, friction, 0.0, way, way * joint.presliding)


class ElastoPlasticJoint(FrictionFields):
    """Parameters of a simulated rigid joint with two-state elasto-plastic friction, checked.

    Further fields are those of :class:`FrictionFields`; ``stribeck_shape`` is at least one.
    """

    kind: Literal["elasto_plastic"] = "elasto_plastic"  # kind of joint
    presliding: Positive  # displacement after a reversal until the joint slides, rad, positive
    friction_lag: NonNegative = 0.0  # friction lag ``tau``, s, zero or more

    def check_kind(self) -> None:
        """Refuse a curve that falls infinitely steeply at rest."""
        check_gentle_at_rest(self)

    @property
    def parameters(self) -> ElastoPlasticParameters:
        """The parameters as the step takes them."""
        return ElastoPlasticParameters(
            self.inertia, self.friction, self.friction_backward, self.offset, self.friction_lag, self.presliding
        )


def check_elasto_plastic_period(joint: ElastoPlasticParameters, period: float) -> None:
    """Refuse a solver period for which the implicit step could have more than one solution.

    As of the rigid joint, ``kappa max(-g') < 1`` with ``kappa = h^2/(J (tau + h))``; half of that is allowed, so that
    the root can be bracketed.
    """
    falls = (steepest_fall(curve._replace(viscous=0.0)) for curve in (joint.friction, joint.backward))
    longest = longest_with_lag(longest_gentle_period(joint.inertia, falls), joint.friction_lag)
    refuse_period(period, longest, FALLING)


register(
    ElastoPlasticParameters,
    ElastoPlasticState,
    step_elasto_plastic,
    initial_elasto_plastic,
    check_elasto_plastic_period,
    changed_joint,
)
