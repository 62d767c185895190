"""The content of a scenario: its tables, and what follows from them."""

import math
from functools import cached_property, lru_cache
from typing import Annotated, Any

import numpy as np
from pydantic import Field, TypeAdapter, field_validator, model_validator
from pydantic_core import PydanticCustomError

from adaptive_ff.errors import InputError
from adaptive_ff.scenario.axis_units import axis_unit
from adaptive_ff.scenario.plausibility import default_peak
from adaptive_ff.scenario.reference import SHORTEST, Motion, Multisine, Recorded
from adaptive_ff.scenario.series import size_and_lost_fraction
from adaptive_ff.scenario.tables import (
    Adaptation,
    Feedback,
    FixedModel,
    PositionControl,
    Sampling,
    Sweep,
    VelocityEstimate,
)
from adaptive_ff.scenario.waves import Fourier, PointToPoint, Staircase, Triangle
from controllers import PositionLoopParameters, direct_velocity
from controllers.arrays import NDArray
from plant import Actuator, AnyJoint, FrictionChange, FrictionSchedule, FrictionVariation, Sensor, schedule
from plant.fields import Positive, StrictTable

MAIN_JOB = ["pi", "fixed", "oracle", "adaptive_paper", "adaptive"]  # the controllers of the main job
LOST_BETWEEN_SAMPLES = 0.2  # largest part of the reference (rms) that may be lost between the samples of the controller

Reference = Annotated[Multisine | Recorded | PointToPoint | Triangle | Staircase | Fourier, Field(discriminator="kind")]
REFERENCE: TypeAdapter[Any] = TypeAdapter(Reference)


@lru_cache(maxsize=8)
def measured_motion(
    reference: str, seed: int, solver_period: float, length: float, sampling: Sampling
) -> tuple[NDArray[np.float64], float, float]:
    """Return a reference (JSON) on the solver's grid, read-only, its rms, and the fraction lost between samples.

    A sweep, a matrix and a comparison ask for it several times: where the scenario is checked, where the drive is
    sized, where a run begins. Who hands it to compiled code takes a copy, for a read-only array is another type there.
    """
    steps = sampling.steps(length, solver_period)
    time = np.arange(steps[-1] + 1, dtype=float) * solver_period
    with np.errstate(over="ignore", invalid="ignore"):
        motion = REFERENCE.validate_json(reference).velocity(time, np.random.default_rng([seed, 0]))
    motion.flags.writeable = False
    return motion, *size_and_lost_fraction(motion, steps)


class Content(StrictTable):
    """Tables of a scenario, each valid by itself."""

    duration: Positive | None = None  # length of the run, s; by default 60, and no shorter than a recorded reference
    seed: Annotated[int, Field(ge=0, lt=2**63)] = 1  # seed of the reference's phases, the noise and the jitter
    # what is compared, every name once; by default the controllers of the main job
    controllers: list[str] = Field(default=MAIN_JOB, min_length=1)
    joint: AnyJoint  # what is simulated: inertia, friction, and the period of the solver
    # period and jitter; noise or encoder; how a velocity is made of encoder positions
    sampling: Sampling = Sampling()
    sensor: Sensor = Sensor()
    velocity: VelocityEstimate = VelocityEstimate()
    actuator: Actuator = Actuator()  # limits, delay, lag and ripple of the drive
    reference: Reference = Multisine()  # the planned motion
    position: PositionControl | None = None  # a position loop around every controller; none by default
    feedback: Feedback  # the PI loop: the inertia that it is designed for, and its bandwidth or its gains
    adaptation: Adaptation  # what identifying controllers assume
    fixed: FixedModel = FixedModel()  # the feedforward of the controller ``fixed``
    # what changes on the way, at once or slowly
    change: list[FrictionChange] = []
    variation: FrictionVariation = FrictionVariation()
    sweep: Sweep = Sweep()  # ranges of ``adaptive-ff sweep``

    @model_validator(mode="before")
    @classmethod
    def _choose_kind(cls, content: Any) -> Any:
        """Take a reference without a kind for a recorded one where it has a path, else for a multisine."""
        reference = content.get("reference") if isinstance(content, dict) else None
        if not isinstance(reference, dict) or "kind" in reference:
            return content
        return {**content, "reference": {"kind": "csv" if "path" in reference else "multisine", **reference}}

    @field_validator("controllers")
    @classmethod
    def _check_controllers(cls, names: list[str]) -> list[str]:
        if len(set(names)) < len(names):
            raise PydanticCustomError("controllers", "it must have every name once")
        return names

    @cached_property
    def name(self) -> str:
        """Where it comes from, for pictures and messages: its file, or what it was derived from."""
        return "scenario"

    @cached_property
    def motion(self) -> Motion | None:
        """The recorded motion, read once; None for a multisine."""
        return self.reference.read() if isinstance(self.reference, Recorded) else None

    @cached_property
    def length(self) -> float:
        """Duration of the run, s."""
        if self.duration is not None:
            return self.duration
        return SHORTEST if self.motion is None else max(SHORTEST, self.motion.duration)

    @property
    def plan(self) -> FrictionSchedule:
        """How the friction of the joint changes."""
        return schedule(self.change, self.joint.solver_period, self.variation)

    @property
    def last_change(self) -> float:
        """Time of the last change of friction, s; zero without one."""
        return self.change[-1].time if self.change else 0.0

    @property
    def substeps(self) -> int:
        """Solver periods in a sampling period."""
        return round(self.sampling.period / self.joint.solver_period)

    @property
    def sample_steps(self) -> NDArray[np.int64]:
        """Solver steps of the samples and of the end, shape (samples + 1,)."""
        return self.sampling.steps(self.length, self.joint.solver_period)

    @property
    def samples(self) -> int:
        """Number of samples of the controller in a run."""
        return self.sample_steps.size - 1

    @property
    def delay(self) -> float:
        """Computation delay, periods."""
        return self.actuator.delay / self.sampling.period

    @property
    def assumed_delay(self) -> float:
        """Computation delay that the controllers reckon with, periods."""
        return self.delay if self.feedback.delay is None else self.feedback.delay / self.sampling.period

    def times(self) -> NDArray[np.float64]:
        """Return the solver's grid, s, shape (steps + 1,)."""
        return np.arange(self.sample_steps[-1] + 1, dtype=float) * self.joint.solver_period

    @property
    def velocity_estimator(self) -> Any:
        """What makes a velocity of the measurement."""
        resolution, period = self.sensor.encoder_resolution, self.sampling.period
        return direct_velocity(period) if resolution is None else self.velocity.estimator(resolution, period)

    @property
    def velocity_lag(self) -> float:
        """Time by which the velocity that the controllers see lags behind the joint's, s."""
        return 0.0 if self.sensor.encoder_resolution is None else self.velocity.lag(self.sampling.period)

    @property
    def friction_periods(self) -> list[float]:
        """Periods of friction over position given to the adaptive controller, rad."""
        turn = [] if self.joint.gear_ratio is None else [2.0 * math.pi / self.joint.gear_ratio]
        return [*self.adaptation.position_periods, *(turn if self.adaptation.motor_turn else [])]

    @property
    def position_loop(self) -> PositionLoopParameters | None:
        """The position loop around every controller; None where there is none."""
        if self.position is None:
            return None
        return self.position.loop(lambda: self.feedback.gains[0] / (2.0 * math.pi * self.feedback.inertia))

    @property
    def position_resolution(self) -> float | None:
        """Step of the encoder that measures the position, rad; None where there is none."""
        own = None if self.position is None else self.position.encoder_resolution
        return self.sensor.encoder_resolution if own is None else own

    @property
    def velocity_noise(self) -> float:
        """Noise of the velocity that the controllers see, rad/s (standard deviation)."""
        resolution = self.sensor.encoder_resolution
        if resolution is None:
            return self.sensor.velocity_noise
        return self.velocity.noise(resolution, self.sampling.period)

    def reference_velocity(self) -> NDArray[np.float64]:
        """Return the reference on the solver's grid, rad/s.

        Raises
        ------
        InputError
            The reference changes faster than the controller samples.
        """
        unit, factor = self._checked_motion()
        with np.errstate(over="ignore", invalid="ignore"):
            return unit * factor

    def check_reference(self) -> None:
        """Raise where :meth:`reference_velocity` does, without a copy of the reference."""
        self._checked_motion()

    def _checked_motion(self) -> tuple[NDArray[np.float64], float]:
        """Return the reference before its peak is chosen where none is given, read-only, and its factor."""
        unit, size, lost = self._unit_motion()
        factor = 1.0
        if isinstance(self.reference, Multisine) and self.reference.peak is None:
            with np.errstate(over="ignore", invalid="ignore"):
                factor = default_peak(self.joint, self.actuator.torque_limit, unit, self.joint.solver_period)
                size *= factor
        if not math.isfinite(size):
            raise InputError("reference: its velocity does not stay finite; its values must be smaller")
        if lost > LOST_BETWEEN_SAMPLES and self.samples > 1:
            raise InputError(
                f"reference: {lost * size:.3g} of {size:.3g} {axis_unit(self.joint.axis, 'rad/s')} (rms) lie between "
                f"the samples; the reference must be slow against sampling.period = {self.sampling.period:g} s"
            )
        return unit, factor

    def _unit_motion(self) -> tuple[NDArray[np.float64], float, float]:
        """Return the reference before its peak is chosen, its size (rms), and the fraction lost between samples."""
        if self.motion is not None:  # its file may change from one reading to the next
            unit = self.motion.velocity(self.times(), axis_unit(self.joint.axis, "rad/s"))
            return unit, *size_and_lost_fraction(unit, self.sample_steps)
        seed = self.seed if isinstance(self.reference, Multisine) else 0  # nothing else is drawn
        text = self.reference.model_dump_json()
        return measured_motion(text, seed, self.joint.solver_period, self.length, self.sampling)

    def noise(self) -> NDArray[np.float64]:
        """Return the noise of the velocity at each sample, rad/s, shape (samples,)."""
        return self.sensed()[0]

    def sensed(self, generator: np.random.Generator | None = None) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        """Return the noise, and at which samples the sensor gives its last value once more, shape (samples,) each.

        They are drawn with a generator, by default that of the scenario's seed.
        """
        drawn = np.random.default_rng([self.seed, 1]) if generator is None else generator
        return self.sensor.draw(self.samples, drawn), self.sensor.draw_held(self.samples, drawn)
