"""The tables of a scenario file beside the simulated joint: sampling, what controllers assume, draws."""

import math
from collections.abc import Callable
from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import (
    AfterValidator,
    ConfigDict,
    Discriminator,
    Field,
    Tag,
    field_validator,
    model_validator,
)
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
from controllers.plausibility import LARGEST_OBSERVED
from plant.fields import Finite, NonNegative, Positive, Table

STRICT = ConfigDict(frozen=True, extra="forbid", strict=True)

MOST_PERIODS, MOST_HATS = 7, 100
"""Most known periods of friction over position, and most hats of a map of it."""


LATE = {9: 0.5, 19: 1.0, 29: 0.5}
"""Samples of a cycle that come late when sampling jitters, and by which fraction of the jitter."""

CYCLE = 40
"""Samples of such a cycle."""


class Sampling(Table):
    """When the controller runs.

    Parameters
    ----------
    period : float
        Mean sampling period, s, a whole number of solver periods.
    jitter : float, optional
        Outliers of the sampling time as the paper's Fig. 10 shows them, as a fraction of the period: of 40 intervals
        one is longer by this fraction and two by half of it, the others are shorter. 0.9 is like the figure.
    """

    model_config = STRICT
    period: Positive = 0.01
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


class VelocityEstimate(Table):
    """How the robot makes a velocity of an encoder's positions.

    Parameters
    ----------
    method : "difference", "low_pass" or "kalman", optional
        Difference of two readings, the same behind a low-pass of first order, or a Kalman filter.
    cutoff : float, optional
        Corner of the low-pass, Hz.
    acceleration_walk : float, optional
        Random walk of the acceleration that the Kalman filter expects, rad/s^2 in a root of a second.
    """

    model_config = STRICT
    method: Literal["difference", "low_pass", "kalman"] = "low_pass"
    cutoff: Positive = 50.0
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
        difference = resolution / (period * math.sqrt(6.0))
        if self.method == "low_pass":
            smoothing = 1.0 - math.exp(-2.0 * math.pi * self.cutoff * period)
            return difference * smoothing / math.sqrt(2.0 - smoothing)
        return difference


def _kind_of_bandwidth(value: Any) -> str:
    return AUTO if value == AUTO else "hertz"


AUTO = "auto"
"""In the place of a bandwidth: for each controller the one at which it does best."""

Bandwidth = Annotated[
    Annotated[Positive, Tag("hertz")] | Annotated[Literal["auto"], Tag(AUTO)], Discriminator(_kind_of_bandwidth)
]


class Feedback(Table):
    """What the designer of the PI loop assumes.

    Parameters
    ----------
    inertia : float
        Assumed inertia, kg m^2.
    bandwidth : float or "auto", optional
        Open-loop crossover, Hz; checked against the largest one that a maximum sensitivity of 1.7 allows; where the
        velocity filter takes more, a warning says so. ``auto``: for each controller the one that suits tracking and a
        step of the load, on seeds of its own (``adaptive-ff tune`` shows how).
    proportional, integral : float, optional
        Gains given directly instead, N m s/rad and N m/rad; not checked.
    delay : float, optional
        Assumed computation delay of the drive, s; by default the true one of ``[actuator]``. All controllers but the
        oracle reckon with it.
    """

    model_config = STRICT
    inertia: Positive
    bandwidth: Bandwidth | None = None
    proportional: Positive | None = None
    integral: NonNegative | None = None
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


class Adaptation(Table):
    """What the adaptive controllers assume of the joint: prior knowledge that may be wrong.

    Parameters
    ----------
    stribeck_velocity, stribeck_shape : float
        Pre-estimated ``Vs`` (rad/s) and ``delta``.
    memory : float, optional
        Memory, s of sliding motion; by default what suits each controller.
    identify : "symmetric", "offset" or "directions", optional
        What ``adaptive`` identifies: the paper's five parameters; an offset beside them; friction by direction, too. By
        default an offset and, where a position is given, gravity.
    ripple_periods : list of float, optional
        Known periods of a torque over position, such as cogging, rad: the adaptive controllers learn a sine and a
        cosine of each.
    position_periods : list of float, optional
        Known periods of friction over position, rad: ``adaptive`` learns a cosine and a sine of each.
    motor_turn : bool, optional
        Whether a turn of the motor is one of them, ``2 pi / joint.gear_ratio``.
    position_hats : int, optional
        Number of the hats of a piecewise linear map of friction over position, without a known period; 2 or more.
    position_range : list of float, optional
        Positions of the first and of the last hat, rad; a turn about zero by default.
    load_friction : bool, optional
        Whether friction may rise with the torque that the joint is known to transmit: identified gravity here.
    friction_share : float, optional
        What of the identified friction ``adaptive`` feeds, from 0 to 1.
    """

    model_config = STRICT
    stribeck_velocity: Positive
    stribeck_shape: Positive = 1.0
    memory: Positive | None = None
    identify: Literal["symmetric", "offset", "directions", "gravity", "directions_and_gravity"] | None = None
    ripple_periods: Annotated[list[Positive], Field(max_length=MOST_PERIODS)] = []
    position_periods: Annotated[list[Positive], Field(max_length=MOST_PERIODS)] = []
    motor_turn: bool = False
    position_hats: Annotated[int, Field(ge=0, le=MOST_HATS)] = 0
    position_range: Annotated[list[Finite], Field(min_length=2, max_length=2)] | None = None
    load_friction: bool = False
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


class FixedModel(Table):
    """Parameters of the controller ``fixed``; what is not given is zero, stiction then equals Coulomb friction.

    Parameters
    ----------
    inertia, coulomb, stiction, viscous : float, optional
        Inertia, kg m^2; Coulomb friction and stiction, N m; viscous coefficient, N m s/rad.
    friction_lag, stribeck_velocity, stribeck_shape : float, optional
        Friction lag, s; Stribeck velocity, rad/s, and shape.
    """

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


class Sweep(Table):
    """Ranges that ``adaptive-ff sweep`` draws joints from, each ``[lowest, highest]``.

    Parameters
    ----------
    inertia, coulomb, viscous : list of float
        Factors on the scenario's values, drawn evenly on a logarithmic scale.
    stiction : list of float
        Stiction as a multiple of the drawn Coulomb friction, drawn evenly.
    friction_lag, velocity_noise : list of float
        Friction lag (s) and noise (rad/s), drawn evenly.
    assumed_stribeck_velocity, assumed_inertia : list of float
        What the controllers assume, as a multiple of the truth, drawn evenly on a logarithmic scale.
    """

    model_config = STRICT
    inertia: PositiveRange = [0.1, 10.0]
    coulomb: PositiveRange = [0.1, 10.0]
    viscous: PositiveRange = [0.1, 10.0]
    stiction: RatioRange = [1.0, 2.0]
    friction_lag: Range = [0.0, 0.05]
    velocity_noise: Range = [0.0, 0.005]
    assumed_stribeck_velocity: PositiveRange = [0.5, 2.0]
    assumed_inertia: PositiveRange = [0.7, 1.3]


class PositionControl(Table):
    """A proportional position loop; with it every controller stands in a cascade.

    Parameters
    ----------
    gain : float, optional
        Position gain, 1/s; by default a sixth of the angular bandwidth of the velocity loop.
    limit : float, optional
        Largest absolute correction, rad/s; by default there is none.
    encoder_resolution : float, optional
        Step of the encoder of the position, rad; by default that of ``[sensor]``, and where that has none either, the
        true position rounded to 1e-5 rad.
    """

    model_config = STRICT
    gain: Positive | None = None
    limit: Positive | None = None
    encoder_resolution: Positive | None = None

    def loop(self, bandwidth: Callable[[], float]) -> PositionLoopParameters:
        """Return the position loop; the bandwidth of the velocity loop, Hz, is asked for where no gain is given."""
        gain = default_position_gain(bandwidth()) if self.gain is None else self.gain
        return PositionLoopParameters(gain, math.inf if self.limit is None else self.limit)
