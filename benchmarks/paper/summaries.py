"""Figures of many seeds in a few words."""

from collections.abc import Sequence

import numpy as np

from adaptive_ff.friction.model import ESTIMATED
from adaptive_ff.learning.batch import Array
from benchmarks.paper.identification_data import SYMBOLS, TRUE

TRUTH = np.array([getattr(TRUE, name) for name in ESTIMATED])
"""True inertia, Coulomb friction, stiction, viscous coefficient and friction lag."""


def median_and_range(values: Sequence[float], digits: int = 2) -> str:
    """Return the median of some numbers and their range as text."""
    low, middle, high = np.quantile(np.asarray(values, dtype=np.float64), (0.0, 0.5, 1.0))
    return f"{middle:.{digits}f} ({low:.{digits}f} to {high:.{digits}f})"


def median_deviation(estimates: Sequence[Array]) -> str:
    """Return by how much physical parameters are off the truth, in %, the median over some records, as text."""
    deviations = 100.0 * (np.median(np.array(estimates), axis=0) / TRUTH - 1.0)
    return ", ".join(f"{SYMBOLS[name]} {value:+.1f}" for name, value in zip(ESTIMATED, deviations, strict=True))
