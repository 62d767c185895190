"""Logs of a joint whose friction is held by bristles, along a motion that is prescribed and comes back every 10 s."""

import math

import numpy as np
from scipy.signal import lfilter

from adaptive_ff import Log

INERTIA, COULOMB, VISCOUS = 0.5, 5.0, 2.0
RATE = 1000.0


def bristles(velocity, travel):
    """Friction of bristles (LuGre) over Coulomb friction, bent over a travel ``s`` (rad): ``s dz/dt = w - |w| z``."""
    bent, made = 0.0, np.empty_like(velocity)
    for place, speed in enumerate(velocity.tolist()):
        side = math.copysign(1.0, speed)
        bent = side + (bent - side) * math.exp(-abs(speed) / RATE / travel)
        made[place] = bent
    return made


def lagged(friction, lag):
    """Friction that follows a static one with a lag (s)."""
    pole = math.exp(-1.0 / RATE / lag)
    return lfilter([1.0 - pole], [1.0, -pole], friction)


def bristle_log(seed, *, seconds=60, travel=2.5e-4, delay=0.0, noise=0.05, every=4, ripple=0.0, lag=None):
    """A joint of 0.5 kg m^2, 5 N m and 2 N m s/rad along three sines, whose torque acts a delay (s) after its stamp.

    With a lag (s) there are no bristles, and all friction lags.
    """
    random = np.random.default_rng(seed)
    rates, sizes = 2.0 * np.pi * np.array([0.2, 0.6, 1.5]), np.array([0.8, 0.4, 0.2])
    phases = random.uniform(0.0, 6.3, 3)
    time = np.arange(int(seconds * RATE)) / RATE
    angle = np.outer(time, rates) + phases
    position, velocity = np.sin(angle) @ sizes, np.cos(angle) @ (sizes * rates)
    if lag is None:
        friction = VISCOUS * velocity + COULOMB * bristles(velocity, travel)
    else:
        friction = lagged(VISCOUS * velocity + COULOMB * np.sign(velocity), lag)
    torque = -INERTIA * np.sin(angle) @ (sizes * rates**2) + friction
    torque += ripple * np.sin(2.0 * np.pi * position / 0.17)
    torque = np.interp(time + delay, time, torque) + noise * random.standard_normal(time.size)
    return Log("bristles", time[::every], torque[::every], position[::every])
