"""One implicit time step of a joint with generalised Maxwell-slip friction: four elements that stick, then slip.

V. Lampaert, F. Al-Bender, J. Swevers, "A generalized Maxwell-slip friction model appropriate for control purposes"
(2003); used for identification by D. Rizos, S. Fassois (2009):

    J dw/dt = u - f - offset,    f = F1 + F2 + F3 + F4 + sigma w
    dFi/dt = ki w                               while element i sticks, until |Fi| = ai g(w)
    dFi/dt = sgn(w) C (ai - |Fi|/g(w))          while it slips, until w changes its sign

``g(w) = Fc + (Fs - Fc) exp(-|w/Vs|^delta)`` is the paper's (3) without its viscous part, of the direction of ``w``; the
fractions ``ai`` sum to one. With ``C`` infinite a slipping element has ``ai g(w)`` at once. While ``g`` is constant
that is the Maxwell-slip model proper (stop operators side by side): rate-independent, with the Masing rule for every
branch after a reversal and a memory of all reversals that no later branch has passed.

Chosen where the source says nothing: a slipping element whose torque is below ``ai g(w)`` follows no faster than its
spring would; what an element holds beyond ``ai Fs``, as when friction drops, is released.

Discretised by the implicit Euler method, of first order in the period. All elements are non-decreasing functions of the
speed after the step but for the fall of ``g``; one scalar equation in that speed remains.
"""

import math
from collections.abc import Iterable
from itertools import pairwise
from typing import Annotated, Literal, NamedTuple

from pydantic import Field

from plant.fields import Positive
from plant.friction import JointChange, Stribeck, changed_friction, scaled_friction, steepest_fall, yield_torque
from plant.joint import (
    FALLING,
    FrictionFields,
    check_coulomb,
    check_gentle_at_rest,
    longest_gentle_period,
    refuse_period,
)
from plant.registry import register
from plant.sliding import MAXIMUM_ITERATIONS, next_speed
from plant.step import friction_at

ELEMENTS = 4
"""Number of elements."""

Four = tuple[float, float, float, float]


class MaxwellParameters(NamedTuple):
    """What the step needs to know of a joint with Maxwell-slip friction."""

    inertia: float  # inertia ``J``, kg m^2
    friction: Stribeck  # static friction map of forward and of backward motion
    backward: Stribeck
    offset: float  # constant torque against the motor's, N m, of either sign
    shares: Four  # fraction ``ai`` of the friction that each element carries; their sum is one
    stiffnesses: Four  # stiffness ``ki`` of each element, N m/rad
    relaxation: float  # ``1/C``, s/(N m); zero where a slipping element follows at once


class MaxwellState(NamedTuple):
    """State of a joint with Maxwell-slip friction."""

    velocity: float  # velocity ``w``, rad/s
    friction_torque: float  # friction torque ``f``, N m, without the offset
    position: float  # position, rad
    load_1: float  # torque ``Fi`` of each element, N m
    load_2: float
    load_3: float
    load_4: float
    slip_1: float  # direction in which each element slips, 1 or -1; zero where it sticks
    slip_2: float
    slip_3: float
    slip_4: float


class Element(NamedTuple):
    """One element before a step, in the direction of motion."""

    fraction: float  # fraction ``ai`` of the friction
    spring: float  # ``h ki``, N m s/rad
    delay: float  # ``1/(h C)``, 1/(N m)
    load: float  # torque, N m, positive where it opposes the motion
    slips: bool  # whether it slips in the direction of motion already


def slipping_torque(element: Element, level: float, level_slope: float) -> tuple[float, float]:
    """Return the torque of an element that slips after a step and its slope, for ``g`` (N m) and its slope by speed."""
    if not element.slips:
        return element.fraction * level, element.fraction * level_slope
    divisor = element.delay * level + 1.0
    torque = level * (element.delay * element.load + element.fraction) / divisor
    return torque, torque / (level * divisor) * level_slope


def element_torque(element: Element, speed: float, level: float, level_slope: float) -> tuple[float, float, bool]:
    """Return the torque of an element after a step (N m), its slope by the speed, and whether it slips then."""
    sticking = element.load + element.spring * speed
    slipping, slope = slipping_torque(element, level, level_slope)
    if sticking <= slipping:
        return sticking, element.spring, element.slips
    return slipping, slope, True


def added_torque(
    curve: Stribeck, elements: tuple[Element, Element, Element, Element], speed: float
) -> tuple[float, float]:
    """Return by how much friction grows over a step with a speed (rad/s) after it, N m, and the slope of that."""
    level, rise = yield_torque(curve, speed)
    level_slope = rise / speed
    torque, slope = curve.viscous * speed, curve.viscous
    for i in range(ELEMENTS):
        after, part, _ = element_torque(elements[i], speed, level, level_slope)
        torque += after - elements[i].load
        slope += part
    return torque, slope


def element_speed(
    curve: Stribeck, elements: tuple[Element, Element, Element, Element], mobility: float, pull: float, guess: float
) -> float:
    """Solve ``x + mobility added_torque(x) = pull`` for the speed ``x > 0`` after a step.

    ``mobility`` is ``h/J``; ``pull > 0`` the speed that the joint would have if its elements pulled as before, rad/s.
    The left side rises at least half as fast as ``x`` (``check_maxwell_period`` sees to it): the root is in
    ``[0, 2 pull]``.
    """
    low, high = 0.0, 2.0 * pull
    speed = guess if 0.0 < guess < high else pull
    for _ in range(MAXIMUM_ITERATIONS):
        torque, slope = added_torque(curve, elements, speed)
        residual = speed + mobility * torque - pull
        low, high, speed, found = next_speed(low, high, speed, residual, 1.0 + mobility * slope)
        if found:
            break
    return speed


def held_load(joint: MaxwellParameters, fraction: float, load: float) -> float:
    """Return what an element can hold of a torque (N m)."""
    return min(max(load, -fraction * joint.backward.stiction), fraction * joint.friction.stiction)


def step_maxwell(joint: MaxwellParameters, state: MaxwellState, torque: float, period: float) -> MaxwellState:
    """Advance a joint with Maxwell-slip friction by a solver period (s) under constant torque (N m)."""
    load_1 = held_load(joint, joint.shares[0], state.load_1)
    load_2 = held_load(joint, joint.shares[1], state.load_2)
    load_3 = held_load(joint, joint.shares[2], state.load_3)
    load_4 = held_load(joint, joint.shares[3], state.load_4)
    held = load_1 + load_2 + load_3 + load_4
    mobility = period / joint.inertia
    pull = state.velocity + mobility * (torque - joint.offset - held)
    if pull == 0.0:
        return state._replace(
            velocity=0.0, friction_torque=held, load_1=load_1, load_2=load_2, load_3=load_3, load_4=load_4
        )
    way = 1.0 if pull > 0.0 else -1.0
    curve = joint.friction if pull > 0.0 else joint.backward
    delay = joint.relaxation / period
    stiffness = joint.stiffnesses
    elements = (
        Element(joint.shares[0], period * stiffness[0], delay, way * load_1, state.slip_1 == way),
        Element(joint.shares[1], period * stiffness[1], delay, way * load_2, state.slip_2 == way),
        Element(joint.shares[2], period * stiffness[2], delay, way * load_3, state.slip_3 == way),
        Element(joint.shares[3], period * stiffness[3], delay, way * load_4, state.slip_4 == way),
    )
    speed = way * pull
    if speed < math.inf:  # not a number stays so
        speed = element_speed(curve, elements, mobility, speed, way * state.velocity)
    level, _ = yield_torque(curve, speed)
    after_1, _, slips_1 = element_torque(elements[0], speed, level, 0.0)
    after_2, _, slips_2 = element_torque(elements[1], speed, level, 0.0)
    after_3, _, slips_3 = element_torque(elements[2], speed, level, 0.0)
    after_4, _, slips_4 = element_torque(elements[3], speed, level, 0.0)
    friction_torque = way * (after_1 + after_2 + after_3 + after_4 + curve.viscous * speed)
    return MaxwellState(
        velocity=way * speed,
        friction_torque=friction_torque,
        position=state.position + period * way * speed,
        load_1=way * after_1,
        load_2=way * after_2,
        load_3=way * after_3,
        load_4=way * after_4,
        slip_1=way if slips_1 else 0.0,
        slip_2=way if slips_2 else 0.0,
        slip_3=way if slips_3 else 0.0,
        slip_4=way if slips_4 else 0.0,
    )


def scaled_maxwell(joint: MaxwellParameters, factor: float) -> MaxwellParameters:
    """Return the joint with the friction of both directions times a dimensionless factor; the offset stays.

    The elements' stiffness and ``C`` scale along, as with the load on a contact: in any motion the friction torque is
    then the factor times what it was.
    """
    stiffness = joint.stiffnesses
    scaled = scaled_friction(joint, factor)
    return scaled._replace(
        stiffnesses=(stiffness[0] * factor, stiffness[1] * factor, stiffness[2] * factor, stiffness[3] * factor),
        relaxation=joint.relaxation / factor,
    )


def changed_maxwell(joint: MaxwellParameters, change: JointChange) -> MaxwellParameters:
    """Return the joint with a change of its parameters; elements scale with the dry friction, ``1/C`` with the lag."""
    stiffness, dry = joint.stiffnesses, change.dry
    changed = changed_friction(joint, change)
    return changed._replace(
        inertia=joint.inertia * change.inertia,
        stiffnesses=(stiffness[0] * dry, stiffness[1] * dry, stiffness[2] * dry, stiffness[3] * dry),
        relaxation=joint.relaxation * change.lag / dry,
    )


def initial_maxwell(joint: MaxwellParameters, velocity: float) -> MaxwellState:
    """Return the state of a joint that has moved at a velocity (rad/s) for long; its position is zero."""
    friction_torque = friction_at(joint.friction, joint.backward, velocity)
    viscous = (joint.friction if velocity > 0.0 else joint.backward).viscous * velocity
    slip = 0.0 if velocity == 0.0 else (1.0 if velocity > 0.0 else -1.0)
    first, second, third, fourth = (fraction * (friction_torque - viscous) for fraction in joint.shares)
    return MaxwellState(velocity, friction_torque, 0.0, first, second, third, fourth, slip, slip, slip, slip)


FourValues = Annotated[list[Positive], Field(min_length=ELEMENTS, max_length=ELEMENTS)]

EVEN = [0.25, 0.25, 0.25, 0.25]

KNOTS = (1.0 / 16.0, 1.0 / 4.0, 9.0 / 16.0, 1.0)
"""Where on a rolling contact's curve the elements slip, as fractions of its range: closer where it bends more."""


class SlipFields(FrictionFields):
    """What both kinds of joints with Maxwell-slip friction have, beside the fields of every joint."""

    def check_kind(self) -> None:
        """Refuse curves that elements cannot carry."""
        check_coulomb(self)
        check_gentle_at_rest(self)

    def _elements(self, shares: Four, displacements: Four, relaxation: float) -> MaxwellParameters:
        torques = (fraction * self.stiction for fraction in shares)
        stiffnesses = tuple(torque / reach for torque, reach in zip(torques, displacements, strict=True))
        return MaxwellParameters(
            self.inertia, self.friction, self.friction_backward, self.offset, shares, _four(stiffnesses), relaxation
        )


class MaxwellJoint(SlipFields):
    """Parameters of a simulated rigid joint with generalised Maxwell-slip friction, checked.

    Further fields are those of :class:`SlipFields`; ``coulomb`` of either direction is positive, ``stribeck_shape`` at
    least one.
    """

    kind: Literal["maxwell"] = "maxwell"  # kind of joint
    # displacement from rest, rad, after which each of the four elements slips where the others carry what they can:
    # positive, ascending. Element i has the stiffness ``ai stiction/displacement``
    displacements: FourValues
    # fraction ``ai`` of the friction that each element carries, positive, of the sum one; equal by default
    shares: FourValues = EVEN
    # ``C``, N m/s, positive: how fast a slipping element follows the Stribeck curve. By default at once
    attraction: Positive | None = None

    def check_kind(self) -> None:
        """Refuse curves that elements cannot carry, and elements that are none."""
        super().check_kind()
        if any(later <= earlier for earlier, later in pairwise(self.displacements)):
            raise ValueError(f"displacements = {self.displacements} is not allowed: they must ascend strictly")
        if abs(sum(self.shares) - 1.0) > 1e-6:
            raise ValueError(f"shares = {self.shares} is not allowed: their sum is {sum(self.shares):g}, not one")

    @property
    def parameters(self) -> MaxwellParameters:
        """The parameters as the step takes them."""
        total = sum(self.shares)
        shares = _four([fraction / total for fraction in self.shares])
        relaxation = 0.0 if self.attraction is None else 1.0 / self.attraction
        return self._elements(shares, _four(self.displacements), relaxation)


class RollingJoint(SlipFields):
    """Parameters of a simulated rigid joint with rolling friction, checked.

    From rest, friction grows with the displacement ``x`` as ``Fs (1 - (1 - x/range)^exponent)`` and stays at ``Fs``
    beyond the range; after a reversal by the Masing rule, twice as high and twice as far. Four Maxwell elements have
    that curve exactly where they slip, and straight lines between. The curve stands for those of T. Takemura,
    H. Fujimoto (2011) and Y. Maeda, M. Iwasaki (2013), who describe a ball screw by a rolling force, a range and an
    exponent, too; their formulas could not be compared. Further fields are those of :class:`SlipFields`; ``coulomb``
    of either direction is positive, ``stribeck_shape`` at least one.
    """

    kind: Literal["rolling"] = "rolling"  # kind of joint
    rolling_range: Positive  # displacement from rest after which friction grows no more, rad, positive
    # exponent of the curve, more than one: the higher, the steeper at its begin
    exponent: Annotated[float, Field(gt=1.0, allow_inf_nan=False, strict=True)] = 2.0

    @property
    def parameters(self) -> MaxwellParameters:
        """The parameters as the step takes them."""
        heights = [1.0 - (1.0 - knot) ** self.exponent for knot in KNOTS]
        points = [(0.0, 0.0), *zip(KNOTS, heights, strict=True)]
        slopes = [(top - bottom) / (right - left) for (left, bottom), (right, top) in pairwise(points)] + [0.0]
        bends = [steep - flat for steep, flat in pairwise(slopes)]
        shares = _four([bend * knot for bend, knot in zip(bends, KNOTS, strict=True)])
        return self._elements(shares, _four([knot * self.rolling_range for knot in KNOTS]), 0.0)


def _four(values: Iterable[float]) -> Four:
    first, second, third, fourth = values
    return float(first), float(second), float(third), float(fourth)


def check_maxwell_period(joint: MaxwellParameters, period: float) -> None:
    """Refuse a solver period for which the implicit step could have more than one solution."""
    longest = longest_gentle_period(joint.inertia, (_steepest(joint.friction), _steepest(joint.backward)))
    refuse_period(period, longest, FALLING)


def _steepest(curve: Stribeck) -> float:
    """Return how steeply the elements' torque after a step can fall with the speed, N m s/rad.

    A slipping element that follows with ``C`` falls ``(Fs e + 1)/(Fc e + 1)^2`` times as steeply as its part of the
    curve, ``e = 1/(h C)``, at most; that is one for ``Fs <= 2 Fc``, and has its largest value over ``e`` beyond.
    """
    ratio = curve.stiction / curve.coulomb
    factor = 1.0 if ratio <= 2.0 else ratio * ratio / (4.0 * (ratio - 1.0))
    return factor * (steepest_fall(curve._replace(viscous=0.0)))


register(
    MaxwellParameters,
    MaxwellState,
    step_maxwell,
    initial_maxwell,
    check_maxwell_period,
    changed_maxwell,
    scaled_maxwell,
)
