"""Which bandwidth suits which controller on a joint, and what the PI loop is like at each."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.comparison.comparison import BASELINE
from adaptive_ff.comparison.own_bandwidth import (
    TUNING_SEEDS,
    OwnBandwidth,
    find_own_bandwidth,
    settled_error,
    with_bandwidth,
)
from adaptive_ff.comparison.registry import CONTROLLERS
from adaptive_ff.errors import InputError
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.studies.loop_at_bandwidth import LoopAtBandwidth, loop_at

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STUDIED = (BASELINE, "disturbance_observer", "extended_state", "kalman_disturbance", "adaptive")
"""Controllers that are studied by default."""

REPORTED_SEEDS = tuple(range(1, 6))
"""Seeds of the errors that are reported; none of them takes part in the choice."""


@dataclass(frozen=True, eq=False, repr=False)
class BandwidthStudy:
    """Errors over the bandwidth.

    Attributes
    ----------
    scenario : Scenario
        The scenario.
    loops : list of LoopAtBandwidth
        The PI loop at each bandwidth that was tried.
    own : dict of OwnBandwidth
        Errors of each controller over these bandwidths, on the seeds that the choice is made on.
    own_errors : dict of float
        Settled rms error (rad/s) of each controller at its own best bandwidth, median over the reported seeds.
    common_errors : dict of float
        The same in the loop that the scenario gives to all; empty where that leaves the bandwidth open.
    """

    scenario: Scenario
    loops: list[LoopAtBandwidth]
    own: dict[str, OwnBandwidth]
    own_errors: dict[str, float]
    common_errors: dict[str, float]

    def __repr__(self) -> str:
        """Return the best bandwidths in one line."""
        best = ", ".join(f"{name} {one.best:.3g}" for name, one in self.own.items())
        return f"BandwidthStudy(best bandwidth, Hz: {best})"

    def to_dict(self) -> dict[str, Any]:
        """Return the study as ``adaptive-ff tune --json`` writes it."""
        return {
            "scenario": self.scenario.model_dump(mode="json", exclude_none=True),
            "loops": [{key: _plain(value) for key, value in loop._asdict().items()} for loop in self.loops],
            "controllers": {
                name: {
                    "best_bandwidth": one.best,
                    "at_an_end": one.at_an_end,
                    "own_error": _plain(self.own_errors[name]),
                    "common_error": _plain(self.common_errors.get(name, np.nan)),
                    "errors": [_plain(error) for error in one.errors],
                }
                for name, one in self.own.items()
            },
        }

    def columns(self) -> dict[str, NDArray[np.float64]]:
        """Return margins, noise and errors over the bandwidth by name, as they are written to CSV."""
        loops = {
            name: np.array([float(getattr(loop, name)) for loop in self.loops]) for name in LoopAtBandwidth._fields
        }
        return {**loops, **{f"error_{name}": np.array(one.errors) for name, one in self.own.items()}}

    def plot(self) -> "Figure":
        """Draw error over bandwidth."""
        from adaptive_ff.report.bandwidth_plot import plot_bandwidths

        return plot_bandwidths(self)


def study_bandwidths(
    scenario: Scenario,
    controllers: Sequence[str] = STUDIED,
    *,
    tuning_seeds: Sequence[int] = TUNING_SEEDS,
    reported_seeds: Sequence[int] = REPORTED_SEEDS,
    progress: Callable[[str, float], None] | None = None,
) -> BandwidthStudy:
    """Find the bandwidth that suits each controller.

    Parameters
    ----------
    scenario : Scenario
        The scenario; its bandwidth is what the others are compared with.
    controllers : sequence of str, optional
        Names of controllers; ``pi`` is always among them.
    tuning_seeds, reported_seeds : sequence of int, optional
        Seeds on which bandwidths are chosen and on which errors are reported; they must not overlap.
    progress : callable, optional
        Is called with the name of a controller and the share of its study that is done.

    Raises
    ------
    InputError
        A controller is not known, or seeds overlap.
    """
    for name in controllers:
        if name not in CONTROLLERS:
            raise InputError(f"controller = {name!r} is not known; there are {', '.join(CONTROLLERS)}")
    both = sorted(set(tuning_seeds) & set(reported_seeds))
    if both or not tuning_seeds or not reported_seeds:
        raise InputError(
            f"seeds {list(tuning_seeds)} to choose on and {list(reported_seeds)} to report are not allowed: there "
            "must be some of both, and none in common"
        )
    own, own_errors, common_errors = {}, {}, {}
    for name in dict.fromkeys([BASELINE, *controllers]):
        maker = CONTROLLERS[name]
        report = None if progress is None else _reporter(progress, name)
        own[name] = find_own_bandwidth(scenario, maker, seeds=tuning_seeds, progress=report)
        seeded = [scenario.modified(seed=seed) for seed in reported_seeds]
        own_errors[name] = float(
            np.median([settled_error(with_bandwidth(one, own[name].best), maker) for one in seeded])
        )
        if not scenario.feedback.is_auto:
            common_errors[name] = float(np.median([settled_error(one, maker) for one in seeded]))
    loops = [loop_at(scenario, bandwidth) for bandwidth in own[BASELINE].bandwidths]
    return BandwidthStudy(scenario, loops, own, own_errors, common_errors)


def _reporter(progress: Callable[[str, float], None], name: str) -> Callable[[float], None]:
    return lambda share: progress(name, share)


def _plain(value: Any) -> Any:
    """Return a value that JSON can hold: None for what is not finite."""
    return None if isinstance(value, float) and not np.isfinite(value) else value
