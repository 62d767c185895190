"""Friction that follows its static curve over a path, as bristles do that bend before they slide.

With the static friction ``F``, without its viscous part, and the path ``x``, on which the joint goes whichever way,

    s dy/dx = F - y

so that at a reversal friction does not jump but rises, over a path of ``s``, however long that takes. It is Dahl's
friction (P. Dahl, "A solid friction model", 1968) with a stiffness of ``F/s``. For a given ``s`` the equation is
linear: each column of friction that jumps can follow by itself. Bristles have one stiffness at all speeds (LuGre), so
where they hold more at low speed they bend over more of a path, ``s (1 + r exp(-|w|/Vs))`` with ``r = (Fs - Fc)/Fc``.
Without that, a joint with a stiction of 1.5 times its Coulomb friction leaves 6.4 instead of 0.1 % of its friction.

Bristles are damped while they bend, by a torque that goes with ``dy/dt``. A torque that acts a little later than its
stamp says has the same in it, and so have bristles that do not rise along an exponential.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_banded

from adaptive_ff.logs.derivatives import Array

SLOPE_STEP = 0.05
"""Step of the difference quotients by the logarithm of a path."""


class Bending(NamedTuple):
    """Over which path friction follows.

    Attributes
    ----------
    path : float
        The path ``s`` far above the Stribeck velocity, rad.
    excess, speed : float
        Stiction above Coulomb friction, over that, and Stribeck velocity, rad/s: by what the path is longer.
    """

    path: float
    excess: float = 0.0
    speed: float = 1.0

    def ways(self, velocity: Array, step: float) -> Array:
        """Return how far a motion goes in each of its steps (s), over the path at its speed (rad/s)."""
        speed = np.abs(velocity)
        return np.asarray(speed * (step / self.path) / (1.0 + self.excess * np.exp(-speed / self.speed)))


class OverPath(NamedTuple):
    """Friction over a path, along a motion.

    Attributes
    ----------
    velocity : ndarray, shape (n, times)
        Velocity around each sample, rad/s, the times of a sample before those of the next.
    step : float
        Time between them, s.
    bending : Bending
        The path.
    """

    velocity: Array
    step: float
    bending: Bending

    def at_samples(self, static: Callable[[Array], Array]) -> Array:
        """Return what friction is at the samples, of its static curve over the velocity."""
        return self._both(static)[0]

    def beyond(self, static: Callable[[Array], Array]) -> Array:
        """Return what it is at the samples beyond its mean around them."""
        at, mean = self._both(static)
        return at - mean

    def rate(self) -> Array:
        """Return how fast the direction of the friction changes at the samples, 1/s; stiction counts as in the path."""
        velocity = self.velocity.ravel()
        _, excess, speed = self.bending
        static = np.sign(velocity) * (1.0 + excess * np.exp(-np.abs(velocity) / speed))
        after = followed(static, self.bending.ways(velocity, self.step))
        change = np.diff(after, prepend=after[:1]).reshape(self.velocity.shape) / self.step
        times = self.velocity.shape[1]
        place = times // 2
        return np.asarray(change[:, place] if times % 2 else 0.5 * (change[:, place - 1] + change[:, place]))

    def slope(self, static: Callable[[Array], Array]) -> Array:
        """Return its derivative by the logarithm of the path, at the samples."""
        path = self.bending.path
        more, less = (
            self._replace(bending=self.bending._replace(path=path * math.exp(side * SLOPE_STEP)))
            for side in (1.0, -1.0)
        )
        return (more.at_samples(static) - less.at_samples(static)) / (2.0 * SLOPE_STEP)

    def _both(self, static: Callable[[Array], Array]) -> tuple[Array, Array]:
        size, times = self.velocity.shape
        velocity = self.velocity.ravel()
        after = followed(static(velocity), self.bending.ways(velocity, self.step))
        middle = 0.5 * (after + np.concatenate([after[:1], after[:-1]])).reshape(size, times)
        place = times // 2
        at = middle[:, place] if times % 2 else after.reshape(size, times)[:, place - 1]
        return at, np.mean(middle, axis=1)


def followed(static: Array, ways: Array) -> Array:
    """Return what follows a series over a path, behind each of its steps; it begins where the series does.

    Parameters
    ----------
    static : ndarray, shape (n,)
        The series, constant over a step.
    ways : ndarray, shape (n,)
        How far each step goes, over the path, zero or more.
    """
    kept = np.exp(-ways)
    bands = np.ones((2, ways.size))  # y[k] - kept[k] y[k - 1] = (1 - kept[k]) static[k]
    bands[1, :-1] = -kept[1:]
    target = -np.expm1(-ways) * static
    target[0] = static[0]
    return np.asarray(solve_banded((1, 0), bands, target, overwrite_ab=True, overwrite_b=True, check_finite=False))
