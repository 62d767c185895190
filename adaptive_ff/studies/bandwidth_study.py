"""Which bandwidth suits which controller on a joint, and what the PI loop is like at each."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.comparison.comparison import BASELINE, KNOW_THE_TRUTH
from adaptive_ff.comparison.own_bandwidth import (
    TUNING_SEEDS,
    Errors,
    OwnBandwidth,
    errors_of,
    loaded,
    own_bandwidth,
    with_bandwidth,
)
from adaptive_ff.comparison.registry import CONTROLLERS
from adaptive_ff.errors import InputError, check_among
from adaptive_ff.reported import WORTH, Reported
from adaptive_ff.scenario.axis_units import axis_unit
from adaptive_ff.scenario.loop import LOAD_FRACTION, LoopAtBandwidth, loop_at, tried_bandwidths
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.simulation.experiment import build_setup
from adaptive_ff.studies.study import Found, run_study
from adaptive_ff.workers import part_of_progress

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STUDIED = (BASELINE, "disturbance_observer", "extended_state", "kalman_disturbance", "adaptive")  # by default
REPORTED_SEEDS = tuple(range(1, 6))  # seeds of the errors that are reported; none of them takes part in the choice
UNKNOWN = Errors(math.nan, math.nan)  # errors where nothing is run


@dataclass(frozen=True, eq=False, repr=False)
class BandwidthStudy(Reported):
    """Errors over the bandwidth."""

    scenario: Scenario  # the scenario
    load: float  # step of the load, over the rated torque
    loops: list[LoopAtBandwidth]  # the PI loop at each bandwidth that was tried
    # errors of each controller over these bandwidths, on the seeds that the choice is made on
    own: dict[str, OwnBandwidth]
    # settled and loaded error (rad/s) of each controller at its own best bandwidth, median over the reported seeds
    own_errors: dict[str, Errors]
    # the same in the loop that the scenario gives to all; empty where that leaves the bandwidth open
    common_errors: dict[str, Errors]

    def front(self) -> set[tuple[str, int]]:
        """Return the Pareto front: controller and place of a bandwidth where no other is better in both errors."""
        points = {(name, place): pair for name, one in self.own.items() for place, pair in enumerate(one.pairs)}

        def beaten(mine: Errors) -> bool:
            others = (pair for pair in points.values() if pair != mine)
            return any(other.settled <= mine.settled and other.loaded <= mine.loaded for other in others)

        return {key for key, pair in points.items() if math.isfinite(pair.settled) and not beaten(pair)}

    def __repr__(self) -> str:
        """Return the best bandwidths in one line."""
        best = ", ".join(f"{name} {one.best:.3g}" for name, one in self.own.items())
        return f"BandwidthStudy(best bandwidth, Hz: {best})"

    @property
    def verdict(self) -> dict[str, Any]:
        """Best in the lesser of its gains over PI, settled and loaded, each at its best bandwidth; and its limit."""
        pi, candidates = self.own_errors[BASELINE], [name for name in self.own_errors if name not in KNOW_THE_TRUTH]
        pairs = {name: zip(pi, self.own_errors[name], strict=True) for name in candidates}
        gains = {name: Errors(*(one / own if own > 0.0 else math.inf for one, own in pairs[name])) for name in pairs}
        best = max(gains, key=lambda name: min(gains[name]))
        one, error = self.own[best], self.own_errors[best].settled
        noise = self.loops[one.bandwidths.index(one.best)].noise_velocity
        limit = "bandwidth" if one.best == one.bandwidths[-1] else "friction"
        return {
            "best": best,
            "bandwidth": one.best,
            "over_pi": _plain(gains[best].settled),
            "over_pi_loaded": _plain(gains[best].loaded),
            "worth": min(gains[best]) > WORTH,
            "limit": "noise" if 2.0 * noise**2 > error**2 else limit,
        }

    def to_dict(self) -> dict[str, Any]:
        """Return the study as ``adaptive-ff tune --json`` writes it."""
        controllers = {}
        for name, one in self.own.items():
            own, common = self.own_errors[name], self.common_errors.get(name, UNKNOWN)
            controllers[name] = {
                "best_bandwidth": one.best,
                "at_an_end": one.at_an_end,
                "own_error": own.settled,
                "own_loaded_error": own.loaded,
                "common_error": common.settled,
                "common_loaded_error": common.loaded,
                "errors": list(one.errors),
                "loaded_errors": list(one.loaded),
            }
        return {
            "scenario": self.scenario.model_dump(mode="json", exclude_none=True),
            "load": self.load,
            "loops": [_plain(loop._asdict()) for loop in self.loops],
            "controllers": _plain(controllers),
            "verdict": self.verdict,
        }

    def columns(self) -> dict[str, NDArray[np.float64]]:
        """Return margins, noise and errors over the bandwidth by name, as they are written to CSV."""
        loops = dict(zip(LoopAtBandwidth._fields, np.array(self.loops, dtype=float).T, strict=True))
        errors = {f"error_{name}": np.array(one.errors) for name, one in self.own.items()}
        return {**loops, **errors, **{f"loaded_error_{name}": np.array(one.loaded) for name, one in self.own.items()}}

    def plot(self) -> "Figure":  # type: ignore[override]
        """Draw error over bandwidth, with and without the load."""
        figure: Figure = self._report("plot_bandwidths")
        return figure


def study_bandwidths(
    scenario: Scenario,
    controllers: Sequence[str] = STUDIED,
    *,
    load: float = LOAD_FRACTION,
    stiffness: float = 0.0,
    tuning_seeds: Sequence[int] = TUNING_SEEDS,
    reported_seeds: Sequence[int] = REPORTED_SEEDS,
    workers: int | None = 1,
    progress: Callable[[float], None] | None = None,
) -> BandwidthStudy:
    """Find the bandwidth that suits each controller; ``pi`` is always among them.

    Chosen on some seeds and reported on others, for a step of the load (over the rated torque, 0 where there is none),
    of loops at least so stiff: load over the angle that is lost, ``Ki``, N m/rad.
    """
    for name in controllers:
        check_among("controller = ", name, CONTROLLERS)
    both = sorted(set(tuning_seeds) & set(reported_seeds))
    if both or not tuning_seeds or not reported_seeds:
        raise InputError(
            f"seeds {list(tuning_seeds)} to choose on and {list(reported_seeds)} to report are not allowed: there "
            "must be some of both, and none in common"
        )
    names = list(dict.fromkeys([BASELINE, *controllers]))
    tried, seeds = tried_bandwidths(scenario), len(tuning_seeds)
    loops = [loop_at(scenario, bandwidth, load) for bandwidth in tried]
    allowed = [loop.integral >= stiffness for loop in loops]
    if not any(allowed):
        unit = axis_unit(scenario.joint.axis, "N m/rad")
        raise InputError(
            f"stiffness = {stiffness:g} {unit} is not allowed: the stiffest loop whose margins are sound has "
            f"{loops[-1].integral:.4g} {unit}"
        )
    trials = {f"{bandwidth}, {seed}": (bandwidth, seed) for bandwidth in tried for seed in tuning_seeds}
    count, runs = len(trials), len(trials) + len(reported_seeds)
    run = partial(run_study, controllers=names, workers=workers, threads=True)
    found = run(partial(_trial, scenario, load), trials, progress=part_of_progress(progress, 0, runs, count))
    own: dict[str, OwnBandwidth] = {}
    for name in names:
        errors = np.reshape([one[name] for one in found.values()], (len(tried), seeds, 2))
        own[name] = own_bandwidth(tried, errors, own.get(BASELINE), allowed)
    reported = run(
        partial(_reported, scenario, load, {name: one.best for name, one in own.items()}),
        {str(seed): seed for seed in reported_seeds},
        progress=part_of_progress(progress, count, runs, len(reported_seeds)),
    )
    medians = {name: np.median([one[name] for one in reported.values()], axis=0).tolist() for name in names}
    own_errors = {name: Errors(*pair[0]) for name, pair in medians.items()}
    common_errors = {} if scenario.feedback.is_auto else {name: Errors(*pair[1]) for name, pair in medians.items()}
    return BandwidthStudy(scenario, load, loops, own, own_errors, common_errors)


def _trial(scenario: Scenario, load: float, trial: tuple[float, int], names: list[str]) -> Found:
    """Return the errors of controllers at a bandwidth (Hz) and a seed."""
    bandwidth, seed = trial
    at = loaded(with_bandwidth(scenario.modified(seed=seed), bandwidth), load)
    setup = build_setup(at)
    return {name: errors_of(at, CONTROLLERS[name], setup) for name in names}


def _reported(scenario: Scenario, load: float, best: dict[str, float], seed: int, names: list[str]) -> Found:
    """Return the errors of controllers at their own bandwidths and, where there is one, the scenario's."""
    at = scenario.modified(seed=seed)
    loops = {name: [with_bandwidth(at, best[name]), *([] if scenario.feedback.is_auto else [at])] for name in names}
    return {name: [errors_of(loaded(one, load), CONTROLLERS[name]) for one in loops[name]] for name in names}


def _plain(value: Any) -> Any:
    """Return a value that JSON can hold: None for what is not finite."""
    if isinstance(value, dict):
        return {name: _plain(one) for name, one in value.items()}
    if isinstance(value, list):
        return [_plain(one) for one in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value
