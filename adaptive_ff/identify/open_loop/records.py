"""Logs as they are simulated in open loop: without defect, at equal steps, with velocities to start from."""

import numpy as np

from adaptive_ff.errors import InputError
from adaptive_ff.identify.open_loop.simulation import Record
from adaptive_ff.identify.open_loop.structures import BLOCKS, SETTLING
from adaptive_ff.identify.preparation import Prepared, prepare
from adaptive_ff.identify.rows.band import uniform
from adaptive_ff.logs.derivatives import lowpass
from adaptive_ff.logs.log import Log

WINDOW = 1.0
"""Length of the short simulations of the score, s."""

VELOCITY_BAND = 100.0
"""Band of the velocity that a simulation starts with, Hz, at most a quarter of the sampling frequency."""


def prepare_whole(log: Log, *, linear: bool) -> Prepared:
    """Return a log that can be simulated from end to end."""
    if log.position is None:
        raise InputError(f"{log.name}: a score takes a position, which is what the simulation is compared with")
    prepared = prepare(log, linear=linear)
    if len(prepared.pieces) != 1 or prepared.skipped:
        reason = prepared.skipped[0].reason if prepared.skipped else "it has several pieces"
        raise InputError(f"{log.name}: an open-loop simulation takes a log without defect; {reason}")
    return prepared


def record_of(prepared: Prepared, torque_delay: float) -> Record:
    """Return a log on a uniform grid, with velocities to start from; the delay of the torque in s."""
    log = prepared.log
    time, position, torque = uniform(log, prepared.pieces[0], prepared.period)
    if torque_delay != 0.0:
        torque = np.interp(time - torque_delay, time, torque)
    fewest, longest = 2 * SETTLING * BLOCKS, WINDOW / (SETTLING + 1)
    if position.size < fewest or prepared.period > longest:
        raise InputError(
            f"{log.name}: {position.size} samples, {prepared.period:.3g} s apart, are not enough for a score; it takes "
            f"{fewest} or more, at most {longest:.3g} s apart"
        )
    smooth = lowpass(position, (min(VELOCITY_BAND, 0.25 / prepared.period),), prepared.period)
    return Record(
        np.ascontiguousarray(position),
        np.gradient(smooth, prepared.period),
        np.ascontiguousarray(torque),
        prepared.period,
    )
