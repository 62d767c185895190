"""The Stribeck curve (3) as a least-squares problem that is linear but for ``Vs`` and ``delta``.

For given ``Vs`` and ``delta`` the curve is linear in ``Fc``, ``Fs - Fc`` and ``sigma``, none of them negative, and in
an offset. So only ``log Vs`` and ``log delta`` need be searched, and every evaluation solves the linear rest (variable
projection: G. Golub, V. Pereyra, SIAM J. Numer. Anal. 10, 1973; derivative by L. Kaufman, BIT 15, 1975). The signs
matter: without them noisy points are fitted best by curves such as ``Fc`` = -736 N m, ``Vs`` = 5.6 rad/s.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

Array = NDArray[np.float64]

BEND = ("stribeck_velocity", "stribeck_shape")
"""Parameters that are searched, as logarithms."""

LARGEST_EXPONENT = 50.0
"""The exponent ``(|w|/Vs)^delta`` is cut off here: the share of stiction is zero long before."""

FLAT = 1e-10
"""Relative size below which columns count as dependent, and slopes as zero."""


class Points(NamedTuple):
    """Points to be fitted.

    Attributes
    ----------
    velocity, torque : ndarray, shape (n,)
        Velocity (rad/s), of either sign, and torque (N m).
    weight : ndarray, shape (n,)
        One over the standard error of the torque.
    with_offset : bool
        Whether the torque may have an offset.
    """

    velocity: Array
    torque: Array
    weight: Array
    with_offset: bool


class Problem(NamedTuple):
    """Weighted points, perhaps with one parameter held, for a search of ``bend = (log Vs, log delta)``.

    Attributes
    ----------
    log_speed : ndarray, shape (n,)
        ``log |w|``.
    signed : ndarray, shape (n,)
        Weight with the sign of the velocity.
    target : ndarray, shape (n,)
        What the columns are to add up to.
    fixed : ndarray, shape (n, m)
        Columns that do not depend on the bend: of ``Fc`` and ``sigma``, where these are free.
    basis : ndarray, shape (n, m)
        Orthonormal basis of them, ``Q`` of ``fixed = Q R``.
    inverse : ndarray, shape (m, m)
        Inverse of ``R``.
    shift : ndarray, shape (n,)
        Taken from the column of ``Fs - Fc``: the column of ``Fc`` where ``Fs`` is held, else zero.
    mean : ndarray, shape (n,)
        Unit vector of the offset, which is taken out of all columns; zero where there is none.
    bend : ndarray, shape (2,)
        Held values of ``log Vs`` and ``log delta``; not a number where free.
    """

    log_speed: Array
    signed: Array
    target: Array
    fixed: Array
    basis: Array
    inverse: Array
    shift: Array
    mean: Array
    bend: Array


class Solved(NamedTuple):
    """The linear rest, solved for at a bend.

    Attributes
    ----------
    coefficients : ndarray, shape (m + 1,)
        ``Fs - Fc``, then one for each fixed column; none is negative.
    residuals : ndarray, shape (n,)
        Fitted minus measured, weighted.
    basis : ndarray, shape (n, active)
        Orthonormal basis of the columns that take part.
    """

    coefficients: Array
    residuals: Array
    basis: Array


def make_problem(points: Points, name: str = "", value: float = 0.0) -> Problem:
    """Return the problem of fitting points, perhaps with a parameter held at a value (Vs, delta as logarithms)."""
    velocity, torque, weight, with_offset = points
    free_offset = with_offset and name != "offset"
    mean = weight / np.linalg.norm(weight) if free_offset else np.zeros_like(weight)
    signed = np.sign(velocity) * weight
    columns = {"coulomb": _centred(signed, mean), "viscous": _centred(velocity * weight, mean)}
    taken = {**columns, "stiction": columns["coulomb"], "offset": weight}
    target = _centred(torque * weight, mean)
    if name in taken:
        target = target - value * taken[name]
    solved = [column for key, column in columns.items() if key != name and (key, name) != ("coulomb", "stiction")]
    shift = columns["coulomb"] if name == "stiction" else np.zeros_like(weight)
    bend = np.array([value if key == name else math.nan for key in BEND])
    fixed = np.column_stack(solved)
    basis, triangle = np.linalg.qr(fixed)
    log_speed = np.log(np.abs(velocity))
    return Problem(
        log_speed=log_speed,
        signed=signed,
        target=target,
        fixed=fixed,
        basis=basis,
        inverse=np.linalg.inv(triangle),
        shift=shift,
        mean=mean,
        bend=bend,
    )


def _centred(column: Array, mean: Array) -> Array:
    """Return a column without what an offset takes up."""
    centred: Array = column - mean * float(mean @ column)
    return centred


def exponent(log_speed: Array, bend: Array) -> tuple[Array, Array]:
    """Return ``x = (|w|/Vs)^delta`` and ``log(|w|/Vs)``; the share of stiction is ``exp(-x)``."""
    ratio = log_speed - bend[0]
    return np.exp(np.minimum(math.exp(bend[1]) * ratio, math.log(LARGEST_EXPONENT))), ratio


def solve_linear(problem: Problem, bend: Array) -> Solved:
    """Solve for what is linear, by orthogonal factors; where a coefficient would be negative, with it at zero."""
    share = np.exp(-exponent(problem.log_speed, bend)[0])
    falling = _centred(share * problem.signed, problem.mean) - problem.shift
    across = falling - problem.basis @ (falling @ problem.basis)
    across -= problem.basis @ (across @ problem.basis)  # twice, or rounding would leave a part
    square = float(across @ across)
    if square > FLAT**2 * float(falling @ falling):
        excess = float(across @ problem.target) / square
        rest = problem.inverse @ ((problem.target - excess * falling) @ problem.basis)
        if excess >= 0.0 and rest.min() >= 0.0:
            residuals = problem.fixed @ rest + excess * falling - problem.target
            basis = np.column_stack([problem.basis, across / math.sqrt(square)])
            return Solved(np.append(excess, rest), residuals, basis)
    columns = np.column_stack([falling, problem.fixed])
    found = nnls(columns, problem.target)[0]
    return Solved(found, columns @ found - problem.target, np.linalg.qr(columns[:, found > 0.0])[0])


def bend_slopes(problem: Problem, bend: Array, solved: Solved) -> Array:
    """Return the derivatives of the residuals by ``log Vs`` and ``log delta``, the rest solved for; shape (n, 2)."""
    power, ratio = exponent(problem.log_speed, bend)
    by_velocity = solved.coefficients[0] * problem.signed * np.exp(-power) * power * math.exp(bend[1])
    columns = np.column_stack([by_velocity, -by_velocity * ratio])
    columns -= np.outer(problem.mean, problem.mean @ columns)
    columns -= solved.basis @ (solved.basis.T @ columns)  # what the linear rest takes up
    felt = np.linalg.norm(columns, axis=0) > FLAT * np.linalg.norm(problem.target)
    slopes: Array = columns * felt
    return slopes
