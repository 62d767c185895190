"""Models of a log, fitted: terms with the shape of their columns, parameters with their intervals."""

import math
from typing import NamedTuple

import numpy as np

from adaptive_ff.identify.columns import DRY, VISCOUS, Map, Shape, unit_torques
from adaptive_ff.identify.motion import Array
from adaptive_ff.identify.preparation import Prepared
from adaptive_ff.identify.regression import Folds, sums


class Model(NamedTuple):
    """Terms of a model, and the shape of their columns."""

    names: tuple[str, ...]
    shape: Shape = Shape()


class Parameter(NamedTuple):
    """A parameter with its interval."""

    value: float
    lower: float
    upper: float

    @property
    def half_width(self) -> float:
        """Half width of the interval over the value."""
        return 0.5 * (self.upper - self.lower) / abs(self.value) if self.value else math.inf


class Fit(NamedTuple):
    """A fitted model with its parameters, and what it leaves of folds that were left out of the fit, rms over rms."""

    model: Model
    parameters: dict[str, Parameter]
    left: float

    @property
    def values(self) -> dict[str, float]:
        """Estimates by name."""
        return {name: one.value for name, one in self.parameters.items()}


class Data(NamedTuple):
    """All sliding rows of a log, and what may be asked of them; ``load`` is that of a :class:`Shape`."""

    prepared: Prepared
    place: Map
    rotary: bool
    narrower: Prepared | None = None
    load: tuple[float, ...] = ()

    def columns(self, names: tuple[str, ...], shape: Shape) -> Array:
        """Return columns of all segments."""
        return np.concatenate([unit_torques(rows, names, shape, self.place) for rows in self.prepared.rows])

    def modelled(self, fit: Fit) -> Array:
        """Return the torque of a model in the band at the rows."""
        return np.asarray(self.columns(*fit.model) @ [fit.values[name] for name in fit.model.names])

    def left(self, fit: Fit) -> float:
        """Return what a model leaves of the torque, rms over rms."""
        torque = self.prepared.torque
        return math.sqrt(float(np.mean((torque - self.modelled(fit)) ** 2)) / float(np.mean(torque**2)))

    def sums(self, names: tuple[str, ...], columns: Array) -> Folds:
        """Return the sums of some columns by fold."""
        return sums(names, columns, self.prepared.torque, self.prepared.fold, self.prepared.noise)

    def fit(self, model: Model) -> Folds:
        """Return the sums of a model."""
        return self.sums(model.names, self.columns(*model))


def is_friction(name: str) -> bool:
    """Return whether a term is friction."""
    return name in DRY | VISCOUS or name.startswith("friction_")
