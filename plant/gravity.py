"""The torque of a weight that hangs on a rotary joint, ``amplitude sin(q + phase)``, against the motor's.

It acts over a solver step as it is at the position before the step: of first order in the period, like the steps
themselves. Of an elastic joint it acts at the motor, as the offset does.
"""

import math
from typing import NamedTuple


class Gravity(NamedTuple):
    """The torque of a weight."""

    amplitude: float  # largest torque, N m; zero without a weight
    phase: float  # angle from the hanging weight to the position zero, rad


def gravity_torque(gravity: Gravity, position: float) -> float:
    """Return the torque (N m) against the motor's at a position (rad)."""
    return gravity.amplitude * math.sin(position + gravity.phase)
