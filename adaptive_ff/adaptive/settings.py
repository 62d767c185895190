"""Parameters of the adaptive controller from what a user gives: names, ranges, prior, defaults."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from adaptive_ff.adaptive.adaptive_state import AdaptiveParameters
from adaptive_ff.adaptive.command import CommandParameters
from adaptive_ff.adaptive.learning.candidate_choice import (
    begin_velocity,
    candidate_distances,
    candidate_velocities,
)
from adaptive_ff.adaptive.learning.estimator_state import EstimatorParameters
from adaptive_ff.adaptive.learning.map_settings import MAP_MEMORY, checked_periods, map_parameters
from adaptive_ff.adaptive.prior import prior_of
from adaptive_ff.model.bounds import largest_lag
from adaptive_ff.model.friction import FURTHER, TorqueModel, ripple_names
from adaptive_ff.model.identifying import ALL_CHOICES, check_parameters, has_gravity
from adaptive_ff.regression.torque_form import TorqueForm
from controllers import check_gains, check_positive
from controllers.checks import check_numbers, checked_switch
from controllers.plausible_sizes import LARGEST_VELOCITY, inertia_bounds

GATE_SHARE = 0.2
"""Speed of the gate, as a share of the Stribeck velocity."""

GATE_HOLD = 3.0
"""Hold of the gate, in time constants of the filters."""

MEMORY = 320.0
"""Default memory, in geometric means of the sampling period and the time constant of the filters."""

DEVIATION = 0.2
"""How sure a first model is where nothing else is said, as a share of each of its values."""

MOST_REGRESSORS = 20
"""Most further regressors: with some 25 columns and more, all of them are learnt worse."""

LARGEST_REGRESSOR = 1e6
"""Largest further regressor: they are of the size of one, and from far larger ones no estimator goes on."""

FASTEST = 65.0
"""Fastest pole of the observer by default, rad/s: what it is for changes no faster, and a fast loop has no margin left.

At 50 Hz with an encoder (seeds 101, 103, 104) one as fast as the loop settles at 1.1 times PI, with 1/4 and 1/10 of
that at 1.7; in a loop of 10 Hz or less it is the crossover that counts.
"""


def further_names(count: int) -> tuple[str, ...]:
    """Return the names of the sizes of so many further regressors, or raise ``ValueError`` for no such number."""
    if isinstance(count, bool) or not isinstance(count, int | np.integer) or not 0 <= count <= MOST_REGRESSORS:
        raise ValueError(f"regressors = {count} is not allowed: it must be a whole number from 0 to {MOST_REGRESSORS}")
    return tuple(f"{FURTHER}{number}" for number in range(1, count + 1))


def default_memory(period: float, pole: float) -> float:
    """Return the memory (s of sliding motion) that suits a sampling period (s) and a pole of the filters (rad/s).

    The more samples there are in a second and the faster the filters, the more equations average the noise. The factor
    suited loops of 5 and 10 Hz at 1 kHz, 100 Hz and 22 ms (seeds from 101 on).
    """
    return MEMORY * math.sqrt(period / pole)


def check_machine(proportional: float, inertia: float, stribeck_velocity: float) -> None:
    """Raise ``ValueError`` for an inertia (kg m^2) or a Stribeck velocity (rad/s) that no machine of the loop has.

    The messages name no units: a controller is not told whether its axis turns or is linear.
    """
    check_positive(proportional=proportional, inertia=inertia, stribeck_velocity=stribeck_velocity)
    least, most = inertia_bounds(proportional)
    if not least < inertia < most:
        raise ValueError(
            f"inertia = {inertia} is not allowed with proportional = {proportional}: it must be between {least:g} and "
            f"{most:g}"
        )
    if stribeck_velocity > LARGEST_VELOCITY:
        raise ValueError(
            f"stribeck_velocity = {stribeck_velocity} is not allowed: it must be {LARGEST_VELOCITY:g} at most"
        )


def adaptive_parameters(
    proportional: float,
    integral: float,
    period: float,
    *,
    inertia: float,
    stribeck_velocity: float,
    stribeck_shape: float,
    memory: float | None,
    filter_pole: float | None,
    parameters: Sequence[str],
    delay: float,
    velocity_lag: float,
    tunes_lag: bool,
    regressors: int,
    gear_ratio: float,
    ripple_periods: Sequence[float],
    model: TorqueModel | Mapping[str, float] | None = None,
    deviation: float | Mapping[str, float] = DEVIATION,
    torque_limit: float = math.inf,
    feedforward_includes_inertia: bool = False,
    stribeck_factors: Sequence[float] = (),
    presliding_factors: Sequence[float] = (),
    position_periods: Sequence[float] = (),
    position_hats: int = 0,
    position_range: Sequence[float] | None = None,
    load_friction: bool = False,
    map_memory: float = MAP_MEMORY,
) -> tuple[tuple[str, ...], AdaptiveParameters]:
    """Return the names of what is estimated and the kernel's parameters; see :class:`AdaptiveController`.

    Raises
    ------
    ValueError
        A value is out of range.
    """
    feedback = check_gains(proportional, integral, period, delay)
    names = check_parameters(parameters, ALL_CHOICES)
    ripples = checked_periods("ripple_periods", ripple_periods)
    named = (*names, *ripple_names(ripples.size), *further_names(regressors))
    if 2 * ripples.size + regressors > MOST_REGRESSORS:
        raise ValueError(
            f"regressors = {regressors} is not allowed: with {ripples.size} ripple_periods, two columns each, it must "
            f"be {MOST_REGRESSORS - 2 * ripples.size} at most"
        )
    check_machine(proportional, inertia, stribeck_velocity)
    check_positive(stribeck_shape=stribeck_shape, period=period)
    pole = proportional / inertia if filter_pole is None else filter_pole
    check_positive(filter_pole=pole)
    memory = default_memory(period, pole) if memory is None else memory
    check_positive(memory=memory)
    check_numbers(velocity_lag=velocity_lag, gear_ratio=gear_ratio, torque_limit=torque_limit)
    if not 0.0 <= velocity_lag < math.inf:
        raise ValueError(f"velocity_lag = {velocity_lag} s is not allowed: it must be zero or more and finite")
    if not (math.isfinite(gear_ratio) and gear_ratio != 0.0):
        raise ValueError(f"gear_ratio = {gear_ratio} is not allowed: it must be finite and not zero")
    if not torque_limit > 0.0:
        raise ValueError(f"torque_limit = {torque_limit} N m is not allowed: it must be positive")
    prior, ranges = prior_of(
        named,
        inertia=float(inertia),
        proportional=float(proportional),
        stribeck=(float(stribeck_velocity), float(stribeck_shape)),
        largest_lag=largest_lag(inertia / proportional),
        model=model,
        deviation=deviation,
    )
    velocities = candidate_velocities(float(stribeck_velocity), stribeck_factors)
    over_load = checked_switch("load_friction", load_friction)
    unit = float(proportional * stribeck_velocity)
    estimator = EstimatorParameters(
        form=TorqueForm(float(pole), float(stribeck_velocity), float(stribeck_shape)),
        first=prior.first,
        scale=prior.scale,
        torque_scale=unit,
        memory=float(memory),
        ranges=ranges,
        regressors=int(regressors),
        waves=np.append(np.ones(1 if has_gravity(names) else 0), 2.0 * math.pi / ripples),
        gear_ratio=float(gear_ratio),
        deviation=prior.deviation,
        given=prior.given,
        candidates=velocities,
        presliding=candidate_distances(float(stribeck_velocity / pole), presliding_factors),
        fit_scale=np.append(prior.scale[: len(names) - (2 if has_gravity(names) else 0)], prior.scale[1]),
        begin=begin_velocity(velocities, float(stribeck_velocity), model),
        friction_map=map_parameters(
            position_periods, position_hats, position_range, unit if over_load else 0.0, map_memory
        ),
        rises=False,
    )
    return named, AdaptiveParameters(
        feedback=feedback,
        estimator=estimator,
        slowest=GATE_SHARE * float(stribeck_velocity),
        hold=GATE_HOLD / float(pole),
        velocity_lag=float(velocity_lag),
        period=float(period),
        tunes_lag=checked_switch("tunes_lag", tunes_lag),
        command=CommandParameters(
            float(torque_limit), checked_switch("feedforward_includes_inertia", feedforward_includes_inertia)
        ),
    )


def observer_pole(block: AdaptiveParameters, inertia: float, bandwidth: float | None) -> float:
    """Return the pole of the observer (rad/s) for a bandwidth in Hz, at most the crossover of the feedback.

    By default it is the crossover, less where the drive is late, and at most :data:`FASTEST`.
    """
    crossover = block.feedback.proportional / inertia
    if bandwidth is None:
        # a delay of d samples costs the observer's loop the phase that it costs the feedback once more
        return min(crossover / (1.0 + 2.0 * block.feedback.delay * block.period * crossover), FASTEST)
    check_positive(observer_bandwidth=bandwidth)
    return min(2.0 * math.pi * float(bandwidth), crossover)
