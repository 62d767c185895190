"""A joint that was identified from a log: its models with their intervals, and how far they can be used."""

import math
from dataclasses import dataclass, field
from pathlib import Path

from adaptive_ff.identify.preparation import Prepared
from adaptive_ff.identify.regression import Fit, Parameter

GOOD, CARE, UNUSABLE = "good", "usable with care", "not usable"

LEFT = {GOOD: 0.15, CARE: 0.5}
"""Fraction of the torque (rms, of folds that were left out) that may be left."""

WIDE = 0.25
"""Half width of an interval over its value from which on a parameter needs care."""

NEEDED = ("inertia", "coulomb", "viscous")
"""What a simulated joint needs."""


@dataclass(frozen=True, eq=False, repr=False)
class IdentifiedJoint:
    """Models of a joint with the log that they are fitted to.

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
    narrowed_by : dict of tuple
        By parameter, whether rows of another ``speed`` or ``acceleration`` would narrow it most, and of how many times
        the usual one.
    validation : float or None
        What the best model leaves of the torque that it was validated on, rms over rms.
    validated_on : str
        What that is.
    cautions : list of str
        What was done to the log, or is probably wrong with it, a sentence each.
    """

    data: Prepared
    units: dict[str, str]
    textbook: Fit
    refined: Fit | None
    taken: tuple[str, ...]
    unidentified: dict[str, str]
    confidence: float
    narrowed_by: dict[str, tuple[str, float]]
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
        """Return a parameter of the best model; zero where it has none of that name."""
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
    def identified(self) -> list[str]:
        """Parameters of the best model, which the log identifies."""
        return list(self.best.values)

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
        """Parameters that a simulated joint needs whose interval is wide, in the textbook's or in the best model."""
        models = self.parameters, self.best.parameters
        return [name for name in NEEDED if any(name in one and one[name].half_width > WIDE for one in models)]

    @property
    def grade(self) -> str:
        """How far the result can be used: ``good``, ``usable with care`` or ``not usable``."""
        left = self.best.left if self.validation is None else max(self.best.left, self.validation)
        if left > LEFT[CARE] or self.value("inertia") <= 0.0 or "inertia" in self.unidentified:
            return UNUSABLE
        return CARE if left > LEFT[GOOD] or self.vague or self.unidentified else GOOD
