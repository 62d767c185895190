"""A ripple of the torque over the position whose period nobody told: cogging of a motor, teeth, an eccentric wheel.

Under feedback a joint follows the ripple: it accelerates where that helps and slows down where it does not. So what
the ripple has of the torque is correlated with the acceleration, and regressed on it inertia is too small, or, where
the feedback works against the ripple, too large (the bias of closed loops; A. Janot, P.-O. Vandanjon, M. Gautier, "A
generic instrumental variable approach for industrial robot identification", IEEE Transactions on Control Systems
Technology 22, 2014). No interval of a model without it tells. In the model it is one sine more.

The period is where the residual of a model has most power over the position (N. Lomb, "Least-squares frequency analysis
of unequally spaced data", Astrophysics and Space Science 39, 1976), beyond what chance has at the best of as many
periods. Whether it is used is decided as for every other term, on blocks that are held out.

A motion that repeats itself reverses at the same few places again and again, and what a model lacks at reversals (such
as the bending of bristles) comes back there: many rows, but few independent ones, which waves short enough go through.
Blocks that are held out see the same places and cannot tell. So chance is taken over the correlation of the residuals
along the position, too (as T. Conley does it for places, "GMM estimation with cross sectional dependence", Journal of
Econometrics 92, 1999), and counts as the larger of both.
"""

import math
from collections.abc import Sequence

import numpy as np
from scipy import fft, optimize

from adaptive_ff.identify.fitting.fit import correlation_length
from adaptive_ff.identify.fitting.fitted import Fitted
from adaptive_ff.identify.maps.map_columns import MapAsked, band_along, map_basis, position_along
from adaptive_ff.identify.preparation import Prepared
from adaptive_ff.identify.rows.regressors import Problem, design
from adaptive_ff.learning.batch_least_squares import spread_along, spread_of_sum
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

REACH, CELLS = 2.0, 8
"""Length over which residuals in neighbouring places count as correlated, periods; cells that it is divided into."""


def ripple_period(problem: Problem, prepared: Prepared, pieces: Sequence[Piece], fitted: Fitted) -> float | None:
    """Return the period of a ripple that a model leaves, rad (m); None where it leaves none that is beyond chance.

    Parameters
    ----------
    problem : Problem
        The rows.
    prepared : Prepared
        The log that they come from.
    pieces : sequence of Piece
        Its pieces, in the order of the problem's.
    fitted : Fitted
        The model.
    """
    residuals = fitted.regression.residuals
    parts = [
        (band_along(prepared, piece), position_along(prepared.log, piece, prepared.period), rows.slides)
        for piece, rows in zip(pieces, problem.pieces, strict=True)
    ]
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

    def power(frequency: float) -> tuple[float, float]:
        """Return what a wave explains of the residual, and what chance would."""
        basis = map_basis(MapAsked((1.0 / frequency,)), prepared, pieces)
        waves = np.concatenate(
            [np.transpose([band.filtered(wave)[slides] for wave in basis.over(path)]) for band, path, slides in parts]
        )
        directions = np.linalg.qr(waves - orthogonal @ (orthogonal.T @ waves))[0]
        along = directions.T @ residuals
        left = residuals - directions @ along
        chance = spread_along(directions, left, correlation_length(left), columns.shape[1])
        in_place = _spread_in_place(directions * left[:, np.newaxis], position, REACH / frequency)
        return float(along @ along), max(float(np.trace(chance)), in_place)

    tried = _peaks(position - np.min(position), residuals, lowest, highest)
    if not tried:
        return None
    best = max(tried, key=lambda frequency: power(frequency)[0])
    near = 0.5 / travel
    found = optimize.minimize_scalar(
        lambda frequency: -power(frequency)[0],
        bounds=(max(best - near, lowest), min(best + near, highest)),
        method="bounded",
        options={"xatol": 0.01 * near},
    )
    explained, chance = power(float(found.x))
    told_apart = travel * (highest - lowest)
    return 1.0 / float(found.x) if explained > chance * (SURELY + math.log(1.0 + told_apart)) else None


def _spread_in_place(products: Array, position: Array, reach: float) -> float:
    """Return the variance of the sum of products whose rows are correlated as far as they are in the same place.

    Parameters
    ----------
    products : ndarray, shape (rows, n)
        What is summed; its mean is zero.
    position : ndarray, shape (rows,)
        Where the joint is, rad (m).
    reach : float
        Distance from which on rows are independent, rad (m); Bartlett's weights fall to zero there.

    Returns
    -------
    float
        Trace of the covariance.
    """
    cells = ((position - np.min(position)) * (CELLS / reach)).astype(np.int64)
    summed: Array = np.column_stack([np.bincount(cells, column) for column in products.T]).astype(
        np.float64, copy=False
    )
    return float(np.trace(spread_of_sum(summed, CELLS - 1)))


def _peaks(position: Array, residuals: Array, lowest: float, highest: float) -> list[float]:
    """Return the frequencies (periods in a rad) between two at which residuals have most power over the position."""
    place = 1.0 / (PLACES * highest)
    held = np.bincount((position / place).astype(np.int64), residuals)
    size = fft.next_fast_len(PADDING * held.size, real=True)
    power = np.square(np.abs(fft.rfft(held, size)))
    frequency = np.arange(power.size) / (size * place)
    inside = np.flatnonzero((frequency > lowest) & (frequency < highest))
    after = np.minimum(inside + 1, power.size - 1)
    tops = inside[(power[inside] >= power[inside - 1]) & (power[inside] >= power[after])]
    return [float(frequency[top]) for top in tops[np.argsort(power[tops])[::-1][:PEAKS]]]
