"""A motion for identification, and the limits that it keeps."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from adaptive_ff.scenario.waves import Fourier
from adaptive_ff.studies.information import Array


@dataclass(frozen=True)
class MotionLimits:
    """Limits of a motion, each as a size either way; None where there is none."""

    velocity: float  # velocity, rad/s
    position: float | None = None  # distance from where the motion starts, rad
    acceleration: float | None = None  # acceleration, rad/s^2
    torque: float | None = None  # torque that the assumed joint needs, N m; more than its stiction


@dataclass(frozen=True, eq=False)
class Excitation:
    """A motion for identification."""

    reference: Fourier  # the series
    limits: MotionLimits  # the limits that it keeps
    # largest size of ``position`` (rad), ``velocity``, ``acceleration`` and ``torque`` (N m) on its way
    largest: dict[str, float]
    # interval of each parameter that is to be expected over the one that the motion gives that it is measured by
    sizes: dict[str, float]

    @property
    def widest(self) -> float:
        """The largest of ``sizes``; infinite where one is unknown."""
        return max(math.inf if math.isnan(size) else size for size in self.sizes.values())

    def to_dict(self) -> dict[str, Any]:
        """Return the motion as ``adaptive-ff excite --json`` writes it."""
        sizes = {name: size if math.isfinite(size) else None for name, size in self.sizes.items()}
        return {
            "reference": self.reference.model_dump(),
            "limits": vars(self.limits),
            "largest": self.largest,
            "intervals_over_multisine": sizes,
        }

    def columns(self, step: float) -> dict[str, Array]:
        """Return time, position, velocity and acceleration of one period on a grid of a step (s)."""
        time = np.arange(math.floor(self.reference.period / step + 1e-9) + 1, dtype=np.float64) * step
        series = Series(self.reference.period, len(self.reference.sines), time)
        coefficients = np.array([*self.reference.cosines, *self.reference.sines])
        return {
            "time": time,
            **{name: series[name] @ coefficients for name in ("position", "velocity", "acceleration")},
        }


class Series(dict[str, Array]):
    """Matrices that give position, velocity and acceleration of a series on a grid from its coefficients."""

    def __init__(self, period: float, harmonics: int, time: Array) -> None:
        turns = 2.0 * math.pi / period * np.arange(1, harmonics + 1)
        cosine, sine = np.cos(np.outer(time, turns)), np.sin(np.outer(time, turns))
        super().__init__(
            position=np.hstack([sine / turns, (1.0 - cosine) / turns]),
            velocity=np.hstack([cosine, sine]),
            acceleration=np.hstack([-sine * turns, cosine * turns]),
        )
