"""Whether friction may lag as it does on bristles, where viscous friction does not lag.

In the model all friction lags, viscous friction too, which makes a part ``-sigma tau a`` of it. Friction on bristles
(LuGre, Maxwell slip) lags only where it jumps, at reversals, and viscous friction follows the velocity at once. In a
band that is slow against the lag a log hardly tells one from the other: inertia is ``J`` in the first case and
``J - sigma tau`` in the second one. So the chosen terms are fitted once more with viscous friction that does not lag,
and where that leaves no more than chance explains, intervals are taken over it, too.

What does tell them apart is ``sigma tau^2`` times the jerk, and a torque that acts a delay later has ``J delay`` of it
(:mod:`adaptive_ff.identify.alternatives.held_torque`). Where that delay is not told, the torque may act up to a sample
time after its stamp. So is it where friction follows over a path
(:mod:`adaptive_ff.identify.alternatives.bristle_path`), and nothing lags.
"""

import numpy as np

from adaptive_ff.identify.alternatives.held_torque import gain, rows_of_later
from adaptive_ff.identify.fitting.cross_validation import ALIKE
from adaptive_ff.identify.fitting.fit import fit_terms
from adaptive_ff.identify.fitting.fitted import Fitted
from adaptive_ff.identify.preparation import Prepared
from adaptive_ff.identify.rows.regressors import Problem
from adaptive_ff.identify.terms import ASYMMETRY, LAG, PATH
from adaptive_ff.logs.defects import Piece

DELAYS = (0.0, 0.5, 1.0)
"""Times after its stamp at which a torque may act, over the sample time; between them the squares are a parabola."""


def fit_on_bristles(
    problem: Problem, prepared: Prepared, pieces: list[Piece], chosen: Fitted, *, delay_told: bool
) -> Fitted | None:
    """Return the fit of a model whose viscous friction does not lag; None where the log tells that it does.

    Parameters
    ----------
    problem : Problem
        The rows.
    prepared : Prepared
        The log that they come from.
    pieces : list of Piece
        Its pieces, in the order of the problem's.
    chosen : Fitted
        The model; there is no such fit of one without a lag or a path, and of one with a path where the delay is told.
    delay_told : bool
        Whether it is known when the torque acts.
    """
    if LAG not in chosen.terms and (PATH not in chosen.terms or delay_told):
        return None
    rows = problem._replace(unlagged=("viscous", ASYMMETRY))

    def fitted_at(share: float) -> Fitted:
        later = rows_of_later(rows, prepared, pieces, share * prepared.period) if share > 0.0 else rows
        return fit_terms(later, chosen.terms, chosen.regression.confidence, start=chosen.searched)

    try:
        fits = [fitted_at(share) for share in (DELAYS[:1] if delay_told else DELAYS)]
        least = DELAYS[0] if delay_told else _least([fitted.squares for fitted in fits])
        if least not in DELAYS:
            fits.append(fitted_at(least))
    except ValueError:
        return None
    best = min(fits, key=lambda fitted: fitted.squares)
    less, deviation = gain(chosen, best)
    return best if less >= -ALIKE * deviation else None


def _least(squares: list[float]) -> float:
    """Return where, in ``DELAYS``, the parabola through the squares has its least value."""
    curvature, slope, _ = np.polyfit(DELAYS, squares, 2)
    if curvature <= 0.0:  # then it is at an end
        return DELAYS[int(np.argmin(squares))]
    return float(np.clip(-0.5 * slope / curvature, DELAYS[0], DELAYS[-1]))
