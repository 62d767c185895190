"""Intervals of a model whose friction bends, over all bends and shapes of saturation that the log allows.

How far viscous friction has saturated at the speeds of a log, and in which shape, is often not determined by it, and
the linearised interval of such a fit is wrong both ways: it knows neither the other shapes, nor that the bend acts on
the other parameters along a curve. So these intervals are profiled (D. Bates, D. Watts, "Nonlinear Regression
Analysis", Wiley, 1988, chapter 6): at each bend of each shape all else is fitted anew on the grid of
:mod:`adaptive_ff.identify.fitting.grid`, and with ``D`` the sum of squares beyond its smallest and ``t`` the quantile,

    union of  value(bend) +- se(bend) sqrt(t^2 - D / (s^2 inflation))   where that is real

``inflation`` is what the correlation of the residuals makes of a variance, by the fit: the largest of all parameters
and at least one, as what two shapes differ in is no parameter of either.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy import stats
from scipy.interpolate import PchipInterpolator

from adaptive_ff.identify.fitting.fitted import Fitted
from adaptive_ff.identify.fitting.grid import Grid
from adaptive_ff.identify.fitting.grid_fit import RIDGE, parabola_at
from adaptive_ff.identify.terms import BENT, LAG, SATURATIONS
from adaptive_ff.logs.derivatives import Array

POINTS = 200
"""Bends of each shape at which the interval is taken; between those of the grid all is interpolated."""

SHARP = 0.5
"""Standard error of the bend, in steps of its grid, up to which a fit counts as linear in it."""


class Profile(NamedTuple):
    """A model along the bend of one shape.

    Attributes
    ----------
    squares : ndarray, shape (bends,)
        Sum of squares, in units of that of the torque; infinite where the friction would bend the other way.
    values, deviations : dict of ndarray, shape (bends,)
        Linear terms, and their standard errors at a given bend and lag but for the deviation of the residual.
    """

    squares: Array
    values: dict[str, Array]
    deviations: dict[str, Array]


def shape_profiles(grid: Grid, terms: Sequence[str]) -> list[Profile]:
    """Return the profiles of a model with saturating friction, one for each shape that it may have instead."""
    others = [term for term in terms if term not in SATURATIONS]
    return [_profile(grid, others, shape) for shape in SATURATIONS]


def _profile(grid: Grid, terms: Sequence[str], shape: str) -> Profile:
    """Fit all but the bend, at each bend of the grid."""
    straight = [term for term in terms if term in grid.names]
    size = len(straight) + 1
    count = grid.speeds[shape].size
    last = len(grid.names) - 1
    chosen = np.array(
        [[*map(grid.names.index, straight), grid.names.index(f"{shape} {k}"), last] for k in range(count)]
    )
    zero = grid.without_lag
    lags = slice(zero, None if LAG in terms else zero + 1)
    whole = np.sum(grid.products[:, lags], axis=0)[:, chosen[:, :, np.newaxis], chosen[:, np.newaxis, :]]
    inverse = np.linalg.inv(whole[..., :size, :size] + RIDGE * np.eye(size))
    vector = whole[..., :size, size]
    values = np.einsum("...ij,...j->...i", inverse, vector)
    squares = whole[..., size, size] - np.sum(values * vector, axis=-1)
    squares = np.where(values[..., -1] > 0.0, squares, np.inf)
    deviations = np.sqrt(np.einsum("...ii->...i", inverse))
    best, found, spread = np.empty(count), np.empty((count, size)), np.empty((count, size))
    for bend in range(count):
        best[bend], found[bend], spread[bend] = _at_lag(squares[:, bend], values[:, bend], deviations[:, bend])
    names = [*straight, shape]
    units = grid.scale[-1] / grid.scale[chosen[:, :-1]]
    return Profile(
        best,
        {name: found[:, place] * units[:, place] for place, name in enumerate(names)},
        {name: spread[:, place] * units[:, place] for place, name in enumerate(names)},
    )


def _at_lag(squares: Array, values: Array, deviations: Array) -> tuple[float, Array, Array]:
    """Return what is at the best lag, between the points of the grid on parabolas."""
    place = int(np.argmin(squares))
    _, weights = parabola_at(squares, place)
    if weights is None:
        return float(squares[place]), values[place], deviations[place]
    around = slice(place - 1, place + 2)
    return float(weights @ squares[around]), weights @ values[around], deviations[place]


def profile_interval(
    grid: Grid, profiles: Sequence[Profile], fitted: Fitted, name: str, confidence: float
) -> tuple[float, float]:
    """Return the ends of the interval of a linear term of a model that saturates.

    Parameters
    ----------
    grid : Grid
        The products.
    profiles : sequence of Profile
        Of the model's shapes, see ``shape_profiles``.
    fitted : Fitted
        The model as it was fitted: where the profile is centred, and what correlation does to its errors.
    name : str
        The term.
    confidence : float
        Probability that the interval is meant to have.
    """
    shape = next(term for term in fitted.terms if term in SATURATIONS)
    own = profiles[SATURATIONS.index(shape)]
    names = fitted.regression.names
    freedom = grid.rows - len(names)
    quantile = float(stats.t.ppf(0.5 + 0.5 * confidence, freedom))
    least = min(float(np.min(profile.squares)) for profile in profiles)
    if not math.isfinite(least):
        return fitted.estimate(name)[2:]
    variance = least / freedom
    place, bend = names.index(name), names.index(BENT[shape])
    covariance = fitted.regression.covariance
    given = covariance[place, place] - covariance[place, bend] ** 2 / covariance[bend, bend]  # the bend known
    nearest = int(np.argmin(np.abs(np.log(grid.speeds[shape] / fitted.values[BENT[shape]]))))
    inflation = max(1.0, float(np.max(fitted.inflation)))
    times = math.sqrt(max(given, 0.0)) / own.deviations[name][nearest]
    if covariance[bend, bend] < (SHARP * math.log(grid.speeds[shape][1] / grid.speeds[shape][0])) ** 2:
        ends = [*fitted.estimate(name)[2:]]  # the grid is too coarse for it, and the linearised interval is right
    else:
        half = quantile * math.sqrt(max(given, 0.0))
        ends = [fitted.values[name] - half, fitted.values[name] + half]
    for profile in profiles:
        usable = np.isfinite(profile.squares)
        if np.count_nonzero(usable) < 2:
            continue
        along = np.flatnonzero(usable).astype(np.float64)
        fine = np.linspace(along[0], along[-1], POINTS)
        squares, values, deviations = (
            PchipInterpolator(along, series[usable])(fine)
            for series in (profile.squares, profile.values[name], profile.deviations[name])
        )
        beyond = np.maximum(squares - least, 0.0) / (variance * inflation)
        allowed = beyond <= quantile**2
        half = times * deviations[allowed] * np.sqrt(quantile**2 - beyond[allowed])
        middle = values[allowed] + fitted.correction[place]
        ends += [*(middle - half), *(middle + half)]
    return min(ends), max(ends)
