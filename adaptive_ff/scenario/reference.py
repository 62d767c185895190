"""Reference motions: a multisine, or one that was recorded."""

import math
import warnings
from pathlib import Path
from typing import Annotated, Literal, Self

import numpy as np
import scipy
from numpy.typing import NDArray
from pydantic import Field, model_validator

from adaptive_ff.errors import InputError
from adaptive_ff.logs.text_tables import read_table
from adaptive_ff.scenario.series import chunks, largest_size, sum_of_sines
from plant.fields import Finite, NonNegative, Positive, StrictTable

SHORTEST = 60.0  # a recorded reference that is shorter than this (s) repeats until then
LARGEST_SEAM = 0.05
"""Jump between the end and the start of a repeated reference, relative to its peak, that goes without a warning."""


class Multisine(StrictTable):
    """A sum of sines with random phases."""

    kind: Literal["multisine"] = "multisine"
    # frequencies, Hz, slower than half the sampling frequency
    frequencies: list[Positive] = Field(default=[0.01, 0.05, 0.11, 0.23, 0.41, 0.7, 1.0], min_length=1)
    # relative amplitudes, one a frequency
    amplitudes: list[Finite] = Field(default=[0.12, 0.1, 0.08, 0.06, 0.05, 0.04, 0.03], min_length=1)
    # largest absolute velocity, rad/s; by default what suits the joint, see ``scenario.plausibility``
    peak: Positive | None = None
    fade_in: NonNegative = 2.0  # smooth start from rest, s
    # start and end of a standstill inside the motion, s; the motion fades out before it and in after it
    pause: Annotated[list[NonNegative], Field(min_length=2, max_length=2)] | None = None

    @model_validator(mode="after")
    def _check_lengths(self) -> Self:
        if len(self.frequencies) != len(self.amplitudes):
            raise ValueError(
                f"amplitudes has {len(self.amplitudes)} values, frequencies has {len(self.frequencies)}; "
                "there must be one amplitude a frequency"
            )
        if not any(self.amplitudes):
            raise ValueError("amplitudes are all zero; at least one must not be")
        if self.pause is not None and self.pause[0] >= self.pause[1]:
            raise ValueError(f"pause = {self.pause} is not allowed: its start must be before its end")
        return self

    def velocity(self, time: NDArray[np.float64], generator: np.random.Generator) -> NDArray[np.float64]:
        """Return the velocity (rad/s) on an even grid of times (s) from zero; without a peak one of 1 rad/s."""
        phases = generator.uniform(0.0, 2.0 * math.pi, len(self.frequencies))
        amplitudes = np.array(self.amplitudes)
        weights = amplitudes / np.max(np.abs(amplitudes))
        velocity = sum_of_sines(2.0 * math.pi * np.array(self.frequencies), phases, weights, time)
        peak = 1.0 if self.peak is None else self.peak
        velocity *= peak / max(largest_size(velocity), np.finfo(float).tiny)
        for part in chunks(time.size):
            velocity[part] *= self._fraction(time[part])
        return velocity

    def _fraction(self, time: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return by how much the motion is faded in, and out and in about its pause."""
        fraction = self._faded(time)
        if self.pause is not None:
            begin, end = self.pause
            fraction *= np.where(time < 0.5 * (begin + end), self._faded(begin - time), self._faded(time - end))
        return fraction

    def _faded(self, time: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return a smooth rise from 0 to 1 that begins at time zero; a jump there without a fade."""
        if self.fade_in == 0.0:
            return np.where(time >= 0.0, 1.0, 0.0)
        fraction = np.clip(time / self.fade_in, 0.0, 1.0)
        return fraction * fraction * (3.0 - 2.0 * fraction)


class Recorded(StrictTable):
    """A recorded motion from a CSV file with a header line.

    Resampling: a velocity column is interpolated by a shape-preserving piecewise cubic (PCHIP, no overshoot), a
    position column by a cubic spline through its points, whose derivative is the reference. Positions are not smoothed.
    """

    kind: Literal["csv"]
    path: str = Field(min_length=1)  # the file; relative to the scenario file
    # names of the columns, in s, rad/s and rad. The position serves where the file has no velocity
    time: str = "time"
    velocity: str = "velocity"
    position: str = "position"

    def read(self) -> "Motion":
        """Read the file."""
        file, (time, *motion) = Path(self.path), (self.time, self.velocity, self.position)
        names = read_table(file, (), complete=True)[0].names
        if time not in names or not set(motion) & set(names):
            shown = " ".join(", ".join(names).split())
            raise InputError(f"{file}: the columns are {shown[:80]}; there must be {time} and {' or '.join(motion)}")
        table = read_table(file, [time, *motion], complete=True)[1]
        values = table[self.velocity] if self.velocity in table else table[self.position]
        return Motion(self.path, table[self.time], values, self.velocity not in table)


class Motion:
    """A recorded motion, ready to be resampled: velocities (rad/s) or positions (rad) at times (s) that ascend.

    Its name says in messages where it comes from.
    """

    def __init__(self, name: str, time: NDArray[np.float64], values: NDArray[np.float64], is_position: bool) -> None:
        if time.size < 4:
            raise InputError(f"{name}: {time.size} rows are not enough for a motion; there must be at least 4")
        with np.errstate(over="ignore", invalid="ignore"):  # a span beyond floating point is infinite; refused below
            elapsed = time - time[0]
            late = np.nonzero(~(np.diff(elapsed) > 0.0))[0]
        if late.size:
            row = int(late[0])
            raise InputError(
                f"{name}: time = {time[row + 1]:.10g} s in row {row + 2} follows {time[row]:.10g} s; "
                "times must ascend strictly"
            )
        self.name = name
        self.duration = float(elapsed[-1])
        shape = scipy.interpolate.CubicSpline if is_position else scipy.interpolate.PchipInterpolator
        try:
            with np.errstate(all="ignore"):
                curve = shape(elapsed, values)
        except ValueError as error:
            raise InputError(f"{name}: no smooth curve goes through the values: {error}") from error
        self._velocity = curve.derivative() if is_position else curve

    def velocity(self, time: NDArray[np.float64], unit: str = "rad/s") -> NDArray[np.float64]:
        """Return the velocity, in a unit, at ascending times (s) from zero; beyond its end the motion repeats."""
        end = self.duration * (1.0 + 1e-9)
        moment = np.where(time <= end, np.minimum(time, self.duration), np.mod(time, self.duration))
        velocity: NDArray[np.float64] = self._velocity(moment)
        if time[-1] > end:
            seam = abs(float(self._velocity(self.duration) - self._velocity(0.0)))
            if seam > LARGEST_SEAM * float(np.max(np.abs(velocity))):
                warnings.warn(
                    f"{self.name}: the motion is repeated every {self.duration:g} s, but ends {seam:.3g} {unit} away "
                    "from where it starts: the reference jumps there",
                    stacklevel=2,
                )
        return velocity
