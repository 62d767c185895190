"""Friction that jumps and lags, as a slow clock samples it.

Friction is regressed in a band, where its lag is a factor ``1/(1 + lag s)``. But its sign jumps between samples, and a
torque that is sampled without a filter of its own (as drives do it) has of each jump only what the samples show. With
the jump by ``d`` before a sample, sample time ``T`` and lag ``tau``, the samples behind it sum up to an area

    S(d) = T exp(-d/tau) / (1 - exp(-T/tau)) + d - T/2

where the samples of the static sign, then lagged in the band, have ``tau + d - T/2``, and the means of the static sign
around the samples ``tau``. Both are right on average over ``d``; the first is exact without lag, the second with a long
one. Regressed on each other over all ``d``, with ``x = T/tau``,

    lagged samples = lagged mean + w(x) (samples - mean),
    w(x) = 1 + 12/(1 - exp(-x)) ((1 - exp(-x) (1 + x))/x^2 - (1 - exp(-x))/(2 x))

which goes from one without lag to zero with a long one. Without it Coulomb friction of logs of 100 Hz is off by up to
3.6 % in simulations free of noise where friction saturates as well.
"""

import math

SMALL = 0.05
"""Ratio of sample time and lag below which the weight is given by its series, ``x^2/60``."""


def sampled_share(sample_time: float, lag: float) -> float:
    """Return which share of what samples of a jump have beyond its mean is left in the samples of its lagged friction.

    Parameters
    ----------
    sample_time : float
        Time between samples, s.
    lag : float
        Friction lag, s; a lead counts as one.
    """
    if lag == 0.0:
        return 1.0
    x = sample_time / abs(lag)
    if x < SMALL:
        return x**2 / 60.0
    rest = -math.expm1(-x)
    return 1.0 + 12.0 / rest * ((1.0 - math.exp(-x) * (1.0 + x)) / x**2 - rest / (2.0 * x))
