"""Whether a machine was another one while what was held out was recorded, or a model of the rest is just worse there.

A model lacks something everywhere: other axes that move now and then, ripple, a load. Its error then differs from
stretch to stretch of one log of a machine that stays as it is. How much, cross-validation has seen on blocks of the
fitted part, each left by a fit to the others. What was held out is so many such blocks, whose mean square scatters by
the deviation of a block over the root of their number, about the mean of the others, which scatters as well. And
another friction or inertia must explain it: where other values of the same terms neither come down to 1.5 times the
error of the fit nor leave less than a tenth of the mean square, the model lacks something.
"""

import math

import numpy as np

from adaptive_ff.identify.fitting.fit import fit_terms
from adaptive_ff.identify.fitting.prediction import TorqueError, predict, torque_error
from adaptive_ff.identify.fitting.term_selection import Selection
from adaptive_ff.identify.rows.regressors import Problem, design
from adaptive_ff.identify.terms import GRAVITY
from adaptive_ff.logs.derivatives import Array

WORSE = 1.5
"""Error of the validation over that of the fit from which the former may be worse."""

DEVIATIONS = 3.0
"""Standard deviations of what scatter explains, by which a mean square must exceed the mean of the blocks. With ten
blocks, Student's t exceeds that in 0.7 % of the cases."""

EXPLAINED = 0.1
"""Share of the mean square error that other values of the same terms may leave: where another machine is noisier, or
sticks more, they leave more than of the fitted part."""


def is_larger(fit: TorqueError, validation: TorqueError) -> bool:
    """Tell whether the error of what was held out is much larger than that of the fit, by chance or not."""
    return validation.rms_error > WORSE * fit.rms_error


def has_changed(
    held: Problem, selection: Selection, fit: TorqueError, validation: TorqueError, confidence: float
) -> bool:
    """Tell whether what was held out speaks for another friction or inertia there.

    It does where its error is beyond what scatter between blocks explains, and the same terms with other values leave
    there no more than ``WORSE`` times the error of the fit, or next to nothing of what the fit leaves.

    Parameters
    ----------
    held : Problem
        The rows that were held out.
    selection : Selection
        The models with their errors on blocks.
    fit, validation : TorqueError
        Errors of the fit, and on what was held out.
    confidence : float
        Probability that the intervals are meant to have.
    """
    if not _is_beyond_scatter(selection, fit, validation):
        return False
    chosen = selection.chosen
    try:
        error = torque_error(predict(held, fit_terms(held, chosen.terms, confidence, start=chosen.searched)))
    except ValueError:
        return False  # the rows do not determine other values
    return error is not None and _explains(error.rms_error, fit, validation)


def error_with_other_load(
    held: Problem, selection: Selection, fit: TorqueError, validation: TorqueError
) -> float | None:
    """Return what is left of what was held out with another gravity and offset, N m; None where it is no reason.

    Inertia and friction stay as they are. That is so of another load or sensor's zero, and where the position is
    counted from another zero. The arguments are those of ``has_changed``, whose rules hold here, too.
    """
    chosen = selection.chosen
    terms = [term for term in chosen.linear if term in ("offset", *GRAVITY)]
    if not terms or not _is_beyond_scatter(selection, fit, validation):
        return None
    rows = predict(held, chosen)
    left = np.concatenate([(piece.torque - piece.fitted)[piece.slides] for piece in rows])
    columns = design(held, terms, {})
    error = float(np.sqrt(np.mean((left - columns @ np.linalg.lstsq(columns, left)[0]) ** 2)))
    return error if _explains(error, fit, validation) else None


def _is_beyond_scatter(selection: Selection, fit: TorqueError, validation: TorqueError) -> bool:
    """Tell whether an error of what was held out is larger than what scatter between blocks explains."""
    if not is_larger(fit, validation):
        return False
    squares = block_squares(selection, fit)
    blocks = max(1.0, validation.duration / fit.duration * squares.size)
    scatter = float(np.std(squares, ddof=1)) * math.sqrt(1.0 / blocks + 1.0 / squares.size)
    return validation.rms_error**2 > float(np.mean(squares)) + DEVIATIONS * scatter


def _explains(error: float, fit: TorqueError, validation: TorqueError) -> bool:
    """Tell whether other values, which leave some error on what was held out, N m, explain it."""
    return error <= WORSE * fit.rms_error or error**2 <= EXPLAINED * validation.rms_error**2


def block_squares(selection: Selection, fit: TorqueError) -> Array:
    """Return the mean square of the chosen model on each block that was left out of its fit, N^2 m^2."""
    held = next(model.held for model in selection.validated if model.terms == selection.chosen.terms)
    whole = (fit.rms_error / fit.relative_error) ** 2 if fit.relative_error > 0.0 else 0.0
    squares: Array = held * held.size * whole
    return squares
