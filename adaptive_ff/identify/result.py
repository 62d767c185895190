"""What was identified from a log: codes, values and units; :mod:`adaptive_ff.report` words them."""

from functools import cached_property
from typing import Any

import numpy as np

from adaptive_ff.identify import first_estimate as first
from adaptive_ff.identify import simulators
from adaptive_ff.identify.columns import static_friction
from adaptive_ff.identify.joint import IdentifiedJoint
from adaptive_ff.identify.motion import Array
from adaptive_ff.identify.regression import Parameter
from adaptive_ff.identify.units import unit_of
from adaptive_ff.reported import Reported


class LogIdentification(IdentifiedJoint, Reported):
    """A joint identified from a log, with what a controller, a simulator or a script makes of it."""

    _drawn_by = "plot_identification"
    torque_model = first.torque_model
    first_estimate = first.first_estimate
    simulator = simulators.simulator_text

    @cached_property
    def fitted(self) -> Array:
        """Torque of the best model in the rows of the log, N m."""
        return self.data.modelled(self.best)

    def friction(self, velocity: Array) -> Array:
        """Return the friction curve of the best model, N m, with its offset."""
        shape = self.best.model.shape
        return np.asarray(static_friction(velocity, self.best.values, shape) + self.value("offset"))

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
            "identified": self.identified,
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
