"""A log cut into pieces that can be filtered, with the band and what counts as rest, and the rows of some of them."""

import math
from typing import NamedTuple

import numpy as np

from adaptive_ff.errors import InputError, counted
from adaptive_ff.identify.rows.band import shortest_piece, uniform, wide_velocity
from adaptive_ff.identify.rows.column_noise import column_noise
from adaptive_ff.identify.rows.filtering import condition
from adaptive_ff.identify.rows.regressors import Problem
from adaptive_ff.identify.rows.standing import Rest, find_rest
from adaptive_ff.logs.bandwidth import check_bandwidth, choose_bandwidth, wide_corner
from adaptive_ff.logs.defects import Piece, Skipped, check_varies, median_step, usable_pieces
from adaptive_ff.logs.derivatives import REACH
from adaptive_ff.logs.log import Log
from adaptive_ff.logs.missing_values import lacking_column
from adaptive_ff.logs.sanity import look_through

NOISE_ALONE = 0.5
"""Share of twice the variance of a position from which the squares of its steps are those of noise. A sine has so large
steps from a sixth of the sampling frequency on; the band ends at a tenth."""

FEWEST_SAMPLES = 50
"""Samples below which nothing is tried."""

LAG_CYCLES = 1.0
"""Largest friction lag that is looked for, in cycles of the band."""

LARGEST = 1e30
"""Largest value of a series; one over it is the smallest peak."""

DRIVEN = "it must be that of the drive"
"""What is asked of a torque that never changes."""

SWINGING = "of a joint that swings freely, take its known gravity away with --known-torque, and give --model offset"
"""What a rotary joint without a drive can be identified by: its weight."""


class Prepared(NamedTuple):
    """A log, ready to be filtered.

    Attributes
    ----------
    log : Log
        The log.
    pieces : list of Piece
        Pieces that are long enough for the band.
    skipped : list of Skipped
        What is not used, and why.
    period : float
        Sample time, s.
    bandwidth : float
        Band of the regression, Hz.
    rest : Rest
        What counts as rest.
    said : list of str
        What is probably wrong with it, a sentence each.
    """

    log: Log
    pieces: list[Piece]
    skipped: list[Skipped]
    period: float
    bandwidth: float
    rest: Rest
    said: list[str]


def prepare(log: Log, bandwidth: float | None = None, *, linear: bool = False) -> Prepared:
    """Cut a log into usable pieces, and choose the band where none is given.

    Parameters
    ----------
    log : Log
        The log.
    bandwidth : float, optional
        Band, Hz.
    linear : bool, optional
        Whether it is a linear axis, whose position does not wrap.

    Raises
    ------
    InputError
        The log is too short, does not move, has a constant torque, or the band is not allowed.
    """
    if log.time.size < FEWEST_SAMPLES:
        few = counted(log.time.size, "sample")
        raise InputError(f"{log.name}: the log has {few}; there must be at least {FEWEST_SAMPLES}")
    _check_sizes(log, median_step(log))
    given = log
    log, said, jumps = look_through(given, linear=linear)
    period = median_step(log)
    smallest = 4 * REACH
    pieces, skipped = usable_pieces(log, smallest, jumps)
    if not pieces:
        worst = _worst(skipped) + lacking_column(given)
        raise InputError(f"{log.name}: no piece of {smallest} samples is without defect; {worst}")
    is_position = log.position is not None
    what = "position" if is_position else "velocity"
    check_varies(f"{log.name}: the {what}", log.motion, pieces, "it must move to be identified")
    _check_moves(log, pieces, "m" if linear else "rad")
    check_varies(f"{log.name}: the torque", log.torque, pieces, DRIVEN if linear else f"{DRIVEN}; {SWINGING}")
    if bandwidth is None:
        longest = max(pieces, key=lambda piece: piece.size)
        bandwidth = choose_bandwidth(uniform(log, longest, period)[1], period, is_position=is_position)
    check_bandwidth(bandwidth, period)
    needed = shortest_piece(bandwidth, period)
    enough = [piece for piece in pieces if piece.size >= needed]
    short = [Skipped(*piece, _too_short(piece, period, needed)) for piece in pieces if piece.size < needed]
    if not enough:
        longest = max(pieces, key=lambda piece: piece.size)
        raise InputError(
            f"{log.name}: the longest piece without defect has {longest.size} samples; in a band of {bandwidth:.3g} Hz "
            f"there must be {needed} (widen it with a larger bandwidth, or record for longer)"
        )
    longest = max(enough, key=lambda piece: piece.size)
    corner = wide_corner(uniform(log, longest, period)[1], bandwidth, period, is_position=is_position)
    velocities = [
        wide_velocity(uniform(log, piece, period)[1], corner, period, is_position=is_position) for piece in enough
    ]
    if not any(np.any(velocity) for velocity in velocities):
        raise InputError(f"{log.name}: nothing moves; the joint must move to be identified")
    return Prepared(log, enough, sorted([*skipped, *short]), period, bandwidth, find_rest(velocities, corner), said)


class Parts(NamedTuple):
    """Pieces of a log that are fitted and held out, and what became too short for the filters."""

    fitting: list[Piece]
    holding: list[Piece]
    short: list[Skipped]


def divide(prepared: Prepared, share: float) -> Parts:
    """Divide the pieces of a log in time; the last share of their samples is held out."""
    needed = shortest_piece(prepared.bandwidth, prepared.period)
    parts = split(prepared.pieces, share)
    fitting, holding = ([piece for piece in part if piece.size >= needed] for part in parts)
    short = [
        Skipped(*piece, _too_short(piece, prepared.period, needed))
        for part in parts
        for piece in part
        if piece.size < needed
    ]
    if not fitting:
        raise InputError(
            f"{prepared.log.name}: with {100.0 * share:g} % held out, no piece is left of the {needed} samples that "
            "the filters need; hold out less"
        )
    return Parts(fitting, holding, short)


def split(pieces: list[Piece], share: float) -> tuple[list[Piece], list[Piece]]:
    """Divide pieces in time; the last share of their samples comes second.

    Cut before any filter has run, nothing of the second part leaks into the first.
    """
    total = sum(piece.size for piece in pieces)
    left = round((1.0 - share) * total)
    first: list[Piece] = []
    second: list[Piece] = []
    for piece in pieces:
        middle = piece.start + min(max(left, 0), piece.size)
        left -= piece.size
        first += [Piece(piece.start, middle)] if middle > piece.start else []
        second += [Piece(middle, piece.stop)] if piece.stop > middle else []
    return first, second


def regression_problem(prepared: Prepared, pieces: list[Piece], torque_delay: float) -> Problem:
    """Return what is regressed of some pieces of a log; the delay of the torque in s."""
    band, period, rest = prepared.bandwidth, prepared.period, prepared.rest
    conditioned = [condition(prepared.log, piece, band, period, rest, torque_delay) for piece in pieces]
    longest = max(prepared.pieces, key=lambda piece: piece.size)
    noise = column_noise(prepared.log, longest, period, (rest.corner, band))
    variances = {"inertia": noise.acceleration, "viscous": noise.velocity}
    path = 0.0 if rest.bending is None else rest.bending.path
    return Problem(conditioned, rest.speeds, LAG_CYCLES / band, variances, path=path)


def _too_short(piece: Piece, period: float, needed: int) -> str:
    """Say why a piece is too short."""
    return f"a piece of {piece.size * period:.3g} s; the filters need {needed * period:.3g} s"


def _check_moves(log: Log, pieces: list[Piece], unit: str) -> None:
    """Refuse a position that is nothing but noise, by J. von Neumann's ratio (1941).

    The mean square of its steps is twice the variance then, and ``1 - cos(2 pi f Ts)`` of that for a sine.
    """
    if log.position is None:
        return
    positions = [log.position[start:stop] for start, stop in pieces]
    steps = sum(float(np.sum(np.diff(position) ** 2)) for position in positions)
    spread = sum(float(np.sum((position - np.mean(position)) ** 2)) for position in positions)
    if steps > NOISE_ALONE * 2.0 * spread:
        scatter = math.sqrt(spread / sum(piece.size for piece in pieces))
        raise InputError(
            f"{log.name}: the position scatters by {scatter:.3g} {unit} (rms), no more than from one sample to the "
            "next: that is noise; it must move to be identified"
        )


def _check_sizes(log: Log, period: float) -> None:
    """Refuse values with which squares would leave the range of numbers."""
    series = {"sample time": np.array([period]), "torque": log.torque, "motion": log.motion}
    for name, values in series.items():
        peak = float(np.max(np.abs(values), where=np.isfinite(values), initial=0.0))
        if peak != 0.0 and not 1.0 / LARGEST <= peak <= LARGEST:
            raise InputError(
                f"{log.name}: the {name} reaches {peak:.3g}; it must be from {1.0 / LARGEST:g} to {LARGEST:g}"
            )


def _worst(skipped: list[Skipped]) -> str:
    """Name the defect that costs most."""
    if not skipped:
        return "there is none at all"
    return "mostly " + max(skipped, key=lambda skip: skip.stop - skip.start).reason
