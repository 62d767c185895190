"""How long a controller goes on without a measurement.

On its feedforward, and on what its integral holds, a joint keeps near its plan for a while; the longer, the less can
be known of where it is. So the torque then fades to zero: what a brake or the operator does next is the machine's to
decide.
"""

BRIDGED = 2.0
"""Time for which a controller goes on without a measurement, s: on its feedforward and on what its integral holds."""

FADING = 1.0
"""Time in which the torque then fades to zero, s."""


def bridging_share(lost: float) -> float:
    """Return the share of the torque that is still given after a time (s) without a measurement."""
    return min(1.0, max(0.0, 1.0 - (lost - BRIDGED) / FADING))
