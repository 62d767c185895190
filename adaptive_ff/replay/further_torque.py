"""Terms of a fixed model that ``TorqueModel`` has not: gravity, ripples, and viscous friction that saturates."""

import math
from typing import NamedTuple

import numpy as np
from scipy import signal

from adaptive_ff.identify.result import LogIdentification
from adaptive_ff.identify.terms import BENT, GRAVITY, SATURATIONS, bent_friction
from adaptive_ff.logs.derivatives import Array
from adaptive_ff.replay.watching import Seen


class Ripple(NamedTuple):
    """``sine sin(2 pi q/period) + cosine cos(2 pi q/period)``, N m, of a period, rad."""

    period: float
    sine: float
    cosine: float


class FurtherTorque(NamedTuple):
    """``Gs sin q + Gc cos q``, ripples of shorter periods, and saturating friction with the lag of the model.

    Attributes
    ----------
    sine, cosine : float
        Gravity, N m.
    shape : str
        One of ``SATURATIONS``; empty for none.
    size, bend : float
        Friction that saturates, N m, and its speed, rad/s.
    lag : float
        Friction lag, s.
    ripples : tuple of Ripple
        Ripples over the position.
    """

    sine: float = 0.0
    cosine: float = 0.0
    shape: str = ""
    size: float = 0.0
    bend: float = 1.0
    lag: float = 0.0
    ripples: tuple[Ripple, ...] = ()

    @property
    def has_gravity(self) -> bool:
        """Whether there is a torque of gravity."""
        return self.sine != 0.0 or self.cosine != 0.0

    def along(self, seen: Seen, period: float, lagged: float) -> tuple[Array, float]:
        """Return the mean torque over the period that begins with each sample, and the friction at the end.

        Parameters
        ----------
        seen : Seen
            Part of a log; there is neither gravity nor ripple without a position.
        period : float
            Sample time, s.
        lagged : float
            Saturating friction at its start, N m.
        """
        coming = np.where(np.isfinite(seen.coming), seen.coming, seen.reference)
        speed = 0.5 * (seen.reference + coming)
        torque = np.zeros(speed.size)
        if np.all(np.isfinite(seen.position)):
            middle = seen.position + 0.5 * period * speed
            for length, sine, cosine in (Ripple(2.0 * math.pi, self.sine, self.cosine), *self.ripples):
                phase = 2.0 * math.pi / length * middle
                torque += sine * np.sin(phase) + cosine * np.cos(phase)
        if not self.shape:
            return torque, 0.0
        static = self.size * bent_friction(self.shape, speed, self.bend)
        if self.lag <= 0.0:
            return torque + static, 0.0
        share = -math.expm1(-period / self.lag)
        ends, _ = signal.lfilter([share], [1.0, share - 1.0], static, zi=[(1.0 - share) * lagged])
        starts = np.concatenate([[lagged], ends[:-1]])
        torque += static + (starts - static) * share * self.lag / period
        return torque, float(ends[-1])

    def sentence(self) -> str:
        """Return what it has, as a sentence; empty where it has nothing."""
        parts = []
        if self.has_gravity:
            sign = "-" if self.cosine < 0.0 else "+"
            parts.append(f"gravity of {self.sine:.3g} sin q {sign} {abs(self.cosine):.3g} cos q")
        for one in self.ripples:
            parts.append(f"a ripple of {math.hypot(one.sine, one.cosine):.3g} every {one.period:.3g}")
        if self.shape:
            parts.append(f"friction of {self.size:.3g} that saturates from {self.bend:.3g} on")
        return f" It has {' and '.join(parts)}, too." if parts else ""


def further_torque(found: LogIdentification) -> FurtherTorque:
    """Return the further terms of an identified joint."""
    values = found.selection.chosen.values
    shape = next((term for term in SATURATIONS if term in values), "")
    sine, cosine = (values.get(term, 0.0) for term in GRAVITY)
    learnt = found.position_map
    ripples: tuple[Ripple, ...] = ()
    if learnt is not None:
        sizes = [one.value for one in learnt.force_coefficients]
        ripples = tuple(map(Ripple, learnt.force_periods, sizes[1::2], sizes[::2]))
    return FurtherTorque(
        sine,
        cosine,
        shape,
        values.get(shape, 0.0),
        values[BENT[shape]] if shape else 1.0,
        values.get("friction_lag", 0.0),
        ripples,
    )
