"""References by formula: a triangle wave, a staircase of constant velocities, and a Fourier series."""

import math
from typing import Annotated, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from plant.fields import Finite, Positive, StrictTable


class Triangle(StrictTable):
    """A triangle wave of velocity, from rest: constant acceleration, forth and back."""

    kind: Literal["triangle"]
    peak: Positive = 0.3  # largest velocity, rad/s
    period: Positive = 4.0  # period of the wave, s

    def velocity(self, time: NDArray[np.float64], generator: np.random.Generator) -> NDArray[np.float64]:
        """Return the reference velocity (rad/s) on an ascending grid of times (s); nothing is drawn."""
        return self.peak * np.interp(time / self.period, [0.0, 0.25, 0.75, 1.0], [0.0, 1.0, -1.0, 0.0], period=1.0)


class Staircase(StrictTable):
    """Constant velocities one after another, with ramps between them, as for a friction curve."""

    kind: Literal["staircase"]
    # velocities, rad/s, in their order; after the last one it begins again with the first
    velocities: Annotated[list[Finite], Field(min_length=1)] = [0.05, 0.1, 0.2, 0.3, -0.05, -0.1, -0.2, -0.3]
    hold: Positive = 2.0  # time at each of them, s
    acceleration: Positive = 1.0  # acceleration of the ramps, rad/s^2

    @model_validator(mode="after")
    def _check_motion(self) -> Self:
        if not any(self.velocities):
            raise ValueError("velocities are all zero; one at least must not be")
        return self

    def velocity(self, time: NDArray[np.float64], generator: np.random.Generator) -> NDArray[np.float64]:
        """Return the reference velocity (rad/s) on an ascending grid of times (s); nothing is drawn."""
        begin, cycle = self._corners(0.0)[-1], self._corners(self.velocities[-1])
        again = np.mod(time - begin, cycle[-1])
        return np.where(time < begin, self._stairs(0.0, time), self._stairs(self.velocities[-1], again))

    def _corners(self, start: float) -> NDArray[np.float64]:
        """Return the times (s) at which ramps begin and end, from a velocity (rad/s) on."""
        ramps = np.abs(np.diff([start, *self.velocities])) / self.acceleration
        return np.append(0.0, np.cumsum(np.column_stack([ramps, np.full(ramps.size, self.hold)])))

    def _stairs(self, start: float, time: NDArray[np.float64]) -> NDArray[np.float64]:
        levels = np.append(start, np.repeat(self.velocities, 2))
        stairs: NDArray[np.float64] = np.interp(time, self._corners(start), levels)
        return stairs


class Fourier(StrictTable):
    """``w = sum_k c_k cos(2 pi k t/T) + s_k sin(2 pi k t/T)``, ``k = 1, 2, ...``: velocity and position repeat."""

    kind: Literal["fourier"]
    period: Positive  # period ``T``, s
    # coefficients ``c_k`` and ``s_k``, rad/s, as many of one as of the other. Where the cosines sum to zero, the motion
    # begins at rest
    cosines: Annotated[list[Finite], Field(min_length=1)]
    sines: Annotated[list[Finite], Field(min_length=1)]

    @model_validator(mode="after")
    def _check_lengths(self) -> Self:
        if len(self.cosines) != len(self.sines):
            raise ValueError(
                f"sines has {len(self.sines)} values, cosines has {len(self.cosines)}; there must be as many"
            )
        if not any([*self.cosines, *self.sines]):
            raise ValueError("cosines and sines are all zero; one at least must not be")
        return self

    def velocity(self, time: NDArray[np.float64], generator: np.random.Generator) -> NDArray[np.float64]:
        """Return the reference velocity (rad/s) at times (s); nothing is drawn."""
        velocity = np.zeros_like(time)
        turn = 2.0 * math.pi / self.period
        for k, (cosine, sine) in enumerate(zip(self.cosines, self.sines, strict=True), start=1):
            velocity += cosine * np.cos(k * turn * time) + sine * np.sin(k * turn * time)
        return velocity
