"""Information of a motion on a joint: the intervals that its parameters would have, up to a common factor.

The rows are those of the joint's equation while it slides, ``u = J w' + F(w) - tau dF/dw w'``, of a periodic motion
that is followed exactly. Each counts by how far its sample passes the gate that identification has: the joint must
have slid one way, faster than a fraction of the Stribeck velocity, for a while. Information of a reversal on the lag is
left out, as the gate leaves it out. Everything is smooth in the motion, so that a motion can be optimised.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.errors import InputError

Array = NDArray[np.float64]

NAMES = ("inertia", "coulomb", "stiction", "viscous", "friction_lag")
"""Parameters whose intervals are given."""

GATE_FRACTION = 0.4
"""Speed of the gate of the identification over the Stribeck velocity."""

GATE_WIDTH = 0.1
"""Width of its smooth edge, in Stribeck velocities."""

SIGN_FRACTION = 0.1
"""Speed over the Stribeck velocity at which a smooth sign turns."""

SMALLEST = 1e-12
"""Added to the scaled information, so that a parameter without information has a finite, huge interval."""


class AssumedJoint(NamedTuple):
    """What is assumed of a joint before it is identified; a motion is planned with it."""

    inertia: float  # inertia, kg m^2
    # Coulomb friction and stiction, N m
    coulomb: float
    stiction: float
    viscous: float  # viscous coefficient, N m s/rad
    stribeck_velocity: float  # stribeck velocity, rad/s
    hold: float  # for how long the joint must have slid before identification uses a sample, s
    stribeck_shape: float = 1.0  # exponent of the Stribeck curve


def information(joint: AssumedJoint, velocity: Array, step: float) -> Array:
    """Return the information matrices of periodic motions (rad/s), shape (m, n), on a grid of times with a step (s).

    Of shape (m, 5, 5), of the parameters ``NAMES``, each over a size of its own, for noise of unit density.
    """
    bend = joint.stribeck_velocity
    scaled, shape = np.abs(velocity) / bend, joint.stribeck_shape
    sign, falling = np.tanh(velocity / (SIGN_FRACTION * bend)), np.exp(-(scaled**shape))
    derive = 2j * np.pi * np.fft.rfftfreq(velocity.shape[-1], step)
    spectrum = np.fft.rfft(velocity, axis=-1)
    acceleration = np.fft.irfft(derive * spectrum, velocity.shape[-1], axis=-1)
    steepness = shape * np.maximum(scaled, SIGN_FRACTION) ** (shape - 1.0) / bend
    slope = joint.viscous - (joint.stiction - joint.coulomb) * steepness * falling
    unit = max(joint.stiction, joint.inertia * bend / joint.hold)
    rows = np.stack(
        [
            joint.inertia * acceleration,
            unit * sign * (1.0 - falling),
            unit * sign * falling,
            unit / bend * velocity,
            joint.hold * slope * acceleration,
        ],
        axis=-1,
    )
    weighted = rows * _passing(joint, velocity, step)[..., None]
    found: Array = np.swapaxes(weighted, -1, -2) @ rows * step
    return found


def interval_sizes(found: Array) -> Array:
    """Return the sizes of the intervals of the parameters, shape (m, 5), from information matrices, shape (m, 5, 5)."""
    trace = np.trace(found, axis1=-2, axis2=-1)[..., None, None]
    try:
        inverse = np.linalg.inv(found + SMALLEST * trace * np.eye(len(NAMES)))
    except np.linalg.LinAlgError as error:
        raise InputError(
            "the motion is too small to show anything of the joint; allow a larger position, velocity or acceleration"
        ) from error
    sizes: Array = np.sqrt(np.diagonal(inverse, axis1=-2, axis2=-1))
    return sizes


def _passing(joint: AssumedJoint, velocity: Array, step: float) -> Array:
    """Return by how much each sample passes the gate, from 0 to 1, shape (m, n)."""
    bend = joint.stribeck_velocity
    fast = 1.0 / (1.0 + np.exp(-(np.abs(velocity) / bend - GATE_FRACTION) / GATE_WIDTH))
    passing = fast
    longest = max(1, round(joint.hold / step))
    for back in sorted({max(1, longest // 3), max(1, 2 * longest // 3), longest}):
        before = np.roll(velocity, back, axis=-1)
        one_way = 0.5 + 0.5 * np.tanh(velocity * before / (0.5 * SIGN_FRACTION * bend**2))
        passing = passing * np.roll(fast, back, axis=-1) * one_way
    found: Array = passing
    return found
