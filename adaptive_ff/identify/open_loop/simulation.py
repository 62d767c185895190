"""A log simulated in open loop: the motion that a model makes of the recorded torque alone.

The model is ``J a + F(w) + g(q) = u``: Coulomb friction, viscous friction that may differ by direction, and a force
that is linear in the position between equidistant knots (a single one is an offset), which holds gravity, an offset and
friction that depends on the position as far as it does not change its sign with the direction. The friction may be
multiplied by the controller's map over position (:mod:`adaptive_ff.adaptive.learning.friction_map`). Time steps are
those of :mod:`plant.step`, so the model comes exactly to rest.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.adaptive.learning.friction_map import NO_MAP, MapParameters, limited_factor, map_value
from adaptive_ff.logs.derivatives import Array
from controllers import compiled
from plant.friction import Stribeck
from plant.step import JointParameters, JointState, scaled_joint, step_joint

SOME_VELOCITY = 1.0
"""Stribeck velocity of a curve without stiction, where it has no effect."""

FIRST = ("inertia", "coulomb", "viscous", "viscous_asymmetry")
"""Parameters before the force at the knots."""


class Record(NamedTuple):
    """A log as it is simulated.

    Attributes
    ----------
    position, velocity, torque : ndarray, shape (n,)
        Position (rad), velocity from which a simulation may start (rad/s), torque (N m).
    period : float
        Sample time, s.
    """

    position: Array
    velocity: Array
    torque: Array
    period: float


def _follow(
    joint: JointParameters,
    low: float,
    width: float,
    force: Array,
    variation: MapParameters,
    coefficients: Array,
    record: Record,
    starts: Array,
    length: int,
    out: Array,
) -> None:
    """Simulate from each start, and write position minus measured position into the rows of ``out``."""
    last = force.size - 1
    for row in range(starts.size):
        start = int(starts[row])
        state = JointState(record.velocity[start], 0.0, record.position[start])
        out[row, 0] = 0.0
        for k in range(1, length):
            place = 0.0 if last == 0 else min(max((state.position - low) / width, 0.0), float(last))
            knot = min(int(place), max(last - 1, 0))
            share = place - knot
            against = force[knot] if last == 0 else (1.0 - share) * force[knot] + share * force[knot + 1]
            torque = 0.5 * (record.torque[start + k - 1] + record.torque[start + k]) - against
            now = joint
            if coefficients.size > 0:
                now = scaled_joint(joint, limited_factor(1.0, map_value(variation, coefficients, state.position, 0.0)))
            state = step_joint(now, state, torque, record.period)
            out[row, k] = state.position - record.position[start + k]


follow = compiled(_follow)


class OpenLoopModel(NamedTuple):
    """A joint for an open-loop simulation.

    Attributes
    ----------
    inertia, coulomb, viscous, viscous_asymmetry : float
        kg m^2, N m, N m s/rad, N m s/rad.
    low, high : float
        Positions of the first and the last knot, rad.
    force : ndarray, shape (knots,)
        Force at the knots, N m.
    variation : MapParameters
        How friction may vary with position.
    coefficients : ndarray, shape (n,)
        Of this map; friction does not vary where there are none.
    """

    inertia: float
    coulomb: float
    viscous: float
    viscous_asymmetry: float
    low: float
    high: float
    force: Array
    variation: MapParameters = NO_MAP
    coefficients: Array = np.empty(0)

    def to_dict(self) -> dict[str, Any]:
        """Return plain values; the keys of the map are those of a scenario's ``[adaptation]``."""
        plain = {name: getattr(self, name) for name in (*FIRST, "low", "high")}
        learnt: dict[str, Any] | None = None
        if self.coefficients.size:
            hats, lowest = self.variation.hats, self.variation.lowest
            learnt = {
                "position_periods": (2.0 * math.pi / self.variation.waves).tolist(),
                "position_hats": hats,
                "position_range": [lowest, lowest + (hats - 1) * self.variation.spacing] if hats else None,
                "coefficients": self.coefficients.tolist(),
            }
        return {**plain, "force": self.force.tolist(), "friction_map": learnt}

    def errors(self, record: Record, starts: NDArray[np.int64], length: int) -> Array:
        """Return simulated minus measured position, shape (starts, length), from each start for so many samples."""
        curves = [
            Stribeck(self.coulomb, self.coulomb, self.viscous + side * self.viscous_asymmetry, SOME_VELOCITY, 1.0)
            for side in (1.0, -1.0)
        ]
        joint = JointParameters(self.inertia, curves[0], curves[1], 0.0, 0.0)
        out = np.empty((starts.size, length))
        width = (self.high - self.low) / max(1, self.force.size - 1)
        series = np.ascontiguousarray(self.force), self.variation, np.ascontiguousarray(self.coefficients)
        follow(joint, self.low, width, *series, record, starts.astype(float), length, out)
        return out
