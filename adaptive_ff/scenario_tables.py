"""The tables of a scenario file that are no part of the simulated joint: what is sampled, told and drawn."""

import math
from typing import Annotated, Self

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

from adaptive_ff.model import TorqueModel
from adaptive_ff.reference import NonNegative, Positive
from controllers import pi_gains

STRICT = ConfigDict(frozen=True, extra="forbid", strict=True)


class Sampling(BaseModel):
    """When the controller runs: ``period`` in s, a whole number of solver periods."""

    model_config = STRICT
    period: Positive = 0.01


class Feedback(BaseModel):
    """What the designer of the PI loop assumes.

    Parameters
    ----------
    inertia : float
        Assumed inertia, kg m^2.
    bandwidth : float, optional
        Open-loop crossover, Hz; checked against the largest one that a maximum sensitivity of 1.7 allows.
    proportional, integral : float, optional
        Gains given directly instead, N m s/rad and N m/rad; not checked.
    """

    model_config = STRICT
    inertia: Positive
    bandwidth: Positive | None = None
    proportional: Positive | None = None
    integral: NonNegative | None = None

    @model_validator(mode="after")
    def _check_choice(self) -> Self:
        gains = (self.proportional, self.integral)
        if self.bandwidth is None and None in gains:
            raise ValueError("bandwidth is missing; give it, or both proportional and integral")
        if self.bandwidth is not None and gains != (None, None):
            raise ValueError(f"bandwidth = {self.bandwidth:g} is given beside gains; give it or both gains, not both")
        proportional, integral = self.gains
        if not (0.0 < proportional < math.inf and integral < math.inf):
            raise ValueError(
                f"inertia = {self.inertia:g} kg m^2 and bandwidth = {self.bandwidth:g} Hz make a proportional gain of "
                f"{proportional:g} and an integral gain of {integral:g}; both must be finite, the first positive"
            )
        return self

    @property
    def gains(self) -> tuple[float, float]:
        """Proportional (N m s/rad) and integral (N m/rad) gain."""
        if self.proportional is not None and self.integral is not None:
            return self.proportional, self.integral
        assert self.bandwidth is not None
        return pi_gains(self.inertia, self.bandwidth)


class Adaptation(BaseModel):
    """What the adaptive controllers are told: ``Vs`` (rad/s), ``delta``, and their memory (s of sliding motion)."""

    model_config = STRICT
    stribeck_velocity: Positive
    stribeck_shape: Positive = 1.0
    memory: Positive = 5.0


class FixedModel(BaseModel):
    """Parameters of the controller ``fixed``; what is not given is zero, stiction then equals Coulomb friction."""

    model_config = STRICT
    inertia: NonNegative = 0.0
    coulomb: NonNegative = 0.0
    stiction: NonNegative | None = None
    viscous: NonNegative = 0.0
    friction_lag: NonNegative = 0.0
    stribeck_velocity: Positive = 1.0
    stribeck_shape: Positive = 1.0

    @property
    def model(self) -> TorqueModel:
        """The model that is fed forward."""
        stiction = self.coulomb if self.stiction is None else self.stiction
        return TorqueModel(
            self.inertia,
            self.coulomb,
            stiction,
            self.viscous,
            self.friction_lag,
            self.stribeck_velocity,
            self.stribeck_shape,
        )


def _check_range(value: list[float]) -> list[float]:
    if value[0] > value[1]:
        raise ValueError(f"{value} is not allowed: the lower bound must come first")
    return value


PositiveRange = Annotated[list[Positive], Field(min_length=2, max_length=2), AfterValidator(_check_range)]
Range = Annotated[list[NonNegative], Field(min_length=2, max_length=2), AfterValidator(_check_range)]
RatioRange = Annotated[
    list[Annotated[float, Field(ge=1.0, allow_inf_nan=False)]],
    Field(min_length=2, max_length=2),
    AfterValidator(_check_range),
]


class Sweep(BaseModel):
    """Ranges that ``adaptive-ff sweep`` draws joints from, each ``[lowest, highest]``.

    Parameters
    ----------
    inertia, coulomb, viscous : list of float
        Factors on the scenario's values, drawn evenly on a logarithmic scale.
    stiction : list of float
        Stiction as a multiple of the drawn Coulomb friction, drawn evenly.
    friction_lag, velocity_noise : list of float
        Friction lag (s) and noise (rad/s), drawn evenly.
    told_stribeck_velocity, told_inertia : list of float
        What the controllers are told, as a multiple of the truth, drawn evenly on a logarithmic scale.
    """

    model_config = STRICT
    inertia: PositiveRange = [0.1, 10.0]
    coulomb: PositiveRange = [0.1, 10.0]
    viscous: PositiveRange = [0.1, 10.0]
    stiction: RatioRange = [1.0, 2.0]
    friction_lag: Range = [0.0, 0.05]
    velocity_noise: Range = [0.0, 0.005]
    told_stribeck_velocity: PositiveRange = [0.5, 2.0]
    told_inertia: PositiveRange = [0.7, 1.3]
