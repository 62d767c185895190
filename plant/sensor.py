"""What the controller sees of the joint."""

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict

from plant.joint import NonNegative


class VelocitySensor(BaseModel):
    """A velocity sensor with white Gaussian noise.

    Parameters
    ----------
    velocity_noise : float, optional
        Standard deviation of the noise, rad/s.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    velocity_noise: NonNegative = 0.0

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
