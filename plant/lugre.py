"""One implicit time step of a joint with LuGre friction: bristles that bend before they slide.

C. Canudas de Wit, H. Olsson, K. J. Astrom, P. Lischinsky, "A New Model for Control of Systems with Friction" (1995):

    J dw/dt = u - f - offset
    dz/dt = w - sigma0 |w|/g(w) z
    f = sigma0 z + sigma1(w) dz/dt + sigma2 w

with the mean deflection ``z`` of the bristles. ``g(w) = Fc + (Fs - Fc) exp(-|w/Vs|^delta)`` is the paper's (3) without
its viscous part, of the direction of ``w``, as is ``sigma2``: at a constant velocity the joint settles on (3). A lag
follows from the bristles; there is no ``tau``.

With a constant ``sigma1`` the model gives energy at higher speeds. Chosen is H. Olsson's variant ("Control Systems with
Friction", 1996), ``sigma1(w) = sigma1 exp(-(w/Vs)^2)``: with ``V = sigma0 z^2/2`` stored in the bristles,
``f w - dV/dt`` is a quadratic form in ``sigma0 z`` and ``w`` that cannot be negative while ``sigma1(w) |w| <= 4 g(w)``.
The implicit step keeps that property, since it loses stored energy itself.

Both equations are discretised by the implicit Euler method, of first order in the period and stable for any stiffness.
With ``b = h sigma0``, ``y = sigma0 z``, and ``x = |w+|``, all signed towards ``w+``,

    dz/dt+ = x (g - y)/(g + b x),    y+ = (g y + b x g)/(g + b x),

so ``y+`` is a mean of ``y`` and ``g`` and never leaves ``[-Fs, Fs]``; one scalar equation in ``x`` remains.

What the model is known for and what stays in it: a torque that vibrates below breakaway lets the joint creep, because
bristles slide a little at any velocity (P. Dupont, V. Hayward, B. Armstrong, F. Altpeter, "Single State Elastoplastic
Friction Models", 2002).
"""

import math
from typing import Literal, NamedTuple

import numpy as np

from plant.fields import NonNegative, Positive
from plant.friction import JointChange, Stribeck, changed_friction, scaled_friction, yield_torque
from plant.joint import LARGEST_FALL, FrictionFields, check_coulomb, refuse_period
from plant.registry import register
from plant.sliding import MAXIMUM_ITERATIONS, next_speed
from plant.step import friction_at


class LuGreParameters(NamedTuple):
    """What the step needs to know of a LuGre joint."""

    inertia: float  # inertia ``J``, kg m^2
    friction: Stribeck  # static friction map of forward and of backward motion
    backward: Stribeck
    offset: float  # constant torque against the motor's, N m, of either sign
    stiffness: float  # stiffness ``sigma0`` of the bristles, N m/rad
    damping: float  # damping ``sigma1`` of the bristles at rest, N m s/rad


class LuGreState(NamedTuple):
    """State of a LuGre joint."""

    velocity: float  # velocity ``w``, rad/s
    friction_torque: float  # friction torque ``f``, N m, without the offset
    position: float  # position, rad
    deflection: float  # deflection ``z`` of the bristles, rad


def bristle_torque(
    curve: Stribeck, bending: float, slip: float, damping: float, speed: float
) -> tuple[float, float, float]:
    """Return ``(b + sigma1(x)) dz/dt`` in N m, its slope by the speed in N m s/rad, and ``dz/dt`` in rad/s.

    That is what the bristles add to the friction torque over a step. The curve is of the direction of motion,
    ``bending`` the torque ``y = sigma0 z`` before the step (N m, positive where it opposes the motion), ``slip`` is
    ``b = h sigma0``, ``damping`` ``sigma1`` (N m s/rad), and ``speed`` ``x >= 0`` after the step (rad/s).
    """
    level, rise = yield_torque(curve, speed)  # g and x dg/dx
    divisor = level + slip * speed
    rate = speed * (level - bending) / divisor
    rate_slope = (level * (level - bending) + rise * (slip * speed + bending)) / (divisor * divisor)
    ratio = speed / curve.stribeck_velocity
    damping_now = damping * math.exp(-ratio * ratio)
    weight = slip + damping_now
    damping_part = 2.0 * ratio * damping_now * rate / curve.stribeck_velocity
    return weight * rate, weight * rate_slope - damping_part, rate


def bristle_speed(
    curve: Stribeck, bending: float, slip: float, damping: float, mobility: float, pull: float, guess: float
) -> float:
    """Solve ``x + mobility (torque(x) + sigma2 x) = pull`` for the speed ``x > 0`` after a step.

    ``mobility`` is ``h/J``; ``pull > 0`` the speed that the joint would have if its bristles pulled as before, rad/s.
    The left side rises at least half as fast as ``x`` (``check_lugre_period`` sees to it): the root is in
    ``[0, 2 pull]``.
    """
    low, high = 0.0, 2.0 * pull
    speed = min(guess, high)
    for _ in range(MAXIMUM_ITERATIONS):
        torque, torque_slope, _ = bristle_torque(curve, bending, slip, damping, speed)
        residual = speed + mobility * (torque + curve.viscous * speed) - pull
        slope = 1.0 + mobility * (torque_slope + curve.viscous)
        low, high, speed, found = next_speed(low, high, speed, residual, slope)
        if found:
            break
    return speed


def step_lugre(joint: LuGreParameters, state: LuGreState, torque: float, period: float) -> LuGreState:
    """Advance a LuGre joint by a solver period (s) under constant torque (N m)."""
    mobility, slip = period / joint.inertia, period * joint.stiffness
    bending = joint.stiffness * state.deflection
    pull = state.velocity + mobility * (torque - joint.offset - bending)
    if pull == 0.0:
        return LuGreState(0.0, bending, state.position, state.deflection)
    forward = pull > 0.0
    curve = joint.friction if forward else joint.backward
    direction = 1.0 if forward else -1.0
    guess = max(direction * state.velocity, 0.0)
    towards = direction * bending
    speed = bristle_speed(curve, towards, slip, joint.damping, mobility, direction * pull, guess)
    bristles, _, rate = bristle_torque(curve, towards, slip, joint.damping, speed)
    friction_torque = bending + direction * (bristles + curve.viscous * speed)
    velocity = direction * speed
    deflection = state.deflection + direction * period * rate
    return LuGreState(velocity, friction_torque, state.position + period * velocity, deflection)


def scaled_lugre(joint: LuGreParameters, factor: float) -> LuGreParameters:
    """Return the joint with the friction of both directions times a dimensionless factor; the offset stays.

    Stiffness and damping of the bristles scale along, as with the load on a contact: in any motion the friction torque
    is then the factor times what it was, and the deflection the same.
    """
    scaled = scaled_friction(joint, factor)
    return scaled._replace(stiffness=joint.stiffness * factor, damping=joint.damping * factor)


def changed_lugre(joint: LuGreParameters, change: JointChange) -> LuGreParameters:
    """Return the joint with a change of its parameters; its bristles scale with the dry friction, and have no lag."""
    changed = changed_friction(joint, change)
    return changed._replace(
        inertia=joint.inertia * change.inertia,
        stiffness=joint.stiffness * change.dry,
        damping=joint.damping * change.dry,
    )


def initial_lugre(joint: LuGreParameters, velocity: float) -> LuGreState:
    """Return the state of a joint that has moved at a velocity (rad/s) for long; its position is zero."""
    friction_torque = friction_at(joint.friction, joint.backward, velocity)
    viscous = (joint.friction if velocity > 0.0 else joint.backward).viscous * velocity
    return LuGreState(velocity, friction_torque, 0.0, (friction_torque - viscous) / joint.stiffness)


MOST_PASSIVE = 4.0 * math.sqrt(2.0 * math.e)
"""Largest ``sigma1 Vs/Fc``: ``sigma1(w) |w| <= 4 g(w)`` at every speed, since ``x exp(-x^2) <= 1/sqrt(2 e)``."""


POWERS = np.geomspace(1e-5, 50.0, 70).tolist()
"""Grid of ``|w/Vs|^delta``."""

RATIOS = np.geomspace(1e-4, 1e4, 80).tolist()
"""Grid of ratios of a speed to a scale of speed."""


class LuGreJoint(FrictionFields):
    """Parameters of a simulated rigid joint with LuGre friction, checked.

    Further fields are those of :class:`FrictionFields`; ``coulomb`` of either direction is positive.
    """

    kind: Literal["lugre"] = "lugre"  # kind of joint
    # stiffness ``sigma0`` of the bristles, N m/rad, positive. The joint breaks away after some ``stiction/stiffness``
    # of displacement
    stiffness: Positive
    # damping ``sigma1`` of the bristles at rest, N m s/rad, zero or more; it fades with speed as ``exp(-(w/Vs)^2)``. By
    # default the bristles are critically damped, ``sigma1 + sigma2 = 2 sqrt(sigma0 J)``, as far as is allowed
    damping: NonNegative | None = None

    def check_kind(self) -> None:
        """Refuse curves that bristles cannot carry, and damping that could give energy."""
        check_coulomb(self)
        if self.damping is not None and self.damping > self._most_damping:
            raise ValueError(
                f"damping = {self.damping:g} N m s/rad is not allowed: it must be at most {self._most_damping:.6g} "
                "N m s/rad (9.33 coulomb/stribeck_velocity), or friction could give energy"
            )

    @property
    def _most_damping(self) -> float:
        return MOST_PASSIVE * min(self.coulomb, self.friction_backward.coulomb) / self.stribeck_velocity

    @property
    def parameters(self) -> LuGreParameters:
        """The parameters as the step takes them."""
        damping = self.damping
        if damping is None:
            critical = 2.0 * math.sqrt(self.stiffness * self.inertia)
            damping = min(max(critical - min(self.viscous, self.friction_backward.viscous), 0.0), self._most_damping)
        return LuGreParameters(
            self.inertia, self.friction, self.friction_backward, self.offset, self.stiffness, damping
        )


def check_lugre_period(joint: LuGreParameters, period: float) -> None:
    """Refuse a solver period for which the implicit step could have more than one solution.

    The step's equation has one while friction falls by less than ``J/h`` with the new speed, see
    :func:`steepest_fall_in_a_step`. Half of that is allowed, so that the grid on which the fall is looked for does not
    matter and the root can be bracketed.
    """

    def is_unique(tried: float) -> bool:
        return steepest_fall_in_a_step(joint, tried) <= LARGEST_FALL * joint.inertia / tried

    if not is_unique(period):
        short, long = 0.0, period
        for _ in range(60):
            middle = 0.5 * (short + long)
            short, long = (middle, long) if is_unique(middle) else (short, middle)
        refuse_period(period, short, "its stiffness and damping could leave the implicit step more than one solution")


def steepest_fall_in_a_step(joint: LuGreParameters, period: float) -> float:
    """Return how steeply the friction torque after a step falls with the speed after it, N m s/rad, at worst.

    At a given speed the slope is linear in the bristles' torque before the step, so only the ends of its range, the
    stiction of either direction, need to be looked at. Each of the three factors that vary with speed has a grid of its
    own: the Stribeck curve, the bristles' slip over a step, and their damping.
    """
    slip, worst = period * joint.stiffness, 0.0
    for curve, other in ((joint.friction, joint.backward), (joint.backward, joint.friction)):
        speeds = (
            *(curve.stribeck_velocity * power ** (1.0 / curve.stribeck_shape) for power in POWERS),
            *(curve.coulomb / slip * ratio for ratio in RATIOS),
            *(curve.stribeck_velocity * ratio for ratio in RATIOS),
        )
        for bending in (curve.stiction, -other.stiction):
            slopes = (bristle_torque(curve, bending, slip, joint.damping, speed)[1] for speed in speeds)
            worst = max(worst, -curve.viscous - min(slopes))
    return worst


register(LuGreParameters, LuGreState, step_lugre, initial_lugre, check_lugre_period, changed_lugre, scaled_lugre)
