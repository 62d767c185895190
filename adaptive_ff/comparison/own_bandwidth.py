"""The bandwidth at which a controller does best on a scenario: error over bandwidth, on seeds that are not reported.

On a common PI loop a good compensator is held to the bandwidth that suits the others, and a weak one is helped by a
loop that is slow. A controller's own best bandwidth is the one at which its settled error is least, up to the fastest
loop that a maximum sensitivity of 1.7 allows. It is searched on seeds from 101 on, whatever the scenario's own is. A
best bandwidth at either end of the range is marked, because the true optimum may be beyond it.
"""

import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from adaptive_ff.comparison.running import drive_over
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.simulation.experiment import NO_POSITION_LOOP, Course, lay_course
from adaptive_ff.simulation.metrics import evaluate
from controllers import fastest_bandwidth

Maker = Callable[[Scenario], Any]
"""Makes a controller, any object with a method ``step``, for a scenario."""

FIRST_TUNING_SEED = 101
"""First of the seeds on which a bandwidth is chosen; reported ones begin at 1."""

TUNING_SEEDS = tuple(range(FIRST_TUNING_SEED, FIRST_TUNING_SEED + 3))
"""Seeds on which a bandwidth is chosen by default."""

SLOWEST, SLOWEST_SHARE = 1.0, 0.25
"""Slowest loop that is tried, Hz, and its share of the fastest one where that is less."""

STEP = 2.0**0.5
"""Ratio of one bandwidth that is tried to the next."""


class OwnBandwidth(NamedTuple):
    """The bandwidth that suits a controller.

    Attributes
    ----------
    bandwidths : tuple of float
        Bandwidths that were tried, ascending, Hz.
    errors : tuple of float
        Settled rms error at each, the median over the seeds, rad/s; infinite where the loop fails.
    """

    bandwidths: tuple[float, ...]
    errors: tuple[float, ...]

    @property
    def best(self) -> float:
        """The bandwidth of the least error, Hz."""
        return self.bandwidths[int(np.argmin(self.errors))]

    @property
    def error(self) -> float:
        """The least error, rad/s."""
        return min(self.errors)

    @property
    def at_an_end(self) -> bool:
        """Whether the best bandwidth is the slowest or the fastest one that was tried."""
        return self.best in (self.bandwidths[0], self.bandwidths[-1])


def tried_bandwidths(scenario: Scenario) -> list[float]:
    """Return the bandwidths (Hz) that are tried, the fastest that the sampling allows included."""
    fastest = fastest_bandwidth(scenario.sampling.period, math.ceil(scenario.assumed_delay - 1e-6))
    slowest = min(SLOWEST, SLOWEST_SHARE * fastest)
    count = math.floor(math.log(fastest / slowest) / math.log(STEP) + 1e-9) + 1
    return [fastest / STEP**step for step in reversed(range(count))]


def with_bandwidth(scenario: Scenario, bandwidth: float) -> Scenario:
    """Return a scenario whose feedback has another bandwidth (Hz) in the place of its own, or of its gains."""
    content = scenario.model_dump(exclude_unset=True)
    kept = {name: content["feedback"][name] for name in ("inertia", "delay") if name in content["feedback"]}
    return Scenario.model_validate({**content, "feedback": {**kept, "bandwidth": float(bandwidth)}})


def settled_error(scenario: Scenario, maker: Maker, course: Course | None = None) -> float:
    """Return the settled rms error (rad/s) of a controller in the loop of a scenario, infinite where it fails.

    Parameters
    ----------
    scenario : Scenario
        The scenario.
    maker : callable
        Makes the controller for a scenario.
    course : Course, optional
        Course of the same scenario, perhaps with another bandwidth; it is laid here where it is not given.
    """
    try:
        controller = maker(scenario)
        laid = lay_course(scenario) if course is None else course
        laid = laid._replace(outer=scenario.position_loop or NO_POSITION_LOOP)  # its gain may follow the bandwidth
        with np.errstate(over="ignore", invalid="ignore"):
            record, _, _ = drive_over(controller, laid)
            found = evaluate(
                scenario.times(), laid.reference, record.velocity, record.torque, scenario.last_change
            ).rms_error_settled
    except (ArithmeticError, ValueError):
        return math.inf
    return found if math.isfinite(found) else math.inf


def find_own_bandwidth(
    scenario: Scenario,
    maker: Maker,
    *,
    seeds: Sequence[int] = TUNING_SEEDS,
    progress: Callable[[float], None] | None = None,
) -> OwnBandwidth:
    """Find the bandwidth at which a controller does best.

    Parameters
    ----------
    scenario : Scenario
        The scenario; its own bandwidth or gains and its seed play no part.
    maker : callable
        Makes the controller for a scenario.
    seeds : sequence of int, optional
        Seeds of noise and reference on which it is chosen.
    progress : callable, optional
        Is called with the share done, from 0 to 1.

    Returns
    -------
    OwnBandwidth
        The errors over the bandwidths.

    Raises
    ------
    ArithmeticError
        The loop fails at every bandwidth.
    """
    tried = tried_bandwidths(scenario)
    seeded = [scenario.modified(seed=seed) for seed in seeds]
    runs = [(one, lay_course(with_bandwidth(one, tried[0]))) for one in seeded]
    errors = []
    for place, bandwidth in enumerate(tried):
        found = [settled_error(with_bandwidth(one, bandwidth), maker, course) for one, course in runs]
        errors.append(float(np.median(found)))
        if progress is not None:
            progress((place + 1) / len(tried))
    if not math.isfinite(min(errors)):
        raise ArithmeticError("the simulation fails at every bandwidth that was tried")
    return OwnBandwidth(tuple(tried), tuple(errors))


def in_own_loop(scenario: Scenario, maker: Maker) -> Scenario:
    """Return a scenario with the bandwidth that suits a controller where its own is ``auto``; else the scenario."""
    if not scenario.feedback.is_auto:
        return scenario
    return with_bandwidth(
        scenario, _best_bandwidth(scenario.modified(seed=0).model_dump_json(exclude_unset=True), maker)
    )


@lru_cache(maxsize=256)
def _best_bandwidth(text: str, maker: Maker) -> float:
    return find_own_bandwidth(Scenario.model_validate_json(text), maker).best
