"""Fits of a model to open-loop simulations of a log, from strong to weak shrinkage.

Minimized is ``<e^2>/(0.01 s)^2 + w (sum_k ((g_k - <g>)/Fc)^2 + sum_j c_j^2)`` with the errors ``e`` of the simulated
position, the standard deviation ``s`` of the position, the force ``g_k`` at the knots, the Coulomb friction ``Fc`` that
the fit starts from, at least a tenth of the standard deviation of the torque, and the coefficients ``c_j`` of a map of
friction. The weight ``w`` shrinks what depends on the position towards what does not (A. Hoerl, R. Kennard, "Ridge
regression", Technometrics 12, 1970), so the number of knots is a resolution, not a choice: choosing among subsets of
terms is unstable, and shrinkage is not (L. Breiman, "Heuristics of instability and stabilization in model selection",
Annals of Statistics 24, 1996).

Each fit goes towards its minimum by the method of Levenberg and Marquardt (J. More, 1978), with exact derivatives: a
fit that is cut short depends on where it starts, and on rounding. A motion that almost stops bends the error, and which
of many bends a fit ends at hangs on the last digits. So the corner of the Coulomb friction is first rounded far, where
bends are few, and then less and less, each fit started from the one before (continuation; E. Allgower, K. Georg,
"Numerical Continuation Methods", 1990); the fits that are rounded most follow each other from strong to weak shrinkage.
Friction that would drive the joint, with a negative Coulomb or viscous friction in either direction, is taken for none.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.identify.open_loop.simulation import OpenLoopModel
from adaptive_ff.identify.open_loop.slopes import Training, errors_and_slopes, parameters_of, with_parameters
from adaptive_ff.logs.derivatives import Array

UNIT = 0.01
"""Error that counts as one, in standard deviations of the position."""

STRIDE = 10
"""Every so many samples of a simulation count in a fit."""

STEPS = 60
"""Most steps of a fit."""

ENOUGH = 1e-4
"""Decrease that the next step promises, over the squares, below which a fit is at its minimum.

With 1e-6, fits with weak shrinkage are cut short by ``STEPS`` instead, while they go from bend to bend.
"""

DAMPING, LEAST_DAMPING, MOST_DAMPING = 1e-4, 1e-9, 1e6
"""First, least and largest damping of a step, over the diagonal of the normal equations."""

FLOOR = 1e-9
"""Least entry of this diagonal, over their trace."""


ROUNDINGS = (16.0, 1.0)
"""How far the corner of the Coulomb friction is rounded in the fits that follow each other, over ``SMOOTH``.

With (16, 4, 1) blocks held out of EMPS came out worse by 0.08 of 0.9 mm, with ``ENOUGH`` 1e-6.
"""


class Shrunk(NamedTuple):
    """A fit.

    Attributes
    ----------
    model : OpenLoopModel
        The model.
    parameters : float
        Effective number of its parameters, the trace of ``(A + W)^-1 A`` with normal equations ``A`` and weights ``W``.
    """

    model: OpenLoopModel
    parameters: float


class _Problem(NamedTuple):
    """A fit in units of its parameters: their scales, which are free, square roots of the weights, and the rounding."""

    begin: OpenLoopModel
    training: Training
    scales: Array
    free: NDArray[np.int64]
    weights: Array
    rounding: float = 1.0

    def at(self, parameters: Array) -> tuple[Array, Array]:
        """Return what is to be small, and its derivatives by the free parameters over their scales."""
        found = errors_and_slopes(with_parameters(self.begin, parameters), self.training, STRIDE, self.rounding)
        unit = UNIT * float(np.std(self.training.record.position)) * np.sqrt(found[0].size)
        left = np.concatenate([found[0] / unit, self.weights @ (parameters / self.scales)])
        slopes = np.vstack([found[1] * (self.scales / unit), self.weights])
        return left, slopes[:, self.free]


def fit_path(begin: OpenLoopModel, training: Training, weights: Sequence[float], *, by_direction: bool) -> list[Shrunk]:
    """Fit a model with each of some weights of the shrinkage, from where the one before it was rounded most.

    Parameters
    ----------
    begin : OpenLoopModel
        Where the first fit starts; its Coulomb friction, or a tenth of the torque's standard deviation where that is
        more, is the unit of the force.
    training : Training
        What is fitted.
    weights : sequence of float
        Weights of the shrinkage, from strong to weak.
    by_direction : bool
        Whether viscous friction may differ by direction.
    """
    record, knots = training.record, begin.force.size
    force = max(abs(begin.coulomb), 0.1 * float(np.std(record.torque)))
    damping = max(abs(begin.viscous), 0.01 * force / float(np.std(record.velocity)))
    scales = np.concatenate(
        [[begin.inertia, force, damping, damping], np.full(knots, force), np.ones(begin.coefficients.size)]
    )
    shrunk = np.eye(scales.size)[4:]
    shrunk[:knots, 4 : 4 + knots] -= 1.0 / knots
    free = np.array([index for index in range(scales.size) if index != 3 or by_direction])
    first = parameters_of(begin)
    first[1:3] = np.maximum(first[1:3], 0.0)
    made = []
    for weight in weights:
        problem = _Problem(begin, training, scales, free, np.sqrt(weight) * shrunk, ROUNDINGS[0])
        # the sharp fits are not handed on: they end at bends
        parameters, count = _minimize(problem, first)
        first = parameters
        for rounding in ROUNDINGS[1:]:
            parameters, count = _minimize(problem._replace(rounding=rounding), parameters)
        made.append(Shrunk(with_parameters(begin, parameters), count))
    return made


def _minimize(problem: _Problem, parameters: Array) -> tuple[Array, float]:
    """Return the parameters at the minimum, and their effective number."""
    left, slopes = problem.at(parameters)
    squares, damping, free = float(left @ left), DAMPING, problem.free
    for _ in range(STEPS):
        normal, gradient = slopes.T @ slopes, slopes.T @ left
        diagonal = np.diag(np.diag(normal) + FLOOR * np.trace(normal))
        better = False
        while damping < MOST_DAMPING and not better:
            step = -np.linalg.solve(normal + damping * diagonal, gradient)
            if float(-gradient @ step) < ENOUGH * squares:
                break
            trial = parameters.copy()
            trial[free] += step * problem.scales[free]
            trial = _braking(trial)
            if trial[0] > 0.0:
                next_left, next_slopes = problem.at(trial)
                better = float(next_left @ next_left) < squares
            if not better:
                damping *= 4.0
        if not better:
            break
        parameters, left, slopes, squares = trial, next_left, next_slopes, float(next_left @ next_left)
        damping = max(0.1 * damping, LEAST_DAMPING)
    fitted = slopes[: left.size - problem.weights.shape[0]]
    data, normal = fitted.T @ fitted, slopes.T @ slopes
    floor = 1e-12 * np.trace(normal) * np.eye(free.size)
    return parameters, float(np.trace(np.linalg.solve(normal + floor, data)))


def _braking(parameters: Array) -> Array:
    """Return the nearest parameters whose friction does not drive the joint in either direction."""
    braking = parameters.copy()
    braking[1:3] = np.maximum(braking[1:3], 0.0)
    braking[3] = min(max(braking[3], -braking[2]), braking[2])
    return braking
