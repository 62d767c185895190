"""References by formula: triangle wave, staircase of velocities, Fourier series, and moves of limited jerk."""

import math
from itertools import product
from typing import Annotated, Literal, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from plant.fields import Finite, NonNegative, Positive, StrictTable


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


class Move(NamedTuple):
    """A move from rest to rest: a rectangle of velocity behind one or two moving averages.

    The averages limit the acceleration to ``speed/ramp`` and the jerk to ``speed/(ramp rounding)``, as long as the
    rectangle is not shorter than both together.
    """

    distance: float  # distance, rad, with its sign
    length: float  # length of the rectangle, s
    # lengths of the moving averages, s; the second is zero for a trapezoid
    ramp: float
    rounding: float

    @property
    def duration(self) -> float:
        """Duration of the move, s."""
        return self.length + self.ramp + self.rounding

    def velocity(self, time: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the velocity (rad/s) at times (s) from the start of the move; zero before and after it."""
        velocity = np.zeros_like(time)
        inside = (time > 0.0) & (time < self.duration)
        moment, height = time[inside], self.distance / self.length if self.length else 0.0
        averages = [average for average in (self.ramp, self.rounding) if average > 0.0]
        order = len(averages)
        found = np.zeros_like(moment)
        # a rectangle and each average are differences of two steps; integrated together they are powers of the time
        for late in product((False, True), repeat=order + 1):
            delay = sum(length for length, is_late in zip((self.length, *averages), late, strict=True) if is_late)
            found += (-1.0) ** sum(late) * np.maximum(moment - delay, 0.0) ** order
        scale = height / (math.factorial(order) * math.prod(averages))
        velocity[inside] = np.clip(scale * found, -abs(height), abs(height))
        return velocity


def plan_move(distance: float, speed: float, acceleration: float, jerk: float | None = None) -> Move:
    """Return the move over a distance (rad) within a speed (rad/s), an acceleration (rad/s^2) and a jerk (rad/s^3)."""
    size = abs(distance)
    if size == 0.0:
        return Move(0.0, 0.0, 0.0, 0.0)
    if jerk is None:
        reached = min(speed, math.sqrt(size * acceleration))
        return Move(distance, size / reached, reached / acceleration, 0.0)
    rounding = acceleration / jerk
    # the rectangle as long as both averages: once with the full acceleration, else with two equal averages
    reached = 0.5 * acceleration * (math.sqrt(rounding**2 + 4.0 * size / acceleration) - rounding)
    if reached < acceleration * rounding:
        reached = (0.25 * size**2 * jerk) ** (1.0 / 3.0)
    reached = min(reached, speed)
    if reached < acceleration * rounding:
        rounding = math.sqrt(reached / jerk)
        return Move(distance, size / reached, rounding, rounding)
    return Move(distance, size / reached, reached / acceleration, rounding)


class PointToPoint(StrictTable):
    """Moves from point to point that come to rest between them."""

    kind: Literal["point_to_point"]
    # positions that are visited in turn, rad, starting from zero; after the last one it begins again with the first
    positions: Annotated[list[Finite], Field(min_length=1)] | None = None
    distance: Finite | None = None  # instead of positions: forth by so much and back, rad
    speed: Positive = 0.3  # largest speed, rad/s
    acceleration: Positive = 1.0  # largest acceleration, rad/s^2
    jerk: Positive | None = None  # largest jerk, rad/s^3, for an S-curve; without it the profile is a trapezoid
    dwell: NonNegative = 1.0  # rest after each move, s
    # how often the positions are visited; by default until the end of the run
    repeats: Annotated[int, Field(ge=1, lt=2**63)] | None = None

    @model_validator(mode="after")
    def _check_path(self) -> Self:
        if (self.positions is None) == (self.distance is None):
            raise ValueError("positions or distance must be given, and not both")
        if not any(self.path):
            raise ValueError("all positions are zero, where the joint starts; one at least must be another")
        return self

    @property
    def path(self) -> list[float]:
        """Positions that are visited in turn, rad."""
        if self.positions is not None:
            return self.positions
        assert self.distance is not None
        return [self.distance, 0.0]

    def velocity(self, time: NDArray[np.float64], generator: np.random.Generator) -> NDArray[np.float64]:
        """Return the reference velocity (rad/s) on an ascending grid of times (s); nothing is drawn."""
        first, later = self._visit(0.0), self._visit(self.path[-1])
        velocity, begin = self._along(first, time), self._length(first)
        cycle = self._length(later)
        if cycle > 0.0 and self.repeats != 1:
            end = math.inf if self.repeats is None else begin + (self.repeats - 1) * cycle
            again = (time >= begin) & (time < end)
            velocity[again] = self._along(later, np.mod(time[again] - begin, cycle))
        return velocity

    def _visit(self, start: float) -> list[Move]:
        """Return the moves through all positions from a start (rad)."""
        ways = np.diff([start, *self.path]).tolist()
        return [plan_move(way, self.speed, self.acceleration, self.jerk) for way in ways]

    def _length(self, moves: list[Move]) -> float:
        return sum(move.duration + self.dwell for move in moves)

    def _along(self, moves: list[Move], time: NDArray[np.float64]) -> NDArray[np.float64]:
        velocity, begin = np.zeros_like(time), 0.0
        for move in moves:
            velocity += move.velocity(time - begin)
            begin += move.duration + self.dwell
        return velocity
