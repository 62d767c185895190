"""Settings of a replayed controller that are not given: from the log, which on the machine was to come."""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

from adaptive_ff.adaptive.settings import GATE_SHARE
from adaptive_ff.errors import InputError
from adaptive_ff.friction.model import TorqueModel
from adaptive_ff.logs.bandwidth import motion_noise
from adaptive_ff.logs.defects import Piece
from adaptive_ff.logs.log import Log
from adaptive_ff.replay.fixed import MOST
from adaptive_ff.replay.following import motion_lead
from adaptive_ff.replay.further_torque import FurtherTorque
from adaptive_ff.replay.parts import has_reference
from adaptive_ff.replay.settings import ReplaySettings
from controllers import low_pass_lag

LOOP, LOOP_PERIODS = 10.0, 0.1
"""Crossover of the loop that is assumed, Hz, and the most that it may be times the sample time."""

SLOW = 0.05
"""Assumed Stribeck velocity where none is given, over the largest speed of the reference."""

RESTING = 0.005
"""Speed up to which the reference counts as resting where none is given, over its largest."""

FROM_LOG = (
    "inertia",
    "stribeck_velocity",
    "rest_speed",
    "start_path",
    "velocity_cutoff",
    "velocity_lag",
    "motion_lead",
)
"""Settings that are taken from the log where they are not given."""


class Recorded(NamedTuple):
    """A log, its pieces without defect, its sample time (s), and the band (Hz) and largest speed of its reference."""

    log: Log
    pieces: list[Piece]
    period: float
    band: float
    largest: float

    def noise(self) -> float:
        """Return the standard deviation of the noise of the measured motion, rad or rad/s."""
        longest = max(self.pieces, key=lambda piece: piece.size)
        motion = self.log.motion[longest.start : min(longest.stop, longest.start + MOST)]
        return math.sqrt(motion_noise(motion, self.period, is_position=self.log.position is not None))


def usual_settings(
    recorded: Recorded, given: Mapping[str, Any], model: TorqueModel | None, further: FurtherTorque, note: str
) -> ReplaySettings:
    """Return the settings of a replay: what is given, and for the rest what the log says.

    Inertia, and the Stribeck velocity if it has one, are those of the fixed model; else the latter is 0.05 times the
    largest speed of the reference. The reference is taken when the joint followed it, see ``motion_lead``; it rests
    below 0.005 times its largest speed, and starts at a path of the noise of the measured position (of a velocity: its
    noise over a sample time). Differences of a coarse position pass a low-pass, see ``quiet_cutoff``. The loop has
    10 Hz, or a tenth of the sampling frequency. Periods of ripples are those of the fixed model.

    Parameters
    ----------
    recorded : Recorded
        The log.
    given : mapping
        Settings by name; None where nothing is given.
    model : TorqueModel or None
        The fixed model.
    further : FurtherTorque
        Its further terms.
    note : str
        What is to be known of it.

    Raises
    ------
    InputError
        Reference or joint stands still, the inertia is not known, or a setting is out of range.
    """
    log, period, largest = recorded.log, recorded.period, recorded.largest
    if largest == 0.0:
        what = "reference" if has_reference(log) else "joint"
        raise InputError(f"{log.name}: the {what} stands still; it must move")
    noise, is_position = recorded.noise(), log.position is not None
    usual: dict[str, Any] = {
        "inertia": 0.0 if model is None else model.inertia,
        "stribeck_velocity": SLOW * largest,
        "loop_bandwidth": min(LOOP, LOOP_PERIODS / period),
        "rest_speed": RESTING * largest,
        "start_path": noise if is_position else noise * period,
        "ripple_periods": tuple(one.period for one in further.ripples) if is_position else (),
    }
    if given.get("motion_lead") is None:
        usual["motion_lead"] = motion_lead(log, recorded.pieces, period, recorded.band)
    if model is not None and model.stiction > model.coulomb:
        usual["stribeck_velocity"] = model.stribeck_velocity
    chosen = {**usual, **{name: value for name, value in given.items() if value is not None}}
    if chosen["inertia"] <= 0.0 and given.get("inertia") is None:
        raise InputError(f"{log.name}: inertia must be given, the first half of the log does not determine it. {note}")
    settings = ReplaySettings(period=period, **chosen)
    if not is_position:
        return settings
    cutoff = settings.velocity_cutoff
    if cutoff is None:
        cutoff = quiet_cutoff(noise, GATE_SHARE * settings.stribeck_velocity, period, settings.loop_bandwidth)
    lag = chosen.get("velocity_lag", 0.5 * period if cutoff is None else low_pass_lag(cutoff, period))
    return replace(settings, velocity_cutoff=cutoff, velocity_lag=lag)


def quiet_cutoff(noise: float, speed: float, period: float, lowest: float) -> float | None:
    """Return the corner (Hz) of a low-pass behind differences of a noisy position; None where none is needed.

    The noise of the velocity then is at most as large as a speed, below which the joint may stick: louder noise would
    pass for motion, and draw the lag that is identified towards zero.

    Parameters
    ----------
    noise : float
        Standard deviation of the noise of the position, rad.
    speed : float
        Largest standard deviation of the noise of the velocity, rad/s.
    period : float
        Sample time, s.
    lowest : float
        Lowest corner, Hz: that of the loop, which could not follow a slower velocity.
    """
    if math.sqrt(2.0) * noise <= speed * period:
        return None
    return max(speed / (2.0 * math.pi * noise), lowest)
