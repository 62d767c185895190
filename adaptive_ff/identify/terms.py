"""Terms of the joint's equation: their names, what each stands for, and friction that bends at a speed."""

import numpy as np

from adaptive_ff.logs.derivatives import Array

Terms = tuple[str, ...]

BASE = ("inertia", "coulomb", "viscous")
"""Terms of every model."""

GRAVITY = ("gravity_sine", "gravity_cosine")
"""Terms of gravity, which come together."""

LAG, STICTION, ASYMMETRY = "friction_lag", "stiction_excess", "viscous_asymmetry"
SATURATION, SLOW_SATURATION, LONG_SATURATION = SATURATIONS = ("saturation", "slow_saturation", "long_saturation")
"""Further terms; stiction and the shapes of saturation exclude each other, as one log seldom determines two bends."""

SQUARE_STICTION = "square_stiction"
"""Stiction that falls with the square of the speed, a shape factor of two: never used, but intervals are taken over it
where a model with stiction is used and the log does not tell the two shapes apart, or where one with this shape
validates clearly better than the model that is used."""

JUMPING = (STICTION, SQUARE_STICTION)
"""Terms that bend at a speed, and jump where the motion turns, as Coulomb friction does."""

PATH = "presliding"
"""Term of friction that follows over a path, which is a property of the rows: all models of a log have it, or none."""

DAMPING = "bristle_damping"
"""Linear term that comes with it, in the place of a lag: what bristles add while they bend."""

DIRECT = ("inertia", "offset", *GRAVITY, DAMPING)
"""Linear terms that do not lag: those that are no friction, and the damping of bristles."""

FRICTION = ("coulomb", "viscous", ASYMMETRY)
"""Linear terms of friction."""

BENT = {
    STICTION: "stribeck_velocity",
    SQUARE_STICTION: "square_stribeck_velocity",
    SATURATION: "saturation_velocity",
    SLOW_SATURATION: "slow_saturation_velocity",
    LONG_SATURATION: "long_saturation_velocity",
}
"""Linear terms of friction that have a speed of their own, which is searched; ``stiction_excess`` is ``Fs - Fc``."""

FRICTION_OVER, FORCE_OVER = "friction_over_", "force_over_"
"""How terms of a map begin: friction over position or load, and a force over position."""

LOAD = FRICTION_OVER + "load"
"""Term of friction that rises with the known torque."""


def is_mapped(term: str) -> bool:
    """Tell whether a term is one of a map."""
    return term.startswith((FRICTION_OVER, FORCE_OVER))


def mapped_word(term: str) -> str:
    """Return what a term of a map stands for."""
    if term == LOAD:
        return "friction over load"
    return "force over position" if term.startswith(FORCE_OVER) else "friction over position"


def jumps_at_reversal(terms: Terms) -> bool:
    """Tell whether friction jumps at once where the motion turns, so that the joint may stand there."""
    return PATH not in terms and (STICTION in terms or not {LAG, *SATURATIONS} & {*terms})


def bent_friction(term: str, velocity: Array, bend: float) -> Array:
    """Return friction that bends at a speed, over its size."""
    relative = velocity / bend
    if term == SATURATION:
        return np.asarray(np.tanh(relative))
    if term == LONG_SATURATION:
        return np.asarray(relative / (1.0 + np.abs(relative)))
    if term == SQUARE_STICTION:
        return np.asarray(np.sign(relative) * np.exp(-np.square(relative)))
    share = np.exp(-np.abs(relative))
    return np.asarray(np.sign(relative) * (share if term == STICTION else 1.0 - share))
