"""Models that a log is compared with: which terms a family may have."""

from itertools import product

from adaptive_ff.errors import InputError
from adaptive_ff.identify.terms import ASYMMETRY, BASE, GRAVITY, LAG, SATURATIONS, STICTION, Terms

WITHIN = (LAG, STICTION, *SATURATIONS)
"""Terms that models of one family may differ by: the shape of friction, which every reversal shows."""

FAMILIES = {
    "coulomb-viscous": ("offset",),
    "symmetric": (),
    "offset": ("offset",),
    "directions": ("offset", ASYMMETRY),
    "gravity": ("offset", *GRAVITY),
    "gravity-directions": ("offset", *GRAVITY, ASYMMETRY),
}
"""Terms beside the base and beside lag, stiction and saturation, by the name that a user gives; the first
one, that of most published parameters, has none of these either."""

AUTO = "auto"
"""Name of the choice among all families."""


def family_of(terms: Terms) -> Terms:
    """Return the terms of a model that all models of its family have."""
    return tuple(term for term in terms if term not in WITHIN)


def candidate_models(family: str, *, both_ways: bool, gravity: bool) -> list[Terms]:
    """Return the models that a log is compared with, the simplest first.

    Parameters
    ----------
    family : str
        Key of ``FAMILIES``, whose terms are then part of every model, or ``AUTO``.
    both_ways : bool
        Whether the joint moves both ways; else an offset is no term, as it cannot be separated from Coulomb friction,
        and neither is friction by direction.
    gravity : bool
        Whether the log can have terms of gravity: a position of a rotary joint.

    Raises
    ------
    InputError
        There is no such family, or it has terms of gravity and the log cannot have them.
    """
    if not isinstance(family, str) or (family != AUTO and family not in FAMILIES):
        raise InputError(f"model = {family!r} is not allowed: it must be {AUTO} or one of {', '.join(FAMILIES)}")
    if family != AUTO and GRAVITY[0] in FAMILIES[family] and not gravity:
        raise InputError(f"model = {family!r} is not allowed: gravity takes the position of a rotary joint")
    if family == AUTO:
        sides = [
            FAMILIES[name]
            for name in FAMILIES
            if name not in ("symmetric", "coulomb-viscous") and (gravity or "gravity" not in name)
        ]
    else:
        sides = [FAMILIES[family]]
    plain = family == "coulomb-viscous"
    lags = ((),) if plain else ((), (LAG,))
    bends = ((),) if plain else ((), (STICTION,), *((shape,) for shape in SATURATIONS))
    made: dict[Terms, None] = {}
    for side, lag, bend in product(sides, lags, bends):
        kept = side if both_ways else tuple(term for term in side if term not in ("offset", ASYMMETRY))
        made[(*BASE, *kept, *bend, *lag)] = None
    return sorted(made, key=len)
