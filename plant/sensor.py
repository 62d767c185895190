"""What the controller sees of the joint: a velocity with noise, or a position with a resolution."""

import math
from typing import Self

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray
from pydantic import ConfigDict, model_validator

from plant.fields import NonNegative, Positive, Table


@register_jitable
def encoder_reading(resolution: float, position: float) -> float:
    """Return the multiple of the resolution next to a position, both in rad."""
    return resolution * math.floor(position / resolution + 0.5)


class Sensor(Table):
    """A velocity sensor with white Gaussian noise, or an encoder.

    Parameters
    ----------
    velocity_noise : float, optional
        Standard deviation of the noise of a velocity sensor, rad/s.
    encoder_resolution : float, optional
        Step of an encoder, rad; it gives the position of the motor, rounded, instead of a velocity.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    velocity_noise: NonNegative = 0.0
    encoder_resolution: Positive | None = None

    @model_validator(mode="after")
    def _check_choice(self) -> Self:
        if self.encoder_resolution is not None and self.velocity_noise > 0.0:
            raise ValueError(
                f"velocity_noise = {self.velocity_noise:g} rad/s is not allowed beside encoder_resolution: an encoder "
                "has no velocity; leave one of them out"
            )
        return self

    def draw(self, samples: int, generator: np.random.Generator) -> NDArray[np.float64]:
        """Draw the noise of a run before it starts, so that a seed means the same everywhere.

        Parameters
        ----------
        samples : int
            Number of samples.
        generator : numpy.random.Generator
            Source of randomness.

        Returns
        -------
        ndarray, shape (samples,)
            Noise, rad/s.
        """
        return self.velocity_noise * generator.standard_normal(samples)
