"""Replay of a log: what the adaptive feedforward would have learnt and fed forward on the machine, sample by sample."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from adaptive_ff.adaptive.controller import UnsupervisedController
from adaptive_ff.baselines.model_based import ModelBased
from adaptive_ff.errors import InputError, counted, sentence
from adaptive_ff.friction.identifying import has_gravity
from adaptive_ff.friction.model import IDENTIFIED, TorqueModel
from adaptive_ff.identify.identification import check_delay
from adaptive_ff.logs.bandwidth import check_bandwidth
from adaptive_ff.logs.defects import median_step, usable_pieces
from adaptive_ff.logs.log import Log, check_log
from adaptive_ff.logs.missing_values import lacking_column
from adaptive_ff.logs.sanity import look_through
from adaptive_ff.replay.defaults import FROM_LOG, Recorded, usual_settings
from adaptive_ff.replay.fixed import fit_fixed
from adaptive_ff.replay.following import SAMPLES, as_followed, doubts, motion_lead
from adaptive_ff.replay.further_torque import FurtherTorque
from adaptive_ff.replay.judging import Left
from adaptive_ff.replay.parts import (
    PART,
    REFERENCE_POSITION,
    REFERENCE_VELOCITY,
    Part,
    has_reference,
    largest_reference,
    split_log,
)
from adaptive_ff.replay.result import COLD, FIXED, NONE, SAVED, Replay
from adaptive_ff.replay.runs import Runner, Tape
from adaptive_ff.replay.settings import ReplaySettings, check_names
from adaptive_ff.replay.state import carry_over, state_from_json
from controllers import Controller

BAND = 20.0
"""Band in which the torque left is judged, Hz."""

SHORTEST_PERIOD = 1e-30
"""Least sample time that can be reckoned with, s."""

SHORTEST = 10
"""Samples that a piece must have."""


def replay_log(
    log: Log,
    *,
    fixed: TorqueModel | None = None,
    bandwidth: float | None = None,
    band: float = BAND,
    state: str | None = None,
    linear: bool = False,
    is_current: bool = False,
    part: int = PART,
    progress: Callable[[float], None] | None = None,
    **given: Any,
) -> Replay:
    """Replay a log.

    The adaptive controller sees, sample by sample, what it would have seen on the machine: the reference and
    its next value, the measured velocity, and the torque that the drive gave. The torque of its own loop goes nowhere.
    What it would have fed forward over the period that begins with the sample is compared with the torque of the log
    over that period. Where the log has a defect, estimates are kept, and filters start anew behind it.

    Parameters
    ----------
    log : Log
        The log, see :func:`adaptive_ff.logs.log.read_log`. In ``Log.extra`` it may have ``reference_velocity`` (rad/s)
        or ``reference_position`` (rad), and ``feedforward`` (N m), the machine's own, with the stamps of the torque.
        Without a reference the measured motion, filtered without delay, stands for it. A reference is taken when the
        joint followed it, see :mod:`adaptive_ff.replay.following`.
    fixed : TorqueModel, optional
        The fixed model; by default the batch identification of the first half of the log.
    bandwidth : float, optional
        Band of that identification, Hz; chosen from the motion by default.
    band : float, optional
        Band in which is judged, Hz: a filter without delay, for judging only; infinite for none.
    state : str, optional
        A state saved by :meth:`Replay.state_to_json`: the adaptive feedforward runs from it, too. Settings are then
        those saved with it. What it knows of the inertia counts for little, as the posture may be another one.
    linear : bool, optional
        Whether the joint is a linear axis, in m and N.
    is_current : bool, optional
        Whether the torque of the log is a current, in A: estimates are then in A as well, as inertia in A s^2/rad (of
        a linear axis A s^2/m).
    part : int, optional
        Samples that are worked on at once; the result does not depend on it.
    progress : callable, optional
        Is called with the share done, from 0 to 1.
    **given : optional
        Fields of :class:`ReplaySettings` but for the period, by name; for what is used where nothing is given see
        :func:`adaptive_ff.replay.defaults.usual_settings`.

    Returns
    -------
    Replay
        The torque that each feedforward leaves, and their series.

    Raises
    ------
    InputError
        The log cannot be used, or an argument is out of range.
    """
    check_log("log", log)
    check_names(given)
    _check_arguments(log, band, given.get("motion_lead"))
    if log.time.size < SHORTEST:
        few = counted(log.time.size, "sample")
        raise InputError(f"{log.name}: the log has {few}; there must be at least {SHORTEST}")
    given_log = log
    log, said, jumps = look_through(given_log, linear=linear)
    pieces, skipped = usable_pieces(log, SHORTEST, jumps)
    if not pieces:
        raise InputError(f"{log.name}: no piece of {SHORTEST} samples is without defect{lacking_column(given_log)}")
    period = _sample_time(log)
    _check_bands(band, bandwidth, period, log.time.size)
    check_delay(given.get("torque_delay") or 0.0)
    saved = None
    if state is not None:
        settings, saved = state_from_json(state)
        settings.check_fits(period, given)
        carry_over(saved)
        delay = settings.torque_delay
    else:
        delay = given.get("torque_delay") or 0.0
    if fixed is None:
        model, further, note = fit_fixed(log, bandwidth, delay, linear=linear)
    else:
        model, further, note = fixed, FurtherTorque(), "The fixed model is given."
    judged = band if 2.0 * band * period < 1.0 else None
    reference_band = min(band, 0.4 / period)
    if saved is None:
        largest = largest_reference(log, pieces, period, reference_band)
        settings = usual_settings(Recorded(log, pieces, period, reference_band, largest), given, model, further, note)
    _check_position(log, settings)
    notes = [
        note,
        *(sentence(words) for words in said),
        *_notes(log, settings, given if saved is None else None, judged, reference_band),
    ]
    if saved is not None and has_reference(log):
        notes += _other_lead(settings, motion_lead(log, pieces, period, reference_band))
    runners = _runners(settings, model, saved, log.position is not None)
    if FIXED in runners:
        runners[FIXED].further = further
    log = as_followed(log, pieces, settings.motion_lead)
    notes += doubts(log, pieces, period, reference_band, linear=linear)
    tape = Tape(log, runners, period, judged)
    used = sum(piece.size for piece in pieces)
    _run_tape(tape, split_log(log, pieces, settings, reference_band, part), used, progress)
    left = tape.judge.result()
    notes += worse_than_none(left)
    notes += gravity_left_out(settings, runners)
    return Replay(
        name=log.name,
        linear=linear,
        is_current=is_current,
        settings=settings,
        band=judged,
        samples=log.time.size,
        used=used,
        skipped=skipped,
        notes=notes,
        fixed=model,
        left=left,
        series=tape.series(),
        controllers=tape.adaptive(),
    )


def _check_position(log: Log, settings: ReplaySettings) -> None:
    """Raise ``InputError`` for what is identified over a position that the log has not."""
    if log.position is not None:
        return
    if has_gravity(IDENTIFIED[settings.identify]):
        raise InputError(f"identify = {settings.identify!r} is not allowed: {log.name} has no position")
    if settings.ripple_periods:
        raise InputError(f"ripple_periods = {settings.ripple_periods} is not allowed: {log.name} has no position")


def _sample_time(log: Log) -> float:
    """Return the sample time of a log, s, or raise ``InputError`` where nothing can be reckoned with it."""
    period = median_step(log)
    if not SHORTEST_PERIOD <= period <= 1.0 / SHORTEST_PERIOD:
        allowed = f"it must be from {SHORTEST_PERIOD:g} to {1.0 / SHORTEST_PERIOD:g}"
        raise InputError(f"{log.name}: the sample time is {period:.3g} s; {allowed}")
    return period


def _check_bands(band: float, bandwidth: float | None, period: float, samples: int) -> None:
    """Raise ``InputError`` for a band of which a log holds no cycle to judge, and for one that is none to fit in."""
    if band * period * samples < 1.0:
        least = f"it must be at least that of one cycle in the log, {1.0 / (period * samples):.3g} Hz"
        raise InputError(f"band = {band:g} Hz is not allowed: {least}")
    if bandwidth is not None:
        check_bandwidth(bandwidth, period)


def _run_tape(tape: Tape, parts: Iterable[Part], used: int, progress: Callable[[float], None] | None) -> None:
    """Run over all parts of a log, with so many samples together, and say which share of them is done."""
    done = 0
    for part in parts:
        tape.run(part)
        done += part.time.size
        if progress is not None:
            progress(done / used)


def gravity_left_out(settings: ReplaySettings, runners: Mapping[str, Runner]) -> list[str]:
    """Say that the adaptive feedforward does not identify the gravity that the fixed one has."""
    fixed = runners.get(FIXED)
    if fixed is None or not fixed.further.has_gravity or has_gravity(IDENTIFIED[settings.identify]):
        return []
    return ["The adaptive feedforward does not identify gravity, as the log asks for: give identify = gravity."]


def worse_than_none(left: Mapping[str, Left]) -> list[str]:
    """Return a sentence that names the feedforwards which leave more torque than none, if any does."""
    worse = [name for name, torque in left.items() if torque.whole > left[NONE].whole]
    if not worse:
        return []
    return [
        f"More torque than without any feedforward is left by {' and '.join(worse)}: another torque acts on the joint "
        "(gravity, other axes), or signs or units are not those of the log."
    ]


def _check_arguments(log: Log, band: float, lead: float | None) -> None:
    if not band > 0.0:
        raise InputError(f"band = {band:g} Hz is not allowed: it must be positive")
    if REFERENCE_VELOCITY in log.extra and REFERENCE_POSITION in log.extra:
        raise InputError(f"{log.name}: {REFERENCE_VELOCITY} and {REFERENCE_POSITION} are both given; give one of them")
    if lead and not has_reference(log):
        raise InputError(
            f"{log.name}: motion_lead = {lead:g} s is not allowed without a reference: it must be zero or not given"
        )


def _notes(
    log: Log,
    settings: ReplaySettings,
    given: Mapping[str, Any] | None,
    judged: float | None,
    reference_band: float,
) -> list[str]:
    """Return what is to be known of the figures."""
    notes = []
    if given is None:
        notes.append("Settings of the adaptive controller are those of the saved state.")
    else:
        chosen = [name for name in FROM_LOG if given.get(name) is None]
        if chosen:
            known = [name for name in chosen if getattr(settings, name) is not None]
            shown = ", ".join(f"{name} {getattr(settings, name):.3g}" for name in known)
            notes.append(
                f"Not given, but taken from the log, which a running machine does not have beforehand: {shown}."
            )
    if not has_reference(log):
        notes.append(
            f"The log has no reference: the measured motion stands for it, filtered without delay in a band of "
            f"{reference_band:.3g} Hz, so the feedforward knows what the machine could not know."
        )
    elif settings.motion_lead != 0.0:
        notes.append(
            f"The motion is {_ahead(settings.motion_lead)} the recorded reference, which is taken when it was "
            "followed; a feedforward of the machine's own is judged as it was recorded."
        )
    if judged is None:
        notes.append("The sample time is too long for the band: torques are judged at all frequencies.")
    return notes


def _ahead(lead: float) -> str:
    return f"{1e3 * abs(lead):.3g} ms {'ahead of' if lead > 0.0 else 'behind'}"


def _other_lead(settings: ReplaySettings, own: float) -> list[str]:
    """Return a sentence where the motion of a log alone says another time than the saved one."""
    if abs(own - settings.motion_lead) < SAMPLES * settings.period:
        return []
    found = (
        f"its motion is {_ahead(own)} its reference" if own != 0.0 else "no time between motion and reference is seen"
    )
    return [
        f"In this log {found}, but motion_lead is {settings.motion_lead:.3g} s, as it was saved; more torque may be "
        "left for it."
    ]


def _runners(
    settings: ReplaySettings, model: TorqueModel | None, saved: UnsupervisedController | None, is_position: bool
) -> dict[str, Runner]:
    """Return the controllers that watch, by the name of their feedforward."""
    controllers: dict[str, Controller] = {}
    if model is not None:
        controllers[FIXED] = ModelBased(*settings.gains, settings.period, model)
    controllers[COLD] = settings.controller()
    if saved is not None:
        controllers[SAVED] = saved
    observer = settings.observer(is_position=is_position)
    return {name: Runner(controller, observer) for name, controller in controllers.items()}
