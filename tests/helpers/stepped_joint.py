"""Joints: drawn at random, stepped by their kernel alone, and solved between events, without a time step."""

import math

import numpy as np
from hypothesis import strategies as st
from pydantic import ValidationError
from scipy.integrate import solve_ivp

from controllers import compiled, dispatched
from plant import STEP_JOINT, Joint

FRICTION = {"coulomb": 60.0, "stiction": 90.0, "viscous": 80.0, "stribeck_velocity": 0.05}
"""The joint that all tests of steps share, beside its inertia of 20 kg m^2."""

VELOCITY = st.just(0.0) | st.floats(-2.0, 2.0)
TORQUE = st.floats(-300.0, 300.0)


def leaves(value):
    """All numbers and arrays of nested tuples, in order, as arrays."""
    if isinstance(value, tuple):
        return [leaf for item in value for leaf in leaves(item)]
    return [np.asarray(value)]


@st.composite
def friction_fields(draw, least=0.0, shapes=(1.0, 1.5, 2.0)):
    """Fields that every kind of joint has; ``least`` is the smallest Coulomb friction."""
    coulomb, backward = draw(st.floats(least, 100.0)), draw(st.none() | st.floats(least, 100.0))
    return {
        "inertia": draw(st.floats(0.5, 100.0)),
        "coulomb": coulomb,
        "coulomb_backward": backward,
        "stiction": max(coulomb, backward or 0.0) + draw(st.just(0.0) | st.floats(0.0, 100.0)),
        "viscous": draw(st.floats(0.0, 100.0)),
        "stribeck_velocity": draw(st.floats(0.01, 0.5)),
        "stribeck_shape": draw(st.sampled_from(shapes)),
        "offset": draw(st.just(0.0) | st.floats(-50.0, 50.0)),
    }


def accepted(model, fields, period=1e-3):
    """A joint of some fields, with a solver period short enough for it."""
    while True:
        try:
            return model(**fields, solver_period=period)
        except ValidationError:
            period *= 0.5


def mirrored(step, joint, state, torque, period):
    """The state after a step of the joint seen from the other side, as seen from this one: the step is odd."""
    turned = joint._replace(friction=joint.backward, backward=joint.friction, offset=-joint.offset)
    after = step(turned, type(state)(*(-value for value in state)), -torque, period)
    return tuple(-value for value in after)


step_joint = dispatched(STEP_JOINT)
"""One solver period of any joint, compiled or not."""


def follow(joint, state, torques, period, motion):
    """Write the state after each step into a row of its own; row 0 is the start."""
    motion[0] = state
    for k in range(torques.size):
        state = step_joint(joint, state, torques[k], period)
        motion[k + 1] = state


FOLLOW = compiled(follow)


def turn(joint, state, torque, period, steps):
    """State of a joint after some steps with one torque."""
    for _ in range(steps):
        state = step_joint(joint, state, torque, period)
    return state


TURN = compiled(turn)


class CompiledJoint(Joint):
    """A joint in one's own loop whose steps are compiled: the same bits in less time; gravity is left out."""

    def step(self, torque, duration):
        steps, period = round(duration / self.model.solver_period), self.model.solver_period
        if steps == 1:  # a call costs more than a step
            return super().step(torque, duration)
        self.state = TURN(self._parameters, self.state, float(torque), period, steps)
        return self.state.velocity


def run(joint, state, torques, period, way=FOLLOW):
    """State of a joint after each step with torques; row 0 is the start."""
    motion = np.empty((torques.size + 1, len(state)))
    way(joint, state, np.ascontiguousarray(torques, dtype=float), period, motion)
    return motion


def ends(joint, start, torque, duration, periods):
    """State at the end of a duration for each solver period, with a torque of the middles of the steps."""
    middles = [period * (np.arange(round(duration / period)) + 0.5) for period in periods]
    return np.array([run(joint, start, torque(at), h)[-1] for at, h in zip(middles, periods, strict=True)])


def along_paths(step, rest):
    """Return a function that finds friction along a path, of a joint which is too heavy to be moved by it."""

    def friction_along(joint, path, period=1e-3, state=rest):
        held, torques = joint._replace(inertia=1e18), []
        for here, there in zip(path[:-1].tolist(), path[1:].tolist(), strict=True):
            state = step(held, state._replace(velocity=(there - here) / period), 0.0, period)
            torques.append(state.friction_torque)
        return np.array(torques)

    return friction_along


SMALLEST_ARC = 1e-8
"""Bounces about rest that are slower than this (rad/s) are taken for rest."""


def motion(joint, torque, slope, duration, times, velocity=0.0, friction=0.0):
    """Velocity of a joint with lagged Stribeck friction at some times, from a velocity and a friction torque.

    It is solved between its events by Runge-Kutta. By default it begins at rest without friction torque.

    Parameters
    ----------
    joint : JointParameters
        A joint with the same friction in both directions, without offset.
    torque, slope : callable
        Smooth torque over time, and its derivative.
    duration : float
        End, s.
    times : ndarray
        Times, s, ascending, within the duration.
    """
    f, lag, inertia = joint.friction, joint.friction_lag, joint.inertia
    found = np.zeros_like(times)

    def static(speed):
        decay = math.exp(-((max(speed, 0.0) / f.stribeck_velocity) ** f.stribeck_shape))
        return f.coulomb + (f.stiction - f.coulomb) * decay + f.viscous * speed

    def needed(time):  # static friction that keeps the joint at rest, with the friction torque at its balance
        return torque(time) + lag * slope(time)

    def leaves(time, _):
        return abs(needed(time)) - f.stiction

    leaves.terminal, leaves.direction = True, 1.0
    time, at_rest = 0.0, velocity == 0.0
    while time < duration:
        if at_rest and abs(needed(time)) < f.stiction:
            wait = solve_ivp(lambda t, y: [0.0], (time, duration), [0.0], events=leaves, max_step=0.01)
            time, velocity, friction = wait.t[-1], 0.0, torque(wait.t[-1])
            if wait.status != 1:
                break
        drive = needed(time) if at_rest else torque(time) - friction
        direction = math.copysign(1.0, velocity if velocity != 0.0 else drive)

        def rates(t, y, direction=direction):
            friction = direction * static(direction * y[0])
            if lag == 0.0:
                return [(torque(t) - friction) / inertia, 0.0]
            return [(torque(t) - y[1]) / inertia, (friction - y[1]) / lag]

        def reversal(t, y, begin=time, direction=direction):
            return direction * y[0] if t > begin + 1e-12 else 1.0

        reversal.terminal, reversal.direction = True, -1.0
        tolerances = {"rtol": 1e-9, "atol": 1e-12, "max_step": 0.02}
        arc = solve_ivp(rates, (time, duration), [velocity, friction], events=reversal, dense_output=True, **tolerances)
        inside = (times >= time) & (times <= arc.t[-1])
        if np.any(inside):
            found[inside] = arc.sol(times[inside])[0]
        time, friction, velocity = arc.t[-1], arc.y[1, -1], 0.0
        small = np.max(np.abs(arc.y[0])) < SMALLEST_ARC
        at_rest = abs(needed(time)) < f.stiction and (small or lag == 0.0)
    return found
