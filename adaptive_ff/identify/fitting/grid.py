"""Normal equations of a log over a grid of friction lags and speeds, block by block.

Every model of a log is linear once its lag and its bend of the friction curve are given. So the products of all columns
are summed once for each lag of a grid and each block of the rows; any model, fitted to any blocks and tried on others,
is then a matter of small matrices. The lag is interpolated between the points of the grid, where the sum of squares is
a parabola to good accuracy.
"""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.identify.rows.filtering import Conditioned
from adaptive_ff.identify.rows.regressors import Problem, direct_column, friction_column
from adaptive_ff.identify.rows.sampled_lag import sampled_share
from adaptive_ff.identify.terms import BENT, DAMPING, DIRECT, FORCE_OVER, FRICTION
from adaptive_ff.logs.derivatives import Array

BLOCKS = 10
"""Blocks of rows, one after the other, that are held out in turn."""

LAG_STEP = 0.05
"""Step of the grid of lags, in cycles of the band: a residual changes over a sixth of a cycle."""

EVERY = {"stiction_excess": 2, "square_stiction": 2, "saturation": 1, "slow_saturation": 1, "long_saturation": 1}
"""Step through the speeds of the log's grid: columns of neighbours are much alike."""


class Grid(NamedTuple):
    """Products of columns.

    Attributes
    ----------
    names : tuple of str
        Columns: linear terms, then the bent column for each speed of the grid, and the torque last.
    lags : ndarray, shape (lags,)
        Friction lags, s; zero is one of them.
    speeds : dict of ndarray, shape (speeds,)
        Speeds of the bend, rad/s, by term.
    products : ndarray, shape (blocks, lags, columns, columns)
        Products of the scaled columns over the rows of each block.
    scale : ndarray, shape (columns,)
        Norm by which each column was divided.
    rows : int
        Number of rows.
    """

    names: tuple[str, ...]
    lags: Array
    speeds: dict[str, Array]
    products: Array
    scale: Array
    rows: int

    @property
    def without_lag(self) -> int:
        """Place of the lag of zero."""
        return int(np.argmin(np.abs(self.lags)))


def make_grid(problem: Problem) -> Grid:
    """Sum the products of all columns that a log has."""
    with_position = all(piece.sine is not None for piece in problem.pieces)
    direct = [term for term in DIRECT if with_position or not term.startswith("gravity")]
    if problem.path == 0.0:
        direct.remove(DAMPING)
    mapped = list(problem.pieces[0].mapped)
    direct += [term for term in mapped if term.startswith(FORCE_OVER)]
    straight = [*FRICTION, *(term for term in mapped if not term.startswith(FORCE_OVER))]
    count = max(1, math.ceil(1.0 / LAG_STEP))
    lags = problem.longest_lag * np.arange(-count, count + 1) / count
    fixed, lagging, target = [], [], []
    for piece in problem.pieces:
        fixed.append(np.column_stack([direct_column(piece, term) for term in direct])[piece.slides])
        friction = np.array([friction_column(piece, problem.speeds, term, {}) for term in straight])
        bent = [piece.bent[term][:: EVERY[term]] for term in BENT]
        lagging.append(_lagging(piece, straight, np.vstack([friction, *bent])))
        target.append(piece.moving_torque[piece.slides])
    speeds = {term: problem.speeds[term][:: EVERY[term]] for term in BENT}
    columns = [f"{term} {place}" for term in BENT for place in range(speeds[term].size)]
    names = (*direct, *straight, *columns, "torque")
    rows = sum(part.size for part in target)
    edges = np.linspace(0, rows, BLOCKS + 1).round().astype(int)
    products = np.empty((BLOCKS, lags.size, len(names), len(names)))
    matrix = np.empty((rows, len(names)))
    matrix[:, : len(direct)], matrix[:, -1] = np.concatenate(fixed), np.concatenate(target)
    scale: Array | None = None
    for place in sorted(range(lags.size), key=lambda place: abs(float(lags[place]))):
        lagged = [_lagged(series, piece, float(lags[place]))[:, piece.slides].T
                  for series, piece in zip(lagging, problem.pieces, strict=True)]  # fmt: skip
        matrix[:, len(direct) : -1] = np.concatenate(lagged)
        if scale is None:  # of the friction that does not lag
            scale = np.linalg.norm(matrix, axis=0)
            scale[scale == 0.0] = 1.0
        scaled = matrix / scale
        for block in range(BLOCKS):
            part = scaled[edges[block] : edges[block + 1]]
            products[block, place] = part.T @ part
    assert scale is not None
    return Grid(names, lags, speeds, products, scale, rows)


def _spectrum(series: Array) -> NDArray[np.complex128]:
    """Return the spectra of series that are continued by their mirror images."""
    return np.fft.rfft(np.concatenate([series, series[:, ::-1]], axis=1), axis=1)


class Lagging(NamedTuple):
    """Columns of friction to be lagged: spectra of their means around the samples, and what samples have beyond.

    With the spectra of their impulses at the edges of motions, or None.
    """

    spectra: NDArray[np.complex128]
    between: Array
    edges: NDArray[np.complex128] | None


def _lagging(piece: Conditioned, straight: Sequence[str], columns: Array) -> Lagging:
    """Return columns, of the straight terms of friction and of each speed of the bent ones, to be lagged."""
    between = _of_columns(piece.between, straight, columns.shape)
    edges = _spectrum(_of_columns(piece.edges, straight, columns.shape)) if piece.edges else None
    return Lagging(_spectrum(columns - between), between, edges)


def _of_columns(series: Mapping[str, Array], straight: Sequence[str], shape: tuple[int, ...]) -> Array:
    """Return the series of each column, zero where it has none."""
    made = np.zeros(shape)
    if series:
        for place, term in enumerate(straight):
            made[place] = series.get(term, 0.0)
        made[len(straight) :] = np.vstack([series[term][:: EVERY[term]] for term in BENT])
    return made


def _lagged(series: Lagging, piece: Conditioned, lag: float) -> Array:
    """Return the columns with a lag, as they are sampled; a negative lag leads."""
    size = piece.time.size
    response = 1.0 / (1.0 + lag * 2j * math.pi * np.fft.rfftfreq(2 * size, piece.period))
    spectra = series.spectra if series.edges is None else series.spectra + lag * series.edges
    lagged: Array = np.fft.irfft(spectra * response, 2 * size, axis=1)[:, :size]
    return lagged + sampled_share(piece.sample_time, lag) * series.between
