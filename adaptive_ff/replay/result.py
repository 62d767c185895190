"""What a replay shows: the torque that each feedforward would have left to the feedback."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from adaptive_ff.adaptive.controller import UnsupervisedController
from adaptive_ff.friction.model import UNITS, TorqueModel, unit_of
from adaptive_ff.identify.units import of_current
from adaptive_ff.logs.defects import Skipped
from adaptive_ff.logs.derivatives import Array
from adaptive_ff.replay.judging import Left
from adaptive_ff.replay.settings import ReplaySettings
from adaptive_ff.replay.state import state_to_json
from adaptive_ff.scenario.axis_units import of_linear

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NONE, FIXED, RECORDED, COLD, SAVED = "none", "fixed", "recorded", "adaptive", "adaptive_saved"
"""Feedforwards: none; a fixed model; the machine's own; the adaptive one from a cold start, and from a saved state."""


class ReplaySeries(NamedTuple):
    """Series of a replay, in bins of samples: of one sample each where the log is short.

    Attributes
    ----------
    time : ndarray, shape (bins,)
        Time of the log at the first sample of each bin, s.
    needed : ndarray, shape (2, bins)
        Smallest and largest torque that was needed, in the band, N m.
    feedforward, left : dict of ndarray, shape (2, bins)
        The same of each feedforward, and of what it leaves.
    estimates : dict of dict of ndarray, shape (bins,)
        Of each adaptive feedforward, the physical estimates at the end of each bin, by name.
    """

    time: Array
    needed: Array
    feedforward: dict[str, Array]
    left: dict[str, Array]
    estimates: dict[str, dict[str, Array]]


@dataclass(frozen=True, eq=False)
class Replay:
    """A log replayed.

    Attributes
    ----------
    name : str
        Where the log comes from.
    linear, is_current : bool
        Whether it is a linear axis, and whether its torque is a current.
    settings : ReplaySettings
        Settings of the adaptive controller.
    band : float or None
        Band in which is judged, Hz; None for all frequencies.
    samples, used : int
        Number of samples of the log, and of those that were used.
    skipped : list of Skipped
        What of the log was not used, and why.
    notes : list of str
        What is to be known of the figures, a sentence each.
    fixed : TorqueModel or None
        The fixed model; None where there is none.
    left : dict of Left
        Torque left to the feedback by feedforward: ``none``, ``fixed``, ``recorded``, ``adaptive`` (from a cold start)
        and ``adaptive_saved``, as far as there are such.
    series : ReplaySeries
        Torques and estimates over time, thinned.
    controllers : dict of UnsupervisedController
        The adaptive ones, in the state at the end of the log.
    """

    name: str
    linear: bool
    is_current: bool
    settings: ReplaySettings
    band: float | None
    samples: int
    used: int
    skipped: list[Skipped]
    notes: list[str]
    fixed: TorqueModel | None
    left: dict[str, Left]
    series: ReplaySeries
    controllers: dict[str, UnsupervisedController]

    @property
    def unit(self) -> str:
        """Unit of torque: N m, N of a linear axis, or A."""
        return self.units["coulomb"]

    @property
    def units(self) -> dict[str, str]:
        """Units of the estimates, by name, and of all parameters of a joint."""
        names = dict.fromkeys([*UNITS, *(name for history in self.series.estimates.values() for name in history)])
        units = {name: of_linear(unit_of(name)) if self.linear else unit_of(name) for name in names}
        return of_current(units) if self.is_current else units

    @property
    def estimates(self) -> dict[str, dict[str, float]]:
        """Physical estimates at the end, of each adaptive feedforward, by name."""
        return {name: controller.estimates for name, controller in self.controllers.items()}

    def state_to_json(self) -> str:
        """Return settings and state at the end, for the next log; of the run from a saved state where there is one."""
        return state_to_json(self.settings, self.controllers.get(SAVED, self.controllers[COLD]))

    def to_dict(self) -> dict[str, Any]:
        """Return everything but the series as plain values; what is not known is None."""
        left = {
            name: {key: value if np.isfinite(value) else None for key, value in torques._asdict().items()}
            for name, torques in self.left.items()
        }
        return {
            "log": self.name,
            "left": left,
            "unit": self.unit,
            "band": self.band,
            "settings": self.settings.to_dict(),
            "fixed": None if self.fixed is None else self.fixed._asdict(),
            "estimates": self.estimates,
            "samples": {"log": self.samples, "used": self.used},
            "skipped": [skip._asdict() for skip in self.skipped],
            "notes": self.notes,
        }

    def plot(self, folder: str | Path | None = None) -> "dict[str, Figure]":
        """Draw the replay; write each picture as ``NAME.png`` where a folder is given."""
        from adaptive_ff.report.replay_plots import plot_replay

        return plot_replay(self, folder)
