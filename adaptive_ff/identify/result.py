"""An identified joint: its models with their intervals, how far they can be used, and what a controller makes of them.

Codes, values and units; :mod:`adaptive_ff.report` words them.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from statistics import NormalDist
from typing import Any

import numpy as np

from adaptive_ff.errors import InputError, check_among, check_positive
from adaptive_ff.friction.identifying import ALL_CHOICES, check_parameters
from adaptive_ff.friction.model import GRAVITY, IDENTIFIED, TorqueModel
from adaptive_ff.identify.columns import ASYMMETRY, ROTARY, Shape, unit_of
from adaptive_ff.identify.motion import TUNING, Array
from adaptive_ff.identify.preparation import Prepared
from adaptive_ff.identify.regression import Fit, Parameter
from adaptive_ff.identify.simulators import simulator_text
from adaptive_ff.reported import Reported

GOOD, CARE, UNUSABLE = "good", "usable with care", "not usable"

LEFT = {GOOD: 0.15, CARE: 0.5}
"""Fraction of the torque (rms about its mean, of folds that were left out) that may be left."""

NEEDED = ("inertia", "coulomb", "viscous")
"""What a simulated joint needs."""

REPORTED_AS = dict(zip(GRAVITY, ("gravity_sine", "gravity_cosine"), strict=True))
"""Names in an identification of what controllers call otherwise."""


@dataclass(frozen=True, eq=False, repr=False)
class LogIdentification(Reported):
    """A joint identified from a log, with what a controller, a simulator or a script makes of it.

    Attributes
    ----------
    data : Prepared
        The log as it was fitted: cleaned, in its band, with what was not used of it.
    units : dict of str
        Units by name of the parameter, and of ``torque`` and ``velocity``.
    textbook, refined : Fit, and Fit or None
        The textbook's model, and what refinements make of it; None where none is taken.
    taken : tuple of str
        The refinements.
    unidentified : dict of str
        Textbook parameters that the motion does not determine, with the code of the reason.
    confidence : float
        Probability that the intervals are meant to have.
    validation : float or None
        What the best model leaves of the torque that it was validated on, rms over that torque's about its mean.
    validated_on : str
        What that is.
    cautions : list of str
        What was done to the log, or is probably wrong with it, a sentence each.
    """

    _drawn_by = "plot_identification"
    simulator = simulator_text

    data: Prepared
    units: dict[str, str]
    textbook: Fit
    refined: Fit | None
    taken: tuple[str, ...]
    unidentified: dict[str, str]
    confidence: float
    validation: float | None = None
    validated_on: str = ""
    cautions: list[str] = field(default_factory=list)

    def __repr__(self) -> str:
        """Return name and textbook parameters."""
        values = ", ".join(f"{name}={value:.4g}" for name, value in self.textbook.values.items())
        return f"{type(self).__name__}({self.name!r}, {values})"

    @property
    def name(self) -> str:
        """Where the log comes from."""
        return self.data.log.name

    @property
    def best(self) -> Fit:
        """The model that is written: the refined one where there is one."""
        return self.refined or self.textbook

    @property
    def parameters(self) -> dict[str, Parameter]:
        """The textbook's parameters with their intervals."""
        return self.textbook.parameters

    def value(self, name: str) -> float:
        """Return a parameter of the best model; zero where it does without. ``InputError``: no model has that name."""
        maps = (f"{kind}_{part}" for kind in ("friction", "force") for part in self.data.place.names)
        check_among("the parameter ", name, [one for one in (*ROTARY, *maps) if one not in ("torque", "velocity")])
        return self.best.values.get(name, 0.0)

    @property
    def joint_parameters(self) -> dict[str, Parameter]:
        """Parameters of a joint that is simulated, with intervals: the best model's.

        Of a curve that dips at low speed Coulomb and viscous friction are the textbook's, as no simulated joint dips.
        """
        found = dict(self.best.parameters)
        if self.value("stiction_excess") < 0.0:
            del found["stiction_excess"], found["stribeck_velocity"]
            found |= {name: one for name, one in self.parameters.items() if name in ("coulomb", "viscous")}
        return found

    def check_joint(self, what: str, needed: Sequence[str] = ("inertia", "coulomb")) -> None:
        """Raise ``InputError`` where inertia or Coulomb friction is not identified, so that there is nothing such."""
        for name in needed:
            if name in self.unidentified or (name == "inertia" and self.value(name) <= 0.0):
                said = name.replace("coulomb", "Coulomb friction")
                raise InputError(f"{self.name}: the {said} is not identifiable, so there is no {what}")

    @property
    def source(self) -> str:
        """Name of the log's file, without its folder."""
        return " ".join(Path(self.name).name.split())

    @property
    def given(self) -> list[str]:
        """Parameters of a controller that the log does not identify: they are given, or assumed."""
        known = {"stiction" if name == "stiction_excess" else name for name in self.joint_parameters}
        wanted = (*NEEDED, "offset", "stiction", "friction_lag", "stribeck_velocity")
        return [name for name in wanted if name not in known]

    @property
    def linear(self) -> bool:
        """Whether it is a linear axis."""
        return self.units["velocity"] == "m/s"

    @property
    def gravity(self) -> tuple[float, float]:
        """Amplitude, N m, and phase, rad, of gravity: ``amplitude sin(q + phase)``."""
        sine, cosine = self.value("gravity_sine"), self.value("gravity_cosine")
        return math.hypot(sine, cosine), math.atan2(cosine, sine)

    @property
    def vague(self) -> list[str]:
        """Parameters that a simulated joint needs whose interval is wide, in the textbook's or in its own model."""
        models = self.parameters, self.joint_parameters
        return [name for name in NEEDED if any(name in one and one[name].half_width > TUNING.vague for one in models)]

    @property
    def grade(self) -> str:
        """How far the result can be used: ``good``, ``usable with care`` or ``not usable``."""
        left = self.best.left if self.validation is None else max(self.best.left, self.validation)
        if left > LEFT[CARE] or self.value("inertia") <= 0.0 or "inertia" in self.unidentified:
            return UNUSABLE
        return CARE if left > LEFT[GOOD] or self.vague or self.unidentified else GOOD

    @cached_property
    def narrowed_by(self) -> dict[str, tuple[str, float]]:
        """By parameter, which motion would narrow it most: ``speed`` or ``acceleration``, and over the usual one.

        A further row ``x`` takes ``(x' M^-1 e)^2`` off the variance of an estimate, to first order, with ``M`` the
        normal matrix and ``e`` the estimate's unit vector (G. Elfving 1952). Rows weighted by that are faster or
        slower, and more or less accelerated, than all rows; the larger ratio, or its inverse, counts.
        """
        data, model = self.data, self.textbook.model
        columns = data.columns(*model)
        gain = np.linalg.lstsq(columns.T @ columns, columns.T)[0] ** 2
        motions = {"speed": data.velocity, "acceleration": data.columns(("inertia",), Shape())[:, 0]}
        ratios = np.sqrt([gain @ one**2 / gain.sum(axis=1) / np.mean(one**2) for one in motions.values()])
        return {
            name: max(zip(motions, pair, strict=True), key=lambda item: abs(math.log(max(item[1], 1e-9))))
            for name, pair in zip(model.names, ratios.T.tolist(), strict=True)
        }

    def torque_model(self, torque_constant: float | None = None) -> TorqueModel:
        """Return the best model, gravity apart, as a torque model; ``torque_constant`` (N m/A) is that of a current.

        A controller begins with :meth:`first_estimate`, which has gravity, deviations and maps as well.

        Raises
        ------
        InputError
            The inertia is not identifiable, or the torque constant is not allowed.
        """
        scale = self._torque_scale(torque_constant)
        if self.value("inertia") <= 0.0:
            raise InputError(f"{self.name}: the inertia is not identifiable, so there is no model of the joint")
        known = {name: scale * one.value for name, one in self.joint_parameters.items()}
        excess = known.get("stiction_excess", 0.0)
        return TorqueModel(
            inertia=known["inertia"],
            coulomb=known.get("coulomb", 0.0),
            stiction=known.get("coulomb", 0.0) + excess,
            viscous=known.get("viscous", 0.0),
            friction_lag=self.value("friction_lag") or (0.0 if self.value("path") else TUNING.assumed_lag),
            stribeck_velocity=self.value("stribeck_velocity")
            if excess
            else float(f"{TUNING.slow * float(abs(self.data.velocity).max()):.3g}"),
            stribeck_shape=1.0,
            offset=known.get("offset", 0.0),
            viscous_asymmetry=known.get(ASYMMETRY, 0.0),
            presliding=self.value("path"),
        )

    def first_estimate(
        self, torque_constant: float | None = None, parameters: Sequence[str] | None = None
    ) -> dict[str, Any]:
        """Return what an adaptive controller begins with: arguments of ``AdaptiveController`` beside gains and period.

        The standard deviations are in the units of the first model; one that is not named is not bounded by the log.
        Where friction depends on position, its map is among the arguments.

        Parameters
        ----------
        torque_constant : float, optional
            N m/A (N/A), where the log has a current.
        parameters : sequence of str, optional
            What the controller is to identify; by default what suits the model.
        """
        suiting = ["directions"] * bool(self.value(ASYMMETRY)) + ["gravity"] * (not self.linear)
        names = IDENTIFIED["_and_".join(suiting) or "offset"]
        try:
            names = names if parameters is None else check_parameters(parameters, ALL_CHOICES)
        except ValueError as error:
            raise InputError(str(error)) from error
        model, scale = self.torque_model(torque_constant), self._torque_scale(torque_constant)
        values = model._asdict()
        values |= {name: scale * self.value(REPORTED_AS[name]) for name in GRAVITY if name in names}
        normal, deviation = NormalDist().inv_cdf(0.5 + 0.5 * self.confidence), {}
        for name in names:
            one = self.joint_parameters.get(REPORTED_AS.get(name, name))
            if one is not None:
                half = (one.upper - one.value) * (1.0 if name == "friction_lag" else scale)
                deviation[name] = half / normal
        if "coulomb" in deviation:
            deviation.setdefault("stiction", deviation["coulomb"])
        return {
            "inertia": model.inertia,
            "stribeck_velocity": model.stribeck_velocity,
            "stribeck_shape": model.stribeck_shape,
            "parameters": names,
            "model": values,
            "deviation": {name: value for name, value in deviation.items() if math.isfinite(value) and value > 0.0},
            **self._over_position(),
        }

    def _over_position(self) -> dict[str, Any]:
        """Return the arguments of friction that depends on position, over Coulomb friction; none where it does not."""
        place, coulomb = self.data.place, self.value("coulomb")
        if not any(f"friction_{name}" in self.best.values for name in place.names) or coulomb <= 0.0:
            return {}
        waves = [f"{part}_{number}" for number in range(1, len(place.periods) + 1) for part in ("cosine", "sine")]
        hats = [f"hat_{number}" for number in range(1, place.hats + 1)]
        fractions = [self.best.values.get(f"friction_{name}", 0.0) / coulomb for name in (*waves, *hats)]
        return {
            "position_periods": place.periods,
            "position_hats": place.hats,
            "position_range": (place.low, place.high) if place.hats else None,
            "position_map": tuple(min(max(one, -TUNING.most_variation), TUNING.most_variation) for one in fractions),
        }

    def _torque_scale(self, torque_constant: float | None) -> float:
        """Return the factor from the log's torque to N m (N)."""
        is_current = self.units["torque"] == "A"
        if torque_constant is None:
            if is_current:
                raise InputError(f"{self.name}: the torque is a current; give torque_constant, in N m/A (N/A)")
            return 1.0
        check_positive(torque_constant=torque_constant)
        if not is_current:
            given = f"torque_constant = {torque_constant:g} is given"
            raise InputError(f"{self.name}: {given}, but the torque is no current")
        return float(torque_constant)

    @cached_property
    def fitted(self) -> Array:
        """Torque of the best model in the rows of the log, N m."""
        return self.data.modelled(self.best)

    def friction(self, velocity: Array) -> Array:
        """Return the friction curve of the best model, N m, with its offset."""
        speed, slow = np.abs(velocity), self.value("stribeck_velocity")
        dry = self.value("coulomb") + self.value("stiction_excess") * (np.exp(-speed / slow) if slow else 0.0)
        viscous, asymmetry, offset = (self.value(name) for name in ("viscous", ASYMMETRY, "offset"))
        return np.asarray(np.sign(velocity) * dry + viscous * velocity + asymmetry * speed + offset)

    def friction_points(self, bins: int = 30) -> dict[str, Array]:
        """Return the friction over velocity: means of the torque without all else in bins of one direction."""
        velocity = self.data.velocity
        measured = self.data.torque - self.fitted + self.friction(velocity)
        at = np.floor(velocity * bins / (np.ptp(velocity) or 1.0)).astype(int)  # zero is between two of them
        at -= at.min()
        count = np.bincount(at)
        kept = count >= 5
        mean = [np.bincount(at, one)[kept] / count[kept] for one in (velocity, measured)]
        return {"velocity": mean[0], "torque": mean[1], "count": count[kept].astype(float)}

    def to_dict(self) -> dict[str, Any]:
        """Return everything but the series as plain values: textbook parameters by name, ``refined`` beside them."""
        refined = self.refined and {
            "taken": list(self.taken),
            **{name: self._entry(name, one) for name, one in self.refined.parameters.items()},
            "left": self.refined.left,
        }
        return {
            "name": self.name,
            "units": self.units,
            **{name: self._entry(name, one) for name, one in self.parameters.items()},
            "refined": refined,
            "left": self.textbook.left,
            "confidence": self.confidence,
            "verdict": self.grade,
            "given": self.given,
            "identified": list(self.best.values),
            "unidentified": self.unidentified,
            "vague": self.vague,
            "narrowed_by": {name: {"motion": kind, "times": by} for name, (kind, by) in self.narrowed_by.items()},
            "validation": None if self.validation is None else {"on": self.validated_on, "left": self.validation},
            "friction": {name: series.tolist() for name, series in self.friction_points().items()},
            "bandwidth": self.data.band,
            "period": self.data.period,
            "samples": {"log": self.data.log.time.size, "used": self.data.used},
            "skipped": [skip._asdict() for skip in self.data.skipped],
            "warnings": self.cautions,
        }

    def _entry(self, name: str, one: Parameter) -> dict[str, Any]:
        return {**one._asdict(), "unit": unit_of(self.units, name)}
