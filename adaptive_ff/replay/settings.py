"""Settings of a replayed controller: the numbers that its designer would have typed in on the machine.

The arguments of :func:`adaptive_ff.replay.replay.replay_log` and the saved state are read from the fields of
:class:`ReplaySettings`; a test compares them with the options of the command line.
"""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from numbers import Real
from typing import Any, Self

from adaptive_ff.adaptive.adaptive_state import AdaptiveParameters
from adaptive_ff.adaptive.controller import UnsupervisedController
from adaptive_ff.adaptive.learning.estimator_state import LAG_PRIOR
from adaptive_ff.adaptive.learning.map_settings import checked_periods
from adaptive_ff.errors import InputError
from adaptive_ff.friction.bounds import FRICTION_LAG
from adaptive_ff.friction.model import IDENTIFIED
from controllers import difference_velocity, direct_velocity, low_pass_velocity, pi_gains

HOLD = 0.75
"""Hold of the gate, in time constants of the filters. It was found on the records at hand and on drawn logs (seeds from
101 on): with 3, as in a loop, lags stay near the first guess. Where a joint sticks for a tenth of the time, inertia and
friction then are up to 1.2 % off."""

NYQUIST = 0.5
"""Largest corner of a loop or a filter, over the sampling frequency."""

FARTHEST = 0.5
"""Longest time that the motion may be ahead of the reference, or behind it, s."""

SAME_PERIOD = 0.01
"""Relative difference of sample times up to which a saved state belongs to a log."""


@dataclass(frozen=True)
class ReplaySettings:
    """Assumptions of the adaptive controller before the log begins; rad and N m, or m and N.

    Attributes
    ----------
    period : float
        Sample time, s.
    inertia : float
        Inertia that the loop is designed for, kg m^2.
    stribeck_velocity : float
        Stribeck velocity, rad/s.
    loop_bandwidth : float
        Crossover of the loop, Hz. The loop's torque goes nowhere, but its gain gives the estimator its scales, the
        pole of its filters and the first guess of the friction lag.
    rest_speed : float
        A reference that slows down counts as standstill below this speed, rad/s. A machine that should stand may push
        either way; the sign of what is left of the reference there says nothing. See ``replay.parts.with_rest``.
    start_path : float
        A slower reference that speeds up counts as motion once it has gone this far in one direction, rad: what the
        sensor of the joint could not see is none.
    memory : float
        Memory of the estimator, s of sliding motion.
    identify : str
        What is identified: a key of ``IDENTIFIED``.
    torque_delay : float
        Time after its stamp at which a torque acts, s: zero for a torque that was measured at its stamp, half a sample
        time for a command that is held until the next.
    velocity_cutoff : float or None
        Corner of the low-pass behind the difference of positions, Hz; None for the difference alone.
    velocity_lag : float
        Time by which the velocity that comes of it lags, s: half a sample time for the difference alone.
    motion_lead : float
        Time by which the measured motion runs ahead of the recorded reference, s; negative where it follows with a
        delay. See ``replay.following``.
    ripple_periods : tuple of float
        Periods over the position of a torque whose sizes are identified, rad.
    """

    period: float
    inertia: float
    stribeck_velocity: float
    loop_bandwidth: float
    rest_speed: float
    start_path: float = 0.0
    memory: float = 5.0
    identify: str = "offset"
    torque_delay: float = 0.0
    velocity_cutoff: float | None = None
    velocity_lag: float = 0.0
    motion_lead: float = 0.0
    ripple_periods: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        for name, value in self.to_dict().items():
            check_setting(name, value)
        for name in ("period", "inertia", "stribeck_velocity", "memory"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise InputError(f"{name} = {value:g} is not allowed: it must be positive")
        for name in ("loop_bandwidth", "velocity_cutoff"):
            value = getattr(self, name)
            if value is not None and not 0.0 < value * self.period <= NYQUIST:
                most = f"half the sampling frequency, {NYQUIST / self.period:.4g} Hz"
                raise InputError(f"{name} = {value:g} Hz is not allowed: it must be positive and at most {most}")
        for name in ("rest_speed", "start_path", "velocity_lag"):
            value = getattr(self, name)
            if not 0.0 <= value < math.inf:
                raise InputError(f"{name} = {value:g} is not allowed: it must be zero or more")
        if not -0.5 * self.period <= self.torque_delay < math.inf:
            raise InputError(
                f"torque_delay = {self.torque_delay:g} s is not allowed: it must be at least minus half a sample time, "
                f"{-0.5 * self.period:g} s; the estimator would see the future"
            )
        if not abs(self.motion_lead) <= FARTHEST:
            allowed = f"it must be from {-FARTHEST:g} to {FARTHEST:g} s"
            raise InputError(f"motion_lead = {self.motion_lead:g} s is not allowed: {allowed}")
        if self.identify not in IDENTIFIED:
            raise InputError(f"identify = {self.identify!r} is not allowed: it must be one of {', '.join(IDENTIFIED)}")

    @property
    def gains(self) -> tuple[float, float]:
        """Gains of the loop, N m s/rad and N m/rad."""
        return pi_gains(self.inertia, self.loop_bandwidth)

    def controller(self) -> UnsupervisedController:
        """Return the controller, which knows nothing yet; one that cannot work with the settings is refused."""
        try:
            controller = UnsupervisedController(
                *self.gains,
                self.period,
                inertia=self.inertia,
                stribeck_velocity=self.stribeck_velocity,
                memory=self.memory,
                parameters=IDENTIFIED[self.identify],
                ripple_periods=self.ripple_periods,
                velocity_lag=self.velocity_lag,
                tunes_lag=False,
            )
        except ValueError as error:
            raise InputError(str(error)) from error
        controller.parameters = of_watcher(controller.parameters)
        controller.reset()
        # A joint much faster than its plan ever was counts as a fault. One that feels its way into its first motion is
        # faster than a plan that has hardly begun, but slower than this.
        state = controller.state
        levels = state.estimator.levels._replace(speed=self.stribeck_velocity)
        controller.state = state._replace(estimator=state.estimator._replace(levels=levels))
        return controller

    def observer(self, *, is_position: bool) -> Any:
        """Return what makes a velocity of the measurement, from the past alone."""
        if not is_position:
            return direct_velocity(self.period)
        if self.velocity_cutoff is None:
            return difference_velocity(self.period)
        return low_pass_velocity(self.velocity_cutoff, self.period)

    def to_dict(self) -> dict[str, Any]:
        """Return the settings by name."""
        return asdict(self)

    @classmethod
    def from_dict(cls, content: Mapping[str, Any]) -> Self:
        """Return settings from plain values by name.

        Raises
        ------
        InputError
            They are not all there, unknown, or out of range.
        """
        names = ["period", *GIVEN]
        if set(content) != set(names):
            raise InputError(f"the settings {', '.join(map(str, content))} are not allowed: they must be {names}")
        check_setting("ripple_periods", content["ripple_periods"])
        return cls(**{**content, "ripple_periods": tuple(content["ripple_periods"])})

    def check_fits(self, period: float, given: Mapping[str, Any]) -> None:
        """Refuse a log, or settings beside these, that a state saved with these does not belong to.

        Parameters
        ----------
        period : float
            Sample time of the log, s.
        given : mapping
            Settings by name; None where nothing is given.

        Raises
        ------
        InputError
            The sample time differs, or a setting given beside the saved ones does.
        """
        if abs(period - self.period) > SAME_PERIOD * self.period:
            raise InputError(
                f"the log has a sample time of {period:g} s; it must be {self.period:g} s, that of the saved state"
            )
        for name, value in given.items():
            kept = getattr(self, name)
            if value is not None and (tuple(value) if name == "ripple_periods" else value) != kept:
                raise InputError(f"{name} = {value} is not allowed beside a saved state: it was saved with {kept}")


def of_watcher(block: AdaptiveParameters) -> AdaptiveParameters:
    """Return the parameters of a controller that only watches, for which reversals are all that shows the lag.

    One that moves the joint tunes the lag by its tracking error, so its regression holds the first guess and leaves out
    what follows a reversal. Here the guess is as uncertain as every other parameter, and the gate opens sooner.

    Friction that rises from standstill on, as that of gears which saturates does, is taken for that at once.
    """
    deviation = block.estimator.deviation.copy()
    deviation[FRICTION_LAG] *= math.sqrt(LAG_PRIOR)
    return block._replace(
        hold=HOLD / block.estimator.form.pole, estimator=block.estimator._replace(deviation=deviation, rises=True)
    )


GIVEN = tuple(setting.name for setting in fields(ReplaySettings) if setting.name != "period")
"""Settings that a user may give; the sample time is the log's."""


def check_names(given: Mapping[str, Any]) -> None:
    """Refuse settings that there are not, and values that are none.

    Raises
    ------
    InputError
        A name is not known, or a value is no number (no text, where a text is asked for).
    """
    for name, value in given.items():
        if name not in GIVEN:
            raise InputError(f"{name} = {value!r} is no setting of a replay; allowed: {', '.join(GIVEN)}")
        if value is not None:
            check_setting(name, value)


def check_setting(name: str, value: Any) -> None:
    """Refuse a value of a setting that is no number, or no text.

    Raises
    ------
    InputError
        It is of another kind.
    """
    if name == "velocity_cutoff" and value is None:
        return
    if name == "ripple_periods":
        try:
            checked_periods(name, value)
        except (TypeError, ValueError) as error:
            raise InputError(str(error)) from error
        return
    is_text = name == "identify"
    if isinstance(value, bool) or not isinstance(value, str if is_text else Real):
        raise InputError(f"{name} = {value!r} is not allowed: it must be a {'text' if is_text else 'number'}")
