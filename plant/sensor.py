"""What the controller sees of the joint: a velocity with noise, or a position with a resolution, and faults of both."""

import math
from typing import Annotated, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from plant.fields import NonNegative, Positive, Table

Fraction = Annotated[float, Field(ge=0.0, lt=1.0, allow_inf_nan=False, strict=True)]


def encoder_reading(resolution: float, position: float) -> float:
    """Return the multiple of the resolution next to a position, both in rad."""
    return resolution * math.floor(position / resolution + 0.5)


class AngleRipple(NamedTuple):
    """By how much an angle is off as a joint turns: of a resolver, a tachometer or a disc that is not round."""

    amplitude: float  # amplitude, rad; zero where there is none
    waves: float  # periods in a radian, times ``2 pi``


def measured_angle(ripple: AngleRipple, position: float) -> float:
    """Return a position (rad) as it is measured, before it is rounded."""
    if ripple.amplitude == 0.0:
        return position
    return position + ripple.amplitude * math.sin(ripple.waves * position)


def measured_speed(ripple: AngleRipple, position: float, velocity: float) -> float:
    """Return the derivative of the measured angle, rad/s, at a position (rad) and a velocity (rad/s)."""
    if ripple.amplitude == 0.0:
        return velocity
    return velocity * (1.0 + ripple.amplitude * ripple.waves * math.cos(ripple.waves * position))


class Sensor(Table):
    """A velocity sensor with white Gaussian noise, or an encoder."""

    velocity_noise: NonNegative = 0.0  # standard deviation of the noise of a velocity sensor, rad/s
    # step of an encoder, rad; it gives the position of the motor, rounded, instead of a velocity
    encoder_resolution: Positive | None = None
    leap: NonNegative = 0.0  # by how much single velocities are wrong, up or down, rad/s, ...
    leap_share: Fraction = 0.0  # ... and the fraction of the samples at which they are
    # for how many samples the sensor now and then gives its last value once more, as one does whose messages are
    # lost, ...
    held: Annotated[int, Field(ge=0, lt=2**63, strict=True)] = 0
    held_share: Fraction = 0.0  # ... and the fraction of the samples at which it begins to
    # by how much the measured angle is off, to and fro as the joint turns, rad: in the velocity that is a fraction of
    # ``2 pi ripple_amplitude / ripple_period``, which must be below one, ...
    ripple_amplitude: NonNegative = 0.0
    ripple_period: Positive = 2.0 * math.pi  # ... and the motion over which that repeats, rad; a turn by default

    @model_validator(mode="after")
    def _check_choice(self) -> Self:
        if self.encoder_resolution is not None and self.velocity_noise > 0.0:
            raise ValueError(
                f"velocity_noise = {self.velocity_noise:g} is not allowed beside encoder_resolution: an encoder "
                "has no velocity; leave one of them out"
            )
        if self.encoder_resolution is not None and self.leap > 0.0:
            raise ValueError(
                f"leap = {self.leap:g} is not allowed beside encoder_resolution: an encoder has no velocity"
            )
        for name in ("leap", "held"):
            size, often = getattr(self, name), getattr(self, f"{name}_share")
            if (size > 0) != (often > 0.0):
                raise ValueError(f"{name} = {size:g} and {name}_share = {often:g} are not allowed: give both or none")
        ripple = self.angle_ripple
        if ripple.amplitude * ripple.waves >= 1.0:
            raise ValueError(
                f"ripple_amplitude = {self.ripple_amplitude:g} rad is not allowed: it must be below ripple_period over "
                f"2 pi, {1.0 / ripple.waves:.3g} rad, or the angle would run backwards"
            )
        return self

    @property
    def angle_ripple(self) -> AngleRipple:
        """How far the measured angle is off, as the kernels take it."""
        return AngleRipple(self.ripple_amplitude, 2.0 * math.pi / self.ripple_period)

    @property
    def is_random(self) -> bool:
        """Whether two draws differ."""
        return self.velocity_noise > 0.0 or self.leap > 0.0 or self.held > 0

    def draw(self, samples: int, generator: np.random.Generator) -> NDArray[np.float64]:
        """Draw the noise (rad/s) of so many samples before a run starts, so that a seed means the same everywhere."""
        noise = self.velocity_noise * generator.standard_normal(samples)
        if self.leap > 0.0:
            leaps = generator.random(samples) < self.leap_share
            noise[leaps] += self.leap * generator.choice([-1.0, 1.0], np.count_nonzero(leaps))
        return noise

    def draw_held(self, samples: int, generator: np.random.Generator) -> NDArray[np.bool_]:
        """Draw at which of so many samples the sensor gives its last value once more, after :meth:`draw`."""
        held = np.zeros(samples, dtype=bool)
        if self.held > 0:
            begins = generator.random(samples) < self.held_share
            held |= np.convolve(begins, np.ones(self.held, dtype=int))[:samples] > 0
        return held
