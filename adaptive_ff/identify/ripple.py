"""A ripple of the torque over the position whose period nobody told: cogging of a motor, teeth, an eccentric wheel.

Under feedback a joint follows the ripple: it accelerates where that helps and slows down where it does not. So what
the ripple has of the torque is correlated with the acceleration, and regressed on it inertia is too small, or, where
the feedback works against the ripple, too large (the bias of closed loops; A. Janot, P.-O. Vandanjon, M. Gautier, "A
generic instrumental variable approach for industrial robot identification", IEEE Transactions on Control Systems
Technology 22, 2014). No interval of a model without it tells. In the model it is one sine more.

The period is where the residual of a model has most power over the position (N. Lomb, "Least-squares frequency analysis
of unequally spaced data", Astrophysics and Space Science 39, 1976), beyond what chance has at the best of as many
periods. Whether it is used is decided as for every other term, on blocks that are held out. A further one is looked for
in what the model with those before it leaves, and then each found more closely beside the others: a period that is a
little off would leave a third one, near it.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from scipy import fft, optimize

from adaptive_ff.estimation.batch_least_squares import spread_along
from adaptive_ff.identify.filtering import Band
from adaptive_ff.identify.fit import Fitted, correlation_length
from adaptive_ff.identify.map_columns import band_along, position_along
from adaptive_ff.identify.preparation import Prepared
from adaptive_ff.identify.regressors import Problem, design
from adaptive_ff.logs.defects import Piece
from adaptive_ff.logs.derivatives import Array

FEWEST_PERIODS = 1.0
"""Periods that the log must travel."""

SLOW_SHARE = 0.05
"""Share of the rows at whose speed the shortest period is still in the band."""

MOST_PLACES = 2**18
"""Most places that positions are put in."""

PLACES, PADDING = 4.0, 8
"""Places in the shortest period, and how much finer than they are long spectra are read."""

PEAKS = 8
"""Largest peaks of the spectrum that are tried."""

SURELY = 15.0
"""Power of the best period over that of chance, beyond the logarithm of the number of periods that are told apart."""


REFINED = 2
"""How often the periods of several ripples are refined, each beside the others."""


class _Rows(NamedTuple):
    """What a model leaves of the torque, and what is needed to make waves over the position beside it.

    Attributes
    ----------
    parts : tuple of (Band, ndarray, ndarray)
        Filters, positions and the rows that slide, of each piece.
    orthogonal : ndarray, shape (n, k)
        Orthogonal directions of the model's columns, and of the ripples that are known.
    residuals : ndarray, shape (n,)
        What they leave.
    lowest, highest, travel : float
        Frequencies that can be found, 1/rad, and what the log travels, rad.
    """

    parts: tuple[tuple[Band, Array, NDArray[np.bool_]], ...]
    orthogonal: Array
    residuals: Array
    lowest: float
    highest: float
    travel: float

    def waves(self, frequency: float) -> Array:
        """Return the columns of a cosine and a sine, shape (n, 2)."""
        made = []
        for band, position, slides in self.parts:
            phase = 2.0 * math.pi * frequency * position
            made.append(np.transpose([band.filtered(wave)[slides] for wave in (np.cos(phase), np.sin(phase))]))
        return np.concatenate(made)

    def beside(self, frequencies: Sequence[float]) -> Self:
        """Return the rows beside ripples that are known."""
        if not frequencies:
            return self
        waves = np.hstack([self.waves(frequency) for frequency in frequencies])
        added = np.linalg.qr(waves - self.orthogonal @ (self.orthogonal.T @ waves))[0]
        left = self.residuals - added @ (added.T @ self.residuals)
        return self._replace(orthogonal=np.hstack([self.orthogonal, added]), residuals=left)

    def power(self, frequency: float) -> tuple[float, float]:
        """Return what a wave explains of the residual, and what chance would."""
        waves = self.waves(frequency)
        directions = np.linalg.qr(waves - self.orthogonal @ (self.orthogonal.T @ waves))[0]
        along = directions.T @ self.residuals
        left = self.residuals - directions @ along
        chance = spread_along(directions, left, correlation_length(left), self.orthogonal.shape[1])
        return float(along @ along), float(np.trace(chance))

    def best_near(self, frequency: float) -> float:
        """Return the frequency with the most power near one."""
        near = 0.5 / self.travel
        found = optimize.minimize_scalar(
            lambda other: -self.power(other)[0],
            bounds=(max(frequency - near, self.lowest), min(frequency + near, self.highest)),
            method="bounded",
            options={"xatol": 0.01 * near},
        )
        return float(found.x)


def next_ripple(
    problem: Problem, prepared: Prepared, pieces: Sequence[Piece], fitted: Fitted, known: Sequence[float] = ()
) -> tuple[float, ...] | None:
    """Return the periods of known ripples and of one more, rad (m); None where there is no further one beyond chance.

    Parameters
    ----------
    problem : Problem
        The rows.
    prepared : Prepared
        The log that they come from.
    pieces : sequence of Piece
        Its pieces, in the order of the problem's.
    fitted : Fitted
        The model without ripples.
    known : sequence of float, optional
        Periods of the ripples that are known; each is found more closely beside the others.
    """
    plain = _rows(problem, prepared, pieces, fitted)
    if plain is None:
        return None
    frequencies = [1.0 / period for period in known]
    rows = plain.beside(frequencies)
    tried = _peaks(rows)
    if not tried:
        return None
    found = rows.best_near(max(tried, key=lambda frequency: rows.power(frequency)[0]))
    explained, chance = rows.power(found)
    told_apart = rows.travel * (rows.highest - rows.lowest)
    if explained <= chance * (SURELY + math.log(1.0 + told_apart)):
        return None
    frequencies.append(found)
    for place in list(range(len(frequencies))) * (REFINED if known else 0):
        others = frequencies[:place] + frequencies[place + 1 :]
        frequencies[place] = plain.beside(others).best_near(frequencies[place])
    return tuple(1.0 / frequency for frequency in frequencies)


def _rows(problem: Problem, prepared: Prepared, pieces: Sequence[Piece], fitted: Fitted) -> _Rows | None:
    """Return what a model leaves, where the log shows any period."""
    parts = tuple(
        (band_along(prepared, piece), position_along(prepared.log, piece, prepared.period), rows.slides)
        for piece, rows in zip(pieces, problem.pieces, strict=True)
    )
    position = np.concatenate([path[band.kept][slides] for band, path, slides in parts])
    speed = np.concatenate([np.abs(piece.velocity[piece.slides]) for piece in problem.pieces])
    travel = float(np.ptp(position))
    slow = float(np.quantile(speed, SLOW_SHARE))
    if travel <= 0.0 or slow <= 0.0:
        return None
    lowest = FEWEST_PERIODS / travel
    highest = min(prepared.bandwidth / slow, MOST_PLACES / (PLACES * travel))
    if highest <= lowest:
        return None
    columns = design(problem, fitted.linear, fitted.searched)
    orthogonal = np.linalg.qr(columns / np.linalg.norm(columns, axis=0))[0]
    return _Rows(parts, orthogonal, fitted.regression.residuals, lowest, highest, travel)


def _peaks(rows: _Rows) -> list[float]:
    """Return the frequencies (periods in a rad) at which residuals have most power over the position."""
    position = np.concatenate([path[band.kept][slides] for band, path, slides in rows.parts])
    place = 1.0 / (PLACES * rows.highest)
    held = np.bincount(((position - np.min(position)) / place).astype(np.int64), rows.residuals)
    size = fft.next_fast_len(PADDING * held.size, real=True)
    power = np.square(np.abs(fft.rfft(held, size)))
    frequency = np.arange(power.size) / (size * place)
    inside = np.flatnonzero((frequency > rows.lowest) & (frequency < rows.highest))
    after = np.minimum(inside + 1, power.size - 1)
    tops = inside[(power[inside] >= power[inside - 1]) & (power[inside] >= power[after])]
    return [float(frequency[top]) for top in tops[np.argsort(power[tops])[::-1][:PEAKS]]]
