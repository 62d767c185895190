"""A joint driven by a controller from one's own loop, with whatever a test puts on it."""

import math
from typing import NamedTuple

import numpy as np

from adaptive_ff import WITH_OFFSET, AdaptiveController
from adaptive_ff.simulation.metrics import rms as rms
from controllers import pi_gains
from plant import JointModel
from tests.helpers.stepped_joint import CompiledJoint

PERIOD, STEPS, NOISE = 0.01, 5, 0.002

FRICTION = {"coulomb": 60.0, "stiction": 90.0, "viscous": 80.0, "stribeck_velocity": 0.05, "friction_lag": 0.02}

GAINS = pi_gains(20.0, 10.0)


class Driven(NamedTuple):
    """Series at the samples: time, velocity error, position, torque."""

    time: np.ndarray
    error: np.ndarray
    position: np.ndarray
    torque: np.ndarray


def plan(time):
    """A velocity that turns the joint by some 0.5 rad to either side."""
    fade = min(time / 2.0, 1.0)
    return fade * (0.3 * math.sin(0.6 * time) + 0.15 * math.sin(2.3 * time + 0.4))


def slope(time):
    """Mean acceleration of the plan over the coming period."""
    return (plan(time + PERIOD) - plan(time)) / PERIOD


def noise_at(time):
    """Noise of the measured velocity at a time."""
    return float(NOISE * np.random.default_rng(101).standard_normal(round(time / PERIOD) + 1)[-1])


def drive(controller, joint, begin, end, *, load=None, limit=math.inf, clamped=False, seed=101, **given):
    """Move a joint along the plan from one time to another.

    ``load(time, position)`` is a torque against the motor's, ``clamped`` tells whether a brake holds the joint; what
    else is given are functions ``(time, position)`` for the arguments of a step. The measured velocity is noisy, the
    same noise at the same time for the same seed.
    """
    rows = []
    noise = NOISE * np.random.default_rng(seed).standard_normal(round(end / PERIOD))
    for k in range(round(begin / PERIOD), round(end / PERIOD)):
        time, state = k * PERIOD, joint.state
        arguments = {name: value(time, state.position) for name, value in given.items()}
        following = plan(time + PERIOD)
        torque = controller.step(plan(time), state.velocity + noise[k], next_reference=following, **arguments)
        rows.append((time, plan(time) - state.velocity, state.position, torque))
        acting = min(max(torque, -limit), limit)
        steps = 1 if load is None else STEPS  # a load goes with the position on the way
        for _ in range(0 if clamped else steps):
            joint.step(acting - (load(time, joint.state.position) if load else 0.0), PERIOD / steps)
        if clamped:
            joint.state = joint.state._replace(velocity=0.0, friction_torque=0.0)
    return Driven(*np.array(rows).T)


def reference_joint(**changes):
    """Return the joint of the package's scenario, with a coarse solver."""
    return CompiledJoint(JointModel(**{"inertia": 20.0, "solver_period": PERIOD / STEPS, **FRICTION, **changes}))


def make(parameters=WITH_OFFSET, **options):
    """Make an adaptive controller for it, whose drive gives all it is asked for."""
    known = {"inertia": 20.0, "stribeck_velocity": 0.05, "torque_limit": math.inf, "parameters": parameters}
    return AdaptiveController(*GAINS, PERIOD, **{**known, **options})


def known_position(time, position):
    """Position as an argument of a step."""
    return position
