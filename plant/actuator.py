"""The drive between the commanded torque and the torque at the joint.

A command is limited in slope and size and rounded to the drive's resolution: that is the torque that the drive gives
and reports. It acts from the computation delay on until the next one does, through the lag of the current loop where
there is one; then the torque that the current makes is reported, as a mean over the period. Ripple comes on top of it
at the joint, and a torque constant that is off is a factor on it there; neither is reported, because a drive measures
its current.
"""

import math
from typing import NamedTuple, Self

from pydantic import StrictBool, model_validator

from plant.fields import NonNegative, Positive, Table


class ActuatorParameters(NamedTuple):
    """What the drive's kernels need to know."""

    torque_limit: float  # largest torque either way, N m; infinite where there is none
    torque_resolution: float  # step of the torque, N m; zero where it is continuous
    rate_limit: float  # largest change of the torque, N m/s; infinite where there is none
    ripple_amplitude: float  # amplitude of the torque ripple, N m
    ripple_waves: float  # ripple periods in a radian, times ``2 pi``
    lag: float  # time constant of the current loop, s; zero where the torque follows at once
    gain: float  # torque at the joint over the reported one
    reports: bool  # whether the torque that the drive gives is reported


def realise_torque(actuator: ActuatorParameters, command: float, previous: float, duration: float) -> float:
    """Return the torque that the drive gives for a command.

    Parameters
    ----------
    actuator : ActuatorParameters
        The drive.
    command : float
        Commanded torque, N m.
    previous : float
        Torque that it gave for the last command, N m.
    duration : float
        Time since that one, s.

    Returns
    -------
    float
        Torque, N m. Rounding never leads beyond the limit.
    """
    torque = command
    if actuator.rate_limit < math.inf:
        reach = actuator.rate_limit * duration
        torque = min(max(torque, previous - reach), previous + reach)
    limit = actuator.torque_limit
    if actuator.torque_resolution > 0.0:
        torque = actuator.torque_resolution * math.floor(torque / actuator.torque_resolution + 0.5)
        if limit < math.inf:
            limit = actuator.torque_resolution * math.floor(limit / actuator.torque_resolution)
    return min(max(torque, -limit), limit)


def ripple_torque(actuator: ActuatorParameters, position: float) -> float:
    """Return the torque ripple (N m) at a position (rad) of the motor."""
    return actuator.ripple_amplitude * math.sin(actuator.ripple_waves * position)


def lagged_torque(actuator: ActuatorParameters, torque: float, lagging: float, period: float) -> tuple[float, float]:
    """Return the torque (N m) that the current makes, ``lag dT/dt + T = torque``: its mean over a period, and its end.

    Exact for a torque that is held over the period.

    Parameters
    ----------
    actuator : ActuatorParameters
        The drive.
    torque : float
        Torque that acts on the current loop, N m.
    lagging : float
        Torque of the current at the start of the period, N m.
    period : float
        Length of the period, s.
    """
    if actuator.lag == 0.0:
        return torque, torque
    gone = -math.expm1(-period / actuator.lag)
    return torque + (lagging - torque) * gone * actuator.lag / period, torque + (lagging - torque) * (1.0 - gone)


class Actuator(Table):
    """A drive."""

    torque_limit: Positive | None = None  # largest torque either way, N m; none by default
    torque_resolution: NonNegative = 0.0  # step of the torque, N m, at most the limit; continuous by default
    rate_limit: Positive | None = None  # largest change of the torque in a second, N m/s; none by default
    ripple_amplitude: NonNegative = 0.0  # amplitude of the torque ripple, N m
    ripple_period: Positive = 0.1  # motion between two crests of the ripple, rad
    delay: NonNegative = 0.0  # time between a sample and the moment from which its command acts, s
    lag: NonNegative = 0.0  # time constant of the current loop, s
    # true torque constant over the one that commands and reports reckon with; the controllers do not know it
    gain: Positive = 1.0
    # whether the controllers are given the torque that the drive gives, as they are by default; otherwise they know
    # only what they asked for
    reports_torque: StrictBool = True

    @model_validator(mode="after")
    def _check_resolution(self) -> Self:
        if self.torque_limit is not None and self.torque_resolution > self.torque_limit:
            raise ValueError(
                f"torque_resolution = {self.torque_resolution:g} is not allowed: it must be at most "
                f"torque_limit = {self.torque_limit:g}"
            )
        return self

    @property
    def parameters(self) -> ActuatorParameters:
        """The drive as its kernels take it."""
        return ActuatorParameters(
            torque_limit=math.inf if self.torque_limit is None else self.torque_limit,
            torque_resolution=self.torque_resolution,
            rate_limit=math.inf if self.rate_limit is None else self.rate_limit,
            ripple_amplitude=self.ripple_amplitude,
            ripple_waves=2.0 * math.pi / self.ripple_period,
            lag=self.lag,
            gain=self.gain,
            reports=self.reports_torque,
        )
