"""Parameters of a joint with their units and unit torques: what each takes of the torque of a motion."""

import math
import re
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
import scipy

from adaptive_ff.friction.columns import COULOMB, PATHS, STICTION, VISCOUS, Curve, Hypothesis, columns_along
from adaptive_ff.identify.motion import Array, Rows, derivative
from adaptive_ff.scenario.axis_units import of_linear

TEXTBOOK = ("inertia", "coulomb", "viscous", "offset")
"""What everybody fits ..."""

GRAVITY = ("gravity_sine", "gravity_cosine")
"""... and what a weight on a rotary axis adds."""

CARRIED = ("inertia", *GRAVITY)
"""Terms whose torque a gear carries."""

ASYMMETRY = "viscous_asymmetry"
"""What friction differs by between both directions."""

FRICTION = frozenset({"coulomb", "stiction_excess", "load_friction", "viscous", ASYMMETRY})
"""Terms of friction, beside those of a map of it."""

ROTARY = {
    "inertia": "kg m²",
    **dict.fromkeys(("viscous", "viscous_asymmetry"), "N m s/rad"),
    **dict.fromkeys(("coulomb", "offset", "gravity_sine", "gravity_cosine", "stiction_excess", "torque"), "N m"),
    **dict.fromkeys(("friction_lag", "torque_delay"), "s"),
    **dict.fromkeys(("stribeck_velocity", "velocity"), "rad/s"),
    "path": "rad",
    "load_friction": "",
}
"""Units of a rotary joint; what is over position is in those of the torque."""

LINEAR = {name: of_linear(unit) for name, unit in ROTARY.items()}
"""Units of a linear axis."""

NO_LAG, NO_SPEED = 1e-6, 1e-9
"""Friction lag, s, and Stribeck velocity, rad/s, of a model that has none."""


def of_current(units: Mapping[str, str]) -> dict[str, str]:
    """Return units where the torque, or force, is given as a current, A: inertia is then in A s²/rad, or A s²/m."""
    masses = {"kg m²": "A s²/rad", "kg": "A s²/m"}
    return {name: masses.get(unit, re.sub("^N( m)?", "A", unit)) for name, unit in units.items()}


def unit_of(units: Mapping[str, str], name: str) -> str:
    """Return the unit of a parameter; those of a map over position are torques."""
    return units.get(name, units["torque"])


def is_friction(name: str) -> bool:
    """Tell whether a term is friction."""
    return name in FRICTION or name.startswith("friction_")


def is_mapped(name: str) -> bool:
    """Tell whether a parameter is a part of friction or force over position."""
    return name.startswith(("force_", "friction_")) and name != "friction_lag"


class Shape(NamedTuple):
    """What unit torques depend on other than linearly; zero where the joint does without.

    Time constant with which friction follows its static curve, s; displacement over which Coulomb friction turns after
    a reversal, rad; speed over which friction passes from ``coulomb + stiction_excess`` to ``coulomb``, rad/s. Inertia
    and both parts of gravity, whose torque a gear carries, so that friction rises with it; empty: the known torque.
    """

    friction_lag: float = 0.0
    path: float = 0.0
    stribeck_velocity: float = 0.0
    load: tuple[float, ...] = ()

    @property
    def bends(self) -> dict[str, float]:
        """The numbers of friction's shape that are not zero, by name."""
        return {name: value for name, value in self._asdict().items() if value and name != "load"}


class Map(NamedTuple):
    """Known dependence on position: harmonics of periods, rad, or hats between two positions, rad."""

    periods: tuple[float, ...] = ()
    hats: int = 0
    low: float = 0.0
    high: float = 1.0

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the fractions of the map; of hats all but the first, which Coulomb friction and the offset are."""
        waves = tuple(f"{part}_{place}" for place in range(1, len(self.periods) + 1) for part in ("sine", "cosine"))
        return waves + tuple(f"hat_{place}" for place in range(2, self.hats + 1))

    def fraction(self, name: str, position: Array) -> Array:
        """Return one fraction of the map at some positions."""
        kind, _, number = name.rpartition("_")
        place = int(number) - 1
        if kind == "hat":
            tops = np.linspace(self.low, self.high, self.hats)
            return np.asarray(np.interp(position, tops, np.eye(self.hats)[place]))
        return (np.sin if kind == "sine" else np.cos)(2.0 * np.pi * position / self.periods[place])


def unit_torques(rows: Rows, names: tuple[str, ...], shape: Shape, place: Map) -> Array:
    """Return the unit torques in the band at the rows that slide, one column a name."""
    friction = _friction(rows, shape, place) if any(map(is_friction, names)) else {}
    columns = [friction[name] if name in friction else _unit(rows, name, place) for name in names]
    return np.asarray(rows.in_band(np.column_stack(columns))[rows.kept])


def _unit(rows: Rows, name: str, place: Map) -> Array:
    """Return a unit torque that depends on the motion at its time alone."""
    if name.startswith("force_"):
        return place.fraction(name.removeprefix("force_"), rows.position)
    units: dict[str, Callable[[], Array]] = {
        "inertia": lambda: derivative(rows.velocity, rows.period),
        "offset": lambda: np.ones_like(rows.velocity),
        "gravity_sine": lambda: np.sin(rows.position),
        "gravity_cosine": lambda: np.cos(rows.position),
        "torque_delay": lambda: derivative(rows.torque, rows.period),
    }
    return units[name]()


def _friction(rows: Rows, shape: Shape, place: Map) -> dict[str, Array]:
    """Return the columns of friction, which remember the motion: those of the friction hypothesis."""
    paths = np.array([shape.path] if shape.path else [])
    hypothesis = Hypothesis(1.0, paths, True, np.empty(0), np.empty(0), 0, 0.0, 1.0, False, 0, 1.0)
    curve = Curve(max(shape.friction_lag, NO_LAG), shape.stribeck_velocity or NO_SPEED, 1.0, 1.0, 1.0, 0.0)
    columns = columns_along(hypothesis, curve, rows.between(), rows.period)
    # dry friction is as large as the expected sign of the velocity, given the measured one
    dry = columns.T * scipy.special.erf(np.abs(rows.velocity) / (math.sqrt(2.0) * max(rows.noise, NO_SPEED)))
    sign, load = dry[COULOMB] + dry[STICTION], rows.known
    if shape.load:
        load = rows.in_band(np.column_stack([_unit(rows, name, place) for name in CARRIED])) @ np.array(shape.load)
    return {
        "viscous": columns[:, VISCOUS],
        ASYMMETRY: columns[:, PATHS + paths.size + 1],
        "coulomb": dry[PATHS] if shape.path else sign,
        "stiction_excess": dry[STICTION],
        "load_friction": sign * np.abs(load),
        **{f"friction_{name}": sign * place.fraction(name, rows.position) for name in place.names},
    }
