"""Sliding gate: which samples may be learnt from.

The friction map holds while the joint slides. Around zero velocity the joint may stick, where friction is whatever the
torque is, and an equation taken there is false; a filter remembers it for a few of its time constants. So the gate
closes at low speed and opens a hold time after.
"""


def sliding_time(
    elapsed: float, velocity: float, reference: float, valid: bool, slowest: float, duration: float
) -> float:
    """Return for how long the joint has been sliding, s.

    Parameters
    ----------
    elapsed : float
        For how long it had been at the last sample, s.
    velocity : float
        Measured velocity, rad/s.
    reference : float
        Reference velocity, rad/s; a joint that moves against its reference does not count as sliding.
    valid : bool
        Whether the measurement is one.
    slowest : float
        Speed below which the joint may stick, rad/s.
    duration : float
        Time since the last sample, s.
    """
    if valid and abs(velocity) >= slowest and velocity * reference > 0.0:
        return elapsed + duration
    return 0.0
