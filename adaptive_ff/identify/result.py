"""What was identified from a log."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from adaptive_ff.identify.fitting.constant_speed import FrictionCurve
from adaptive_ff.identify.fitting.prediction import Prediction, TorqueError
from adaptive_ff.identify.fitting.term_selection import Selection
from adaptive_ff.identify.maps.identified_map import IdentifiedMap
from adaptive_ff.identify.maps.map_columns import MapAsked
from adaptive_ff.identify.reported import Reported
from adaptive_ff.identify.rows.recorded_reference import Reference
from adaptive_ff.logs.defects import Skipped
from adaptive_ff.logs.derivatives import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from adaptive_ff.friction.model import TorqueModel
    from adaptive_ff.identify.first_estimate import FirstEstimate


@dataclass(frozen=True, eq=False, repr=False)
class LogIdentification:
    """A joint identified from a log.

    Attributes
    ----------
    name : str
        Where the log comes from.
    units : dict of str
        Units by name of the parameter, and of ``torque`` and ``velocity``.
    parameters : dict of Reported
        ``inertia``, ``coulomb``, ``viscous``, ``offset``, ``friction_lag``, ``stiction``, ``stribeck_velocity``,
        ``saturation``, ``saturation_velocity``, ``viscous_asymmetry``, ``gravity_sine`` and ``gravity_cosine``, as far
        as they could be estimated; those that are not used are of the model with that term beside the chosen ones.
        ``viscous_asymmetry`` is half the difference of the viscous coefficients of both directions.
    selection : Selection
        The fits behind it.
    confidence : float
        Probability that the intervals are meant to have.
    bandwidth, period : float
        Band of the regression, Hz, and sample time of the log, s.
    samples, used : int
        Number of samples of the log, and of those in the pieces that were used.
    skipped : list of Skipped
        What of the log was not used, and why.
    fit, validation : TorqueError, and TorqueError or None
        How well the model says the torque that it was fitted to, and torque that it was not.
    validated_on : str
        What the latter is.
    both_ways : bool
        Whether the joint moves both ways.
    curve : FrictionCurve
        Points of friction from stretches at constant speed, and the Stribeck curve through them.
    rest_torque : float or None
        Largest torque seen at rest, without the offset, N m; None where the joint does not rest.
    lags, lag_errors : ndarray, shape (n,)
        Friction lags, s, and the relative error of the torque with each.
    rows, held_out : list of Prediction
        The torque in the band, fitted and held out.
    reference : Reference
        The motion of the longest piece.
    map_asked : MapAsked
        What of position and load friction, or a force, might depend on.
    position_map : IdentifiedMap or None
        How they do; None where the model does without.
    carries_over : tuple of terms and TorqueError, or None
        Where the chosen model is much worse on what was held out, but one of another family is not: its terms, and its
        error there, which may still be more than that of the chosen one.
    other_units : str or None
        What another log's torque or motion seems to be in, where it is not what the log's is in.
    has_other_load : bool
        Whether what was held out speaks for another gravity or offset there alone.
    has_changed : bool
        Whether what was held out speaks for another friction or inertia there.
    verdict : list of str
        What the log determines and what it does not, a sentence each.
    cautions : list of str
        What is probably wrong with the log, a sentence each.
    """

    name: str
    units: dict[str, str]
    parameters: dict[str, Reported]
    selection: Selection
    confidence: float
    bandwidth: float
    period: float
    samples: int
    used: int
    skipped: list[Skipped]
    fit: TorqueError
    validation: TorqueError | None
    validated_on: str
    both_ways: bool
    curve: FrictionCurve
    rest_torque: float | None
    lags: Array
    lag_errors: Array
    rows: list[Prediction]
    held_out: list[Prediction]
    reference: Reference
    map_asked: MapAsked
    position_map: IdentifiedMap | None
    carries_over: tuple[tuple[str, ...], TorqueError] | None = None
    other_units: str | None = None
    has_other_load: bool = False
    has_changed: bool = False
    verdict: list[str] = field(default_factory=list)
    cautions: list[str] = field(default_factory=list)

    def __repr__(self) -> str:
        """Return what the log determines and what is left of the torque in one line."""
        known = "".join(
            f"{name} {reported.estimate.value:.4g} {self.units[name]}, "
            for name, reported in self.parameters.items()
            if reported.is_known
        )
        return f"LogIdentification({self.name!r}: {known}{100.0 * self.fit.relative_error:.3g} % of the torque left)"

    def value(self, name: str) -> float:
        """Return a parameter of the model as it is used: zero where the log does not determine it."""
        reported = self.parameters.get(name)
        return reported.estimate.value if reported is not None and reported.identifiable and reported.used else 0.0

    def torque_model(self, torque_constant: float | None = None) -> "TorqueModel":
        """Return the identified joint as the model that controllers assume.

        What the log does not determine is zero, but for the lag, which is the one estimated beside the model, or 10 ms
        where there is no friction or no bound to it, and for stiction, Stribeck velocity and shape: those of stretches
        at constant speed where there are such, else stiction is Coulomb friction and the Stribeck velocity a twentieth
        of the largest speed. Friction that saturates is shared out between Coulomb and viscous friction as at the log's
        speeds; gravity and friction over position have no place in this model.

        Parameters
        ----------
        torque_constant : float, optional
            Torque (force) of one ampere, N m/A (N/A), for a log that holds a current; 1 for a controller that
            commands A.

        Returns
        -------
        TorqueModel
            The joint; of a linear axis read m, N and kg for rad, N m and kg m^2.

        Raises
        ------
        InputError
            The inertia is not identifiable, the log holds a current and there is no torque constant, it is not a
            positive and finite number, or the log holds a torque and there is one.
        """
        from adaptive_ff.identify.first_estimate import torque_model

        return torque_model(self, torque_constant)

    def first_estimate(
        self, torque_constant: float | None = None, parameters: Sequence[str] | None = None
    ) -> "FirstEstimate":
        """Return what an adaptive controller of this joint begins with: model, gravity, map, and how sure they are.

        ``AdaptiveController(proportional, integral, period, **found.first_estimate()._asdict())``. The standard
        deviations are those of the intervals, about the values, of the joint as it was recorded.

        Where friction was found to depend on position, the controller is given the same periods and hats, and begins
        with their coefficients, within what it allows, from -2 to 2. The position must be that of the log: the same
        zero, and with ``gear_ratio`` the joint's. Friction over load is left out, because the controller counts
        identified gravity as load and the log does not (``load_friction=True`` learns it anew); so is a force over
        position, for which it has no map.

        Parameters
        ----------
        torque_constant : float, optional
            As in :meth:`torque_model`.
        parameters : sequence of str, optional
            What the controller is to identify, as in :class:`AdaptiveController`; by default with offset, for a
            rotary joint with gravity, too, and by direction where viscous friction is.

        Raises
        ------
        InputError
            As in :meth:`torque_model`, or ``parameters`` are no choice of the controller.
        """
        from adaptive_ff.identify.first_estimate import first_estimate

        return first_estimate(self, torque_constant, parameters)

    def to_dict(self) -> dict[str, Any]:
        """Return everything but the series as plain values; ends of intervals that are infinite are None."""
        result: dict[str, Any] = {"log": self.name}
        for name, (estimate, identifiable, used, confounded) in self.parameters.items():
            ends = {"lower": estimate.lower, "upper": estimate.upper, "standard_error": estimate.standard_error}
            finite = {key: number if np.isfinite(number) else None for key, number in ends.items()}
            unit = self.units[name]
            kind = {"identifiable": identifiable, "used": used, "confounded": list(confounded)}
            result[name] = {"value": estimate.value, **finite, "unit": unit, **kind}
        alike = [fitted.terms for fitted in self.selection.alike]
        result["terms"] = list(self.selection.chosen.terms)
        result["confidence"] = self.confidence
        result["fit"] = self.fit._asdict()
        held = None if self.validation is None else self.validation._asdict()
        result["validation"] = None if held is None else {"on": self.validated_on, **held}
        other = self.carries_over
        result["has_changed"] = self.has_changed
        result["has_other_load"] = self.has_other_load
        result["other_units"] = self.other_units
        result["carries_over"] = None if other is None else {"terms": list(other[0]), **other[1]._asdict()}
        result["models"] = [
            {"terms": list(model.terms), "error_held_out": model.error, "alike": model.terms in alike}
            for model in sorted(self.selection.validated, key=lambda model: model.error)
        ]
        result["friction_map"] = None if self.position_map is None else self.position_map.to_dict()
        result["bandwidth"] = self.bandwidth
        result["period"] = self.period
        result["samples"] = {"log": self.samples, "used": self.used}
        result["skipped"] = [skip._asdict() for skip in self.skipped]
        result["rest_torque"] = self.rest_torque
        result["constant_speed"] = _curve_to_dict(self.curve)
        result["verdict"] = self.verdict
        result["warnings"] = self.cautions
        return result

    def plot(self, folder: str | Path | None = None) -> "dict[str, Figure]":
        """Draw the report; write each picture as ``NAME.png`` where a folder is given."""
        from adaptive_ff.report.identification_plots import plot_identification

        return plot_identification(self, folder)


def _curve_to_dict(curve: FrictionCurve) -> dict[str, Any]:
    points, fit = curve.points, curve.fit
    result: dict[str, Any] = {"remark": curve.remark, "points": [], "stribeck": None}
    if points is not None:
        columns = (points.velocity, points.torque, points.standard_error, points.count)
        names = ("velocity", "torque", "standard_error", "readings")
        series = zip(*(column.tolist() for column in columns), strict=True)
        result["points"] = [dict(zip(names, row, strict=True)) for row in series]
    if fit is not None:
        result["stribeck"] = {
            name: {"value": estimate.value, **{end: _finite(getattr(estimate, end)) for end in ("lower", "upper")}}
            for name, estimate in fit.estimates.items()
        }
        result["stribeck"]["determined"] = fit.determined
    return result


def _finite(number: float) -> float | None:
    return number if np.isfinite(number) else None
