"""A periodic reference: a Fourier series of velocity, as ``adaptive-ff excite`` finds one."""

import math
from typing import Annotated, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, model_validator

from plant.fields import Finite, Positive


class Fourier(BaseModel):
    """``w = sum_k c_k cos(2 pi k t/T) + s_k sin(2 pi k t/T)``, ``k = 1, 2, ...``: velocity and position are periodic.

    Parameters
    ----------
    period : float
        Period ``T``, s.
    cosines, sines : list of float
        Coefficients ``c_k`` and ``s_k``, rad/s, as many of one as of the other. Where the cosines sum to zero, the
        motion begins at rest.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    kind: Literal["fourier"]
    period: Positive
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
