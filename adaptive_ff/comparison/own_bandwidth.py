"""The bandwidth at which a controller does best on a scenario: error over bandwidth, on seeds that are not reported.

On a common PI loop a good compensator is held to the bandwidth that suits the others, and a weak one is helped by a
loop that is slow. Two errors are weighed: the settled one, and the one after a step of the load of 0.4 of the rated
torque, which a slow loop stands badly. Each is taken over what PI leaves at its own best bandwidth, and the larger of
the two ratios is the cost. PI's own two are taken over the least that it leaves at any bandwidth (a Chebyshev distance
from the ideal point). It is searched up to the fastest loop that a maximum sensitivity of 1.7 allows.
"""

import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.comparison.running import drive_over
from adaptive_ff.scenario.loop import LOAD_FRACTION, load_step, tried_bandwidths
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.simulation.experiment import NO_POSITION_LOOP, RunSetup, build_setup
from adaptive_ff.simulation.metrics import settled_start
from adaptive_ff.simulation.tracking_errors import WINDOW, tracking_errors
from controllers import PI

Maker = Callable[..., Any]  # makes a controller, any object with a method ``step``, for a scenario
FIRST_TUNING_SEED = 101  # first of the seeds on which a bandwidth is chosen; reported ones begin at 1
TUNING_SEEDS = tuple(range(FIRST_TUNING_SEED, FIRST_TUNING_SEED + 3))  # those that a bandwidth is chosen on


class Errors(NamedTuple):
    """Root mean square errors of a run, rad/s; infinite where the loop fails."""

    settled: float  # settled, without the load
    loaded: float  # in the first 5 s after the step of the load


class OwnBandwidth(NamedTuple):
    """The bandwidth that suits a controller."""

    bandwidths: tuple[float, ...]  # bandwidths that were tried, ascending, Hz
    # settled rms error at each, and after the step of the load, medians over the seeds, rad/s; infinite where the loop
    # fails
    errors: tuple[float, ...]
    loaded: tuple[float, ...]
    costs: tuple[float, ...]  # the larger of the two, over PI's at its best bandwidth; of PI itself over its least

    @property
    def pairs(self) -> list[Errors]:
        """The two errors at each bandwidth."""
        return [Errors(*pair) for pair in zip(self.errors, self.loaded, strict=True)]

    @property
    def place(self) -> int:
        """Place of the best bandwidth among those that were tried."""
        return int(np.argmin(self.costs))

    @property
    def best(self) -> float:
        """The bandwidth of the least cost, Hz."""
        return self.bandwidths[self.place]

    @property
    def at_an_end(self) -> bool:
        """Whether the best bandwidth is the slowest or the fastest one that was tried."""
        return self.place in (0, len(self.bandwidths) - 1)


def own_bandwidth(
    bandwidths: Sequence[float], found: NDArray[np.float64], base: OwnBandwidth | None, allowed: Sequence[bool]
) -> OwnBandwidth:
    """Return what suits a controller, from its errors, settled and loaded, of shape (bandwidths, seeds, 2).

    They are weighed against those of PI at its best (``base``; None for PI itself); only allowed bandwidths are chosen.
    """
    medians = np.median(found, axis=1).T
    if not np.isfinite(medians[0][np.array(allowed)]).any():
        raise ArithmeticError("the simulation fails at every bandwidth that was tried")
    over = np.min(medians, axis=1) if base is None else np.array(base.pairs[base.place])
    with np.errstate(invalid="ignore", divide="ignore"):
        ratios = np.nan_to_num(medians / over[:, None], nan=1.0, posinf=np.inf)
    costs = np.where(allowed, np.maximum(*ratios), np.inf)
    if not np.isfinite(costs).any():  # no loop stands the load: the settled error alone decides
        costs = np.where(allowed, ratios[0], np.inf)
    return OwnBandwidth(*(tuple(map(float, one)) for one in (bandwidths, *medians, costs)))


def with_bandwidth(scenario: Scenario, bandwidth: float) -> Scenario:
    """Return a scenario whose feedback has another bandwidth (Hz) in the place of its own, or of its gains."""
    kept = scenario.feedback.model_dump(include={"inertia", "delay"}, exclude_unset=True)
    return scenario.replaced(feedback={**kept, "bandwidth": float(bandwidth)})


def loaded(scenario: Scenario, load: float = LOAD_FRACTION) -> Scenario:
    """Return a scenario with a step of the load, of the rated torque, at three quarters of the time since a change."""
    begin = scenario.last_change
    last = scenario.change[-1].model_dump(exclude_unset=True) if scenario.change else {}
    time = begin + 0.75 * (float(scenario.sample_steps[-1]) * scenario.joint.solver_period - begin)
    step = {**last, "time": time, "load": last.get("load", 0.0) + load_step(scenario, load)}
    return scenario.modified(change=[*scenario.change, step])


def errors_of(scenario: Scenario, maker: Maker, setup: RunSetup | None = None) -> Errors:
    """Return the errors of a controller in the loop of a scenario before and after its last change.

    The scenario is one that :func:`loaded` has made. A set-up may be given that differs from its own in the bandwidth.
    """
    squares = _squares(scenario, maker, setup)
    period, changes = scenario.joint.solver_period, [0.0, *(change.time for change in scenario.change)]
    before = squares[: math.ceil(changes[-1] / period - 1e-6)]
    after = squares[before.size :][: round(WINDOW / period)]
    begin = round(settled_start(changes[-2], before.size * period + (changes[-1] - changes[-2]) / 3.0) / period)
    return Errors(*(math.sqrt(float(np.mean(part))) for part in (before[begin:], after)))


def settled_error(scenario: Scenario, maker: Maker, setup: RunSetup | None = None) -> float:
    """Return the settled rms error (rad/s) of a controller in the loop of a scenario, infinite where it fails."""
    period, squares = scenario.joint.solver_period, _squares(scenario, maker, setup)
    return tracking_errors(squares, period, changes=[change.time for change in scenario.change]).settled


def _squares(scenario: Scenario, maker: Maker, setup: RunSetup | None) -> NDArray[np.float64]:
    """Return the squared errors on the solver's grid, rad^2/s^2, infinite where the loop fails."""
    try:
        controller = maker(scenario)
        built = build_setup(scenario) if setup is None else setup
        built = built._replace(outer=scenario.position_loop or NO_POSITION_LOOP)  # its gain may follow the bandwidth
        with np.errstate(over="ignore", invalid="ignore"):
            velocity = drive_over(controller, built).record.velocity
            squares: NDArray[np.float64] = np.square(built.reference - velocity)
    except (ArithmeticError, ValueError):
        return np.full(scenario.times().size, np.inf)
    return squares if np.isfinite(squares[-1]) else np.full(squares.size, np.inf)


def plain_pi(scenario: Scenario) -> PI:
    """Make the PI loop of a scenario."""
    return PI(*scenario.feedback.gains, scenario.sampling.period, delay=scenario.assumed_delay)


def find_own_bandwidth(scenario: Scenario, maker: Maker, seeds: tuple[int, ...] = TUNING_SEEDS) -> OwnBandwidth:
    """Find the bandwidth at which a controller does best, on some seeds of noise and reference.

    The scenario's own bandwidth or gains and its seed play no part; ``ArithmeticError`` where every loop fails.
    """
    text = scenario.modified(seed=0).model_dump_json(exclude_unset=True)
    tried = tried_bandwidths(scenario)
    allowed = [True] * len(tried)
    base = own_bandwidth(tried, _errors(text, plain_pi, seeds), None, allowed)
    return base if maker is plain_pi else own_bandwidth(tried, _errors(text, maker, seeds), base, allowed)


@lru_cache(maxsize=256)
def _errors(text: str, maker: Maker, seeds: tuple[int, ...]) -> NDArray[np.float64]:
    """Return the errors of a controller on a scenario (JSON), shape (bandwidths, seeds, 2)."""
    scenario = loaded(Scenario.model_validate_json(text))
    tried = tried_bandwidths(scenario)
    seeded = [scenario.modified(seed=seed) for seed in seeds]
    runs = [(one, build_setup(with_bandwidth(one, tried[0]))) for one in seeded]
    return np.array([[errors_of(with_bandwidth(one, hertz), maker, setup) for one, setup in runs] for hertz in tried])
