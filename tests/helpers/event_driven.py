"""The joint with lagged Stribeck friction between its events, by Runge-Kutta: a reference without a time step."""

import math

import numpy as np
from scipy.integrate import solve_ivp

SMALLEST_ARC = 1e-8
"""Bounces about rest that are slower than this (rad/s) are taken for rest."""


def motion(joint, torque, slope, duration, times, velocity=0.0, friction=0.0):
    """Velocity of a joint at some times, from a velocity and a friction torque; by default at rest without any.

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
