"""Torque that the drive did not give: rivals that learn from their feedback torque do not learn from it."""

from numba.extending import register_jitable

from controllers import PIParameters, PIState, asked_torque

REFUSED_SHARE = 0.05
"""Torque that the drive did not give beyond which nothing is learnt, as a share of the unit of torque."""


@register_jitable
def was_refused(block: PIParameters, state: PIState, realised: float, scale: float) -> bool:
    """Return whether the realised torque (N m) missed the one that was asked for; ``scale`` is the unit, N m."""
    return abs(realised - asked_torque(block, state)) > REFUSED_SHARE * scale
