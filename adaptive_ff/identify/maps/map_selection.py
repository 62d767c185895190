"""Whether friction, or a force, depends on position and load: chosen as every other term of a model.

First a model without a map is chosen. Then the same models, each of them with a force over position and, those whose
friction has its shape or a simpler one, with each part of the map that is asked for, are validated on blocks that were
held out, and chosen among by the same rule. As the map multiplies the friction of the first model, which took its mean,
that is done once more with the friction of the model that was chosen. Of a ripple whose period the log itself shows
(:mod:`adaptive_ff.identify.maps.ripple`) there is a force only.
"""

from collections.abc import Sequence

from adaptive_ff.errors import InputError
from adaptive_ff.identify.fitting.families import WITHIN
from adaptive_ff.identify.fitting.term_selection import Selection, select_among
from adaptive_ff.identify.maps.map_columns import MapAsked, MapBasis, excludes, map_basis, with_map
from adaptive_ff.identify.preparation import Prepared
from adaptive_ff.identify.rows.regressors import Problem
from adaptive_ff.identify.terms import FORCE_OVER, FRICTION_OVER, Terms
from adaptive_ff.logs.defects import Piece

PASSES = 2
"""How often the map is fitted, each time to the friction of the model before."""


def select_map(
    problem: Problem,
    prepared: Prepared,
    pieces: Sequence[Piece],
    selection: Selection,
    asked: MapAsked,
    confidence: float,
) -> tuple[Problem, Selection, MapBasis]:
    """Choose a model once more, among those with a map, too.

    Parameters
    ----------
    problem : Problem
        The rows.
    prepared : Prepared
        The log that they come from.
    pieces : sequence of Piece
        Its pieces, in the order of the problem's.
    selection : Selection
        What was chosen without a map.
    asked : MapAsked
        What the map may depend on.
    confidence : float
        Probability that the intervals are meant to have.

    Returns
    -------
    Problem
        The rows with the columns of the map.
    Selection
        What is chosen.
    MapBasis
        The functions of the map.

    Raises
    ------
    InputError
        There is no friction that could depend on anything.
    """
    if selection.chosen.values["coulomb"] <= 0.0:
        raise InputError(
            f"{prepared.log.name}: a map takes friction, and Coulomb friction comes out negative without one; identify "
            "the log without a map, or one on which the joint moves both ways"
        )
    basis = map_basis(asked, prepared, pieces)
    plain = selection.models
    for _ in range(PASSES):
        problem = with_map(problem, prepared, pieces, basis, selection.chosen)
        models = [*plain, *_mapped(plain, selection.chosen.terms, basis)]
        varied = selection.chosen
        selection = select_among(problem, sorted(models, key=len), confidence)._replace(varied=varied)
        varies = any(term.startswith(FRICTION_OVER) for term in selection.chosen.terms)
        if not varies or selection.chosen.values["coulomb"] <= 0.0:
            break
    return problem, selection, basis


def _mapped(plain: Sequence[Terms], chosen: Terms, basis: MapBasis) -> list[Terms]:
    """Return the models with a map: any with one of force, those of the chosen shape or a simpler one with any."""
    shapes = {term for term in chosen if term in WITHIN}
    return [
        (*model, *terms)
        for model in plain
        for terms in basis.models()
        if not excludes(model, terms)
        and (all(term.startswith(FORCE_OVER) for term in terms) or {*model} & {*WITHIN} <= shapes)
    ]
