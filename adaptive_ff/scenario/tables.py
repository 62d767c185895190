"""The tables of a scenario file beside the simulated joint: sampling, what controllers assume, draws."""

import math
from collections.abc import Callable
from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, Discriminator, Field, Tag, field_validator, model_validator
from pydantic_core import PydanticCustomError

from adaptive_ff.errors import InputError
from adaptive_ff.friction.model import IDENTIFIED, TorqueModel
from controllers import (
    PositionLoopParameters,
    default_position_gain,
    difference_velocity,
    kalman_velocity,
    kalman_velocity_gains,
    low_pass_lag,
    low_pass_velocity,
    pi_gains,
)
from controllers.design.velocity_filter import noise_of_positions
from controllers.plausibility import LARGEST_OBSERVED
from plant.fields import Finite, NonNegative, Positive, StrictTable

MOST_PERIODS, MOST_HATS = 7, 100  # most periods of friction over position beside a motor's turn, and hats of its map


LATE = {9: 0.5, 19: 1.0, 29: 0.5}
"""Samples of a cycle that come late when sampling jitters, and by which fraction of the jitter."""

CYCLE = 40  # samples of such a cycle


class Sampling(StrictTable):
    """When the controller runs."""

    period: Positive = 0.01  # mean sampling period, s, a whole number of solver periods
    # outliers of the sampling time as the paper's Fig. 10 shows them, as a fraction of the period: of 40 intervals one
    # is longer by this fraction and two by half of it, the others are shorter. 0.9 is like the figure
    jitter: Annotated[float, Field(ge=0.0, le=5.0, allow_inf_nan=False)] = 0.0

    def steps(self, length: float, solver_period: float) -> NDArray[np.int64]:
        """Return the solver steps of the samples in a time (s), and of the end of the last period."""
        count = math.floor(length / self.period + 1e-6)
        if self.jitter == 0.0:
            return np.arange(count + 1, dtype=np.int64) * round(self.period / solver_period)
        pattern = np.full(CYCLE, 1.0 - self.jitter * sum(LATE.values()) / (CYCLE - len(LATE)))
        for place, fraction in LATE.items():
            pattern[place] = 1.0 + fraction * self.jitter
        ends = np.cumsum(np.resize(pattern, count)) * self.period / solver_period
        steps = np.append(0, np.rint(ends[ends <= length / solver_period + 1e-6])).astype(np.int64)
        return np.unique(steps)


class VelocityEstimate(StrictTable):
    """How the robot makes a velocity of an encoder's positions."""

    # difference of two readings, the same behind a low-pass of first order, or a Kalman filter
    method: Literal["difference", "low_pass", "kalman"] = "low_pass"
    cutoff: Positive = 50.0  # corner of the low-pass, Hz
    # random walk of the acceleration that the Kalman filter expects, rad/s^2 in a root of a second
    acceleration_walk: Positive = 20.0

    def estimator(self, resolution: float, period: float) -> Any:
        """Return the estimator for an encoder's resolution (rad) and a sampling period (s)."""
        if self.method == "difference":
            return difference_velocity(period)
        if self.method == "low_pass":
            return low_pass_velocity(self.cutoff, period)
        gains = kalman_velocity_gains(resolution / math.sqrt(12.0), self.acceleration_walk, period)
        return kalman_velocity(*gains, period)

    def lag(self, period: float) -> float:
        """Return by how much the velocity lags behind the joint's, s; that of the Kalman filter is taken as none."""
        if self.method == "kalman":
            return 0.0
        return low_pass_lag(self.cutoff, period) if self.method == "low_pass" else 0.5 * period

    def noise(self, resolution: float, period: float) -> float:
        """Return the noise that an encoder's resolution (rad) leaves in the velocity, rad/s (standard deviation).

        Rounding errors of the readings are taken as independent and even.
        """
        return resolution / math.sqrt(12.0) * noise_of_positions(self.estimator(resolution, period), period)


AUTO = "auto"  # in the place of a bandwidth: for each controller the one at which it does best

Bandwidth = Annotated[
    Annotated[Positive, Tag("hertz")] | Annotated[Literal["auto"], Tag(AUTO)],
    Discriminator(lambda value: AUTO if value == AUTO else "hertz"),
]


class Feedback(StrictTable):
    """What the designer of the PI loop assumes."""

    inertia: Positive  # assumed inertia, kg m^2
    # open-loop crossover, Hz; checked against the largest one that a maximum sensitivity of 1.7 allows; where the
    # velocity filter takes more, a warning says so. ``auto``: for each controller the one that suits tracking and a
    # step of the load, on seeds of its own (``adaptive-ff tune`` shows how)
    bandwidth: Bandwidth | None = None
    # gains given directly instead, N m s/rad and N m/rad; not checked
    proportional: Positive | None = None
    integral: NonNegative | None = None
    # assumed computation delay of the drive, s; by default the true one of ``[actuator]``. All controllers but the
    # oracle reckon with it
    delay: NonNegative | None = None

    @model_validator(mode="after")
    def _check_choice(self) -> Self:
        gains = (self.proportional, self.integral)
        if self.bandwidth is None and None in gains:
            raise ValueError("bandwidth is missing; give it, or both proportional and integral")
        if self.bandwidth is not None and gains != (None, None):
            shown = self.bandwidth if isinstance(self.bandwidth, str) else f"{self.bandwidth:g}"
            raise ValueError(f"bandwidth = {shown} is given beside gains; give it or both gains, not both")
        if self.is_auto:
            return self
        proportional, integral = self.gains
        if not (1.0 / LARGEST_OBSERVED < proportional < LARGEST_OBSERVED and integral < LARGEST_OBSERVED):
            made = f"inertia = {self.inertia:g} kg m^2 and bandwidth = {self.hertz:g} Hz make" if self.bandwidth else ""
            raise ValueError(
                f"{made or 'there is'} a proportional gain of {proportional:g} and an integral gain of {integral:g}; "
                f"both must be below {LARGEST_OBSERVED:g}, the first above {1.0 / LARGEST_OBSERVED:g}"
            )
        return self

    @field_validator("bandwidth", mode="before")
    @classmethod
    def _check_word(cls, value: Any) -> Any:
        if isinstance(value, str) and value != AUTO:
            raise PydanticCustomError("bandwidth", "it must be a positive and finite number of Hz, or 'auto'")
        return value

    @property
    def is_auto(self) -> bool:
        """Whether each controller is given the bandwidth at which it does best."""
        return self.bandwidth == AUTO

    @property
    def hertz(self) -> float:
        """The bandwidth, Hz; not a number where gains are given, and refused where it is ``auto``."""
        if isinstance(self.bandwidth, str):
            raise InputError(
                f"feedback.bandwidth = {AUTO!r} is not allowed here: there is one for each controller; give a number, "
                "adaptive-ff tune finds it"
            )
        return math.nan if self.bandwidth is None else self.bandwidth

    @property
    def gains(self) -> tuple[float, float]:
        """Proportional (N m s/rad) and integral (N m/rad) gain; errors are those of ``hertz``."""
        if self.proportional is not None and self.integral is not None:
            return self.proportional, self.integral
        return pi_gains(self.inertia, self.hertz)


class Adaptation(StrictTable):
    """What the adaptive controllers assume of the joint: prior knowledge that may be wrong."""

    # pre-estimated ``Vs`` (rad/s) and ``delta``
    stribeck_velocity: Positive
    stribeck_shape: Positive = 1.0
    memory: Positive | None = None  # memory, s of sliding motion; by default what suits each controller
    # what ``adaptive`` identifies: the paper's five parameters; an offset beside them; friction by direction, too. By
    # default an offset and, where a position is given, gravity
    identify: Literal["symmetric", "offset", "directions", "gravity", "directions_and_gravity"] | None = None
    # known periods of a torque over position, such as cogging, rad: the adaptive controllers learn a sine and a cosine
    # of each
    ripple_periods: Annotated[list[Positive], Field(max_length=MOST_PERIODS + 1)] = []
    # known periods of friction over position, rad: ``adaptive`` learns a cosine and a sine of each
    position_periods: Annotated[list[Positive], Field(max_length=MOST_PERIODS)] = []
    motor_turn: bool = False  # whether a turn of the motor is one of them, ``2 pi / joint.gear_ratio``
    # number of the hats of a piecewise linear map of friction over position, without a known period; 2 or more
    position_hats: Annotated[int, Field(ge=0, le=MOST_HATS)] = 0
    # positions of the first and of the last hat, rad; a turn about zero by default
    position_range: Annotated[list[Finite], Field(min_length=2, max_length=2)] | None = None
    # whether friction may rise with the torque that the joint is known to transmit: identified gravity here
    load_friction: bool = False
    # what of the identified friction ``adaptive`` feeds, from 0 to 1
    friction_share: Annotated[float, Field(ge=0.0, le=1.0, allow_inf_nan=False)] = 1.0

    @model_validator(mode="after")
    def _check_map(self) -> Self:
        if self.position_hats == 1:
            raise ValueError("position_hats = 1 is not allowed: it must be 0, or 2 and more")
        if self.position_range is not None and not self.position_range[0] < self.position_range[1]:
            raise ValueError(f"position_range = {self.position_range} is not allowed: the lower position must be first")
        if self.position_range is not None and self.position_hats == 0:
            raise ValueError(f"position_range = {self.position_range} is given without position_hats; give both")
        return self

    @property
    def parameters(self) -> tuple[str, ...] | None:
        """Names of the parameters that the adaptive controllers identify, where they are given."""
        return None if self.identify is None else IDENTIFIED[self.identify]


class FixedModel(StrictTable):
    """Parameters of the controller ``fixed``; what is not given is zero, stiction then equals Coulomb friction."""

    # inertia, kg m^2; Coulomb friction and stiction, N m; viscous coefficient, N m s/rad
    inertia: NonNegative = 0.0
    coulomb: NonNegative = 0.0
    stiction: NonNegative | None = None
    viscous: NonNegative = 0.0
    # friction lag, s; Stribeck velocity, rad/s, and shape
    friction_lag: NonNegative = 0.0
    stribeck_velocity: Positive = 1.0
    stribeck_shape: Positive = 1.0

    @property
    def model(self) -> TorqueModel:
        """The model that is fed forward."""
        stiction = self.coulomb if self.stiction is None else self.stiction
        return TorqueModel(**{**self.model_dump(), "stiction": stiction})


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


class Sweep(StrictTable):
    """Ranges that ``adaptive-ff sweep`` draws joints from, each ``[lowest, highest]``."""

    # factors on the scenario's values, drawn evenly on a logarithmic scale
    inertia: PositiveRange = [0.1, 10.0]
    coulomb: PositiveRange = [0.1, 10.0]
    viscous: PositiveRange = [0.1, 10.0]
    stiction: RatioRange = [1.0, 2.0]  # stiction as a multiple of the drawn Coulomb friction, drawn evenly
    # friction lag (s) and noise (rad/s), drawn evenly
    friction_lag: Range = [0.0, 0.05]
    velocity_noise: Range = [0.0, 0.005]
    # what the controllers assume, as a multiple of the truth, drawn evenly on a logarithmic scale
    assumed_stribeck_velocity: PositiveRange = [0.5, 2.0]
    assumed_inertia: PositiveRange = [0.7, 1.3]


class PositionControl(StrictTable):
    """A proportional position loop; with it every controller stands in a cascade."""

    gain: Positive | None = None  # position gain, 1/s; by default a sixth of the angular bandwidth of the velocity loop
    limit: Positive | None = None  # largest absolute correction, rad/s; by default there is none
    # step of the encoder of the position, rad; by default that of ``[sensor]``, and where that has none either, the
    # true position rounded to 1e-5 rad
    encoder_resolution: Positive | None = None

    def loop(self, bandwidth: Callable[[], float]) -> PositionLoopParameters:
        """Return the position loop; the bandwidth of the velocity loop, Hz, is asked for where no gain is given."""
        gain = default_position_gain(bandwidth()) if self.gain is None else self.gain
        return PositionLoopParameters(gain, math.inf if self.limit is None else self.limit)
