"""One implicit time step of a joint with generalised Maxwell-slip friction: four elements that stick, then slip.

V. Lampaert, F. Al-Bender, J. Swevers, "A generalized Maxwell-slip friction model appropriate for control purposes"
(2003); used for identification by D. Rizos, S. Fassois (2009):

    J dw/dt = u - f - offset,    f = F1 + F2 + F3 + F4 + sigma w
    dFi/dt = ki w                               while element i sticks, until |Fi| = ai g(w)
    dFi/dt = sgn(w) C (ai - |Fi|/g(w))          while it slips, until w changes its sign

``g(w) = Fc + (Fs - Fc) exp(-|w/Vs|^delta)`` is the paper's (3) without its viscous part, of the direction of ``w``; the
shares ``ai`` sum to one. With ``C`` infinite a slipping element has ``ai g(w)`` at once. While ``g`` is constant that
is the Maxwell-slip model proper (stop operators side by side): rate-independent, with the Masing rule for every branch
after a reversal and a memory of all reversals that no later branch has passed.

Chosen where the source says nothing: a slipping element whose torque is below ``ai g(w)`` follows no faster than its
spring would; what an element holds beyond ``ai Fs``, as when friction drops, is released.

Discretised by the implicit Euler method, of first order in the period. All elements are non-decreasing functions of the
speed after the step but for the fall of ``g``; one scalar equation in that speed remains.
"""

import math
from typing import NamedTuple

from numba.extending import register_jitable

from plant.change import JointChange, changed_friction, scaled_friction
from plant.friction import Stribeck, yield_torque
from plant.sliding import MAXIMUM_ITERATIONS, next_speed
from plant.step import friction_at

ELEMENTS = 4
"""Number of elements."""

Four = tuple[float, float, float, float]


class MaxwellParameters(NamedTuple):
    """What the step needs to know of a joint with Maxwell-slip friction.

    Attributes
    ----------
    inertia : float
        Inertia ``J``, kg m^2.
    friction, backward : Stribeck
        Static friction map of forward and of backward motion.
    offset : float
        Constant torque against the motor's, N m, of either sign.
    shares : tuple of float
        Share ``ai`` of each element in the friction; their sum is one.
    stiffnesses : tuple of float
        Stiffness ``ki`` of each element, N m/rad.
    relaxation : float
        ``1/C``, s/(N m); zero where a slipping element follows at once.
    """

    inertia: float
    friction: Stribeck
    backward: Stribeck
    offset: float
    shares: Four
    stiffnesses: Four
    relaxation: float


class MaxwellState(NamedTuple):
    """State of a joint with Maxwell-slip friction.

    Attributes
    ----------
    velocity : float
        Velocity ``w``, rad/s.
    friction_torque : float
        Friction torque ``f``, N m, without the offset.
    position : float
        Position, rad.
    load_1, load_2, load_3, load_4 : float
        Torque ``Fi`` of each element, N m.
    slip_1, slip_2, slip_3, slip_4 : float
        Direction in which each element slips, 1 or -1; zero where it sticks.
    """

    velocity: float
    friction_torque: float
    position: float
    load_1: float
    load_2: float
    load_3: float
    load_4: float
    slip_1: float
    slip_2: float
    slip_3: float
    slip_4: float


class Element(NamedTuple):
    """One element before a step, seen in the direction of motion.

    Attributes
    ----------
    share : float
        Share ``ai``.
    spring : float
        ``h ki``, N m s/rad.
    delay : float
        ``1/(h C)``, 1/(N m).
    load : float
        Torque, N m, positive where it opposes the motion.
    slips : bool
        Whether it slips in the direction of motion already.
    """

    share: float
    spring: float
    delay: float
    load: float
    slips: bool


@register_jitable
def slipping_torque(element: Element, level: float, level_slope: float) -> tuple[float, float]:
    """Return the torque of an element that slips after a step and its slope, for ``g`` (N m) and its slope by speed."""
    if not element.slips:
        return element.share * level, element.share * level_slope
    divisor = element.delay * level + 1.0
    torque = level * (element.delay * element.load + element.share) / divisor
    return torque, torque / (level * divisor) * level_slope


@register_jitable
def element_torque(element: Element, speed: float, level: float, level_slope: float) -> tuple[float, float, bool]:
    """Return the torque of an element after a step (N m), its slope by the speed, and whether it slips then."""
    sticking = element.load + element.spring * speed
    slipping, slope = slipping_torque(element, level, level_slope)
    if sticking <= slipping:
        return sticking, element.spring, element.slips
    return slipping, slope, True


@register_jitable
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


@register_jitable
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


@register_jitable
def held_load(joint: MaxwellParameters, share: float, load: float) -> float:
    """Return what an element can hold of a torque (N m)."""
    return min(max(load, -share * joint.backward.stiction), share * joint.friction.stiction)


@register_jitable
def step_maxwell(joint: MaxwellParameters, state: MaxwellState, torque: float, period: float) -> MaxwellState:
    """Advance a joint with Maxwell-slip friction by one solver period under constant torque.

    Parameters
    ----------
    joint : MaxwellParameters
        The joint.
    state : MaxwellState
        State at the start of the step.
    torque : float
        Torque ``u``, N m, constant over the step.
    period : float
        Solver period ``h``, s.

    Returns
    -------
    MaxwellState
        State at the end of the step.
    """
    load_1 = held_load(joint, joint.shares[0], state.load_1)
    load_2 = held_load(joint, joint.shares[1], state.load_2)
    load_3 = held_load(joint, joint.shares[2], state.load_3)
    load_4 = held_load(joint, joint.shares[3], state.load_4)
    held = load_1 + load_2 + load_3 + load_4
    mobility = period / joint.inertia
    pull = state.velocity + mobility * (torque - joint.offset - held)
    if pull == 0.0:
        return MaxwellState(
            velocity=0.0,
            friction_torque=held,
            position=state.position,
            load_1=load_1,
            load_2=load_2,
            load_3=load_3,
            load_4=load_4,
            slip_1=state.slip_1,
            slip_2=state.slip_2,
            slip_3=state.slip_3,
            slip_4=state.slip_4,
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
    level, rise = yield_torque(curve, speed)
    after_1, _, slips_1 = element_torque(elements[0], speed, level, rise / speed)
    after_2, _, slips_2 = element_torque(elements[1], speed, level, rise / speed)
    after_3, _, slips_3 = element_torque(elements[2], speed, level, rise / speed)
    after_4, _, slips_4 = element_torque(elements[3], speed, level, rise / speed)
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


@register_jitable
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


@register_jitable
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
    first, second, third, fourth = (share * (friction_torque - viscous) for share in joint.shares)
    return MaxwellState(
        velocity=velocity,
        friction_torque=friction_torque,
        position=0.0,
        load_1=first,
        load_2=second,
        load_3=third,
        load_4=fourth,
        slip_1=slip,
        slip_2=slip,
        slip_3=slip,
        slip_4=slip,
    )
