"""Parameters of the adaptive controller from what a user gives: names, ranges, prior, defaults."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

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
from adaptive_ff.friction.bounds import largest_lag
from adaptive_ff.friction.identifying import ALL_CHOICES, check_parameters, has_gravity
from adaptive_ff.friction.model import FURTHER, TorqueModel, ripple_names
from adaptive_ff.learning.torque_form import TorqueForm
from controllers import check_gains, check_positive
from controllers.checks import check_numbers, check_velocity_lag, checked_switch
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


class Settings(NamedTuple):
    """What an adaptive controller is made with, as it was given; see :class:`AdaptiveController` for each.

    What has a default here is what a controller without supervision does not take.
    """

    proportional: float
    integral: float
    period: float
    inertia: float
    stribeck_velocity: float
    stribeck_shape: float
    memory: float | None
    filter_pole: float | None
    parameters: Sequence[str]
    delay: float
    velocity_lag: float
    tunes_lag: bool
    regressors: int
    gear_ratio: float
    ripple_periods: Sequence[float]
    model: TorqueModel | Mapping[str, float] | None = None
    deviation: float | Mapping[str, float] = DEVIATION
    torque_limit: float = math.inf
    feedforward_includes_inertia: bool = False
    stribeck_factors: Sequence[float] = ()
    presliding_factors: Sequence[float] = ()
    position_periods: Sequence[float] = ()
    position_hats: int = 0
    position_range: Sequence[float] | None = None
    load_friction: bool = False
    map_memory: float = MAP_MEMORY


def settings_among(values: Mapping[str, Any]) -> Settings:
    """Return the settings among values by name, such as the arguments of a constructor."""
    return Settings(**{name: values[name] for name in Settings._fields if name in values})


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


def filter_pole(given: Settings) -> float:
    """Return the pole of the regression's filters, rad/s: by default the crossover of the feedback."""
    return given.proportional / given.inertia if given.filter_pole is None else given.filter_pole


def estimator_memory(given: Settings) -> float:
    """Return the memory of the estimator, s of sliding motion."""
    return default_memory(given.period, filter_pole(given)) if given.memory is None else given.memory


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


def check_settings(given: Settings) -> None:
    """Raise ``ValueError`` for the first number of machine, filters or drive that is out of range."""
    check_machine(given.proportional, given.inertia, given.stribeck_velocity)
    check_positive(stribeck_shape=given.stribeck_shape, period=given.period)
    check_positive(filter_pole=filter_pole(given))
    check_positive(memory=estimator_memory(given))
    check_velocity_lag(given.velocity_lag, given.period)
    gear_ratio, torque_limit = given.gear_ratio, given.torque_limit
    check_numbers(gear_ratio=gear_ratio, torque_limit=torque_limit)
    if not (math.isfinite(gear_ratio) and gear_ratio != 0.0):
        raise ValueError(f"gear_ratio = {gear_ratio} is not allowed: it must be finite and not zero")
    if not torque_limit > 0.0:
        raise ValueError(f"torque_limit = {torque_limit} N m is not allowed: it must be positive")


def estimated_names(given: Settings) -> tuple[str, ...]:
    """Return the names of what is estimated: those of friction, of ripples, and of further regressors."""
    ripples = checked_periods("ripple_periods", given.ripple_periods).size
    named = (*given.parameters, *ripple_names(ripples), *further_names(given.regressors))
    if 2 * ripples + given.regressors > MOST_REGRESSORS:
        raise ValueError(
            f"regressors = {given.regressors} is not allowed: with {ripples} ripple_periods, two columns each, it must "
            f"be {MOST_REGRESSORS - 2 * ripples} at most"
        )
    return named


def estimator_parameters(given: Settings, named: Sequence[str]) -> EstimatorParameters:
    """Return the parameters of the estimator, whose estimates have these names, for settings that are checked."""
    stribeck_velocity, stribeck_shape = float(given.stribeck_velocity), float(given.stribeck_shape)
    prior, ranges = prior_of(
        named,
        inertia=float(given.inertia),
        proportional=float(given.proportional),
        stribeck=(stribeck_velocity, stribeck_shape),
        largest_lag=largest_lag(given.inertia / given.proportional),
        model=given.model,
        deviation=given.deviation,
    )
    velocities = candidate_velocities(stribeck_velocity, given.stribeck_factors)
    over_load = checked_switch("load_friction", given.load_friction)
    pole, unit = filter_pole(given), float(given.proportional * given.stribeck_velocity)
    names, ripples = given.parameters, checked_periods("ripple_periods", given.ripple_periods)
    return EstimatorParameters(
        form=TorqueForm(float(pole), stribeck_velocity, stribeck_shape),
        first=prior.first,
        scale=prior.scale,
        torque_scale=unit,
        memory=float(estimator_memory(given)),
        ranges=ranges,
        regressors=int(given.regressors),
        waves=np.append(np.ones(1 if has_gravity(names) else 0), 2.0 * math.pi / ripples),
        gear_ratio=float(given.gear_ratio),
        deviation=prior.deviation,
        given=prior.given,
        candidates=velocities,
        presliding=candidate_distances(float(given.stribeck_velocity / pole), given.presliding_factors),
        fit_scale=np.append(prior.scale[: len(names) - (2 if has_gravity(names) else 0)], prior.scale[1]),
        begin=begin_velocity(velocities, stribeck_velocity, given.model),
        friction_map=map_parameters(
            given.position_periods,
            given.position_hats,
            given.position_range,
            unit if over_load else 0.0,
            given.map_memory,
        ),
        rises=False,
    )


def adaptive_parameters(given: Settings) -> tuple[tuple[str, ...], AdaptiveParameters]:
    """Return the names of what is estimated and the kernel's parameters.

    Raises
    ------
    ValueError
        A value is out of range.
    """
    feedback = check_gains(given.proportional, given.integral, given.period, given.delay)
    given = given._replace(parameters=check_parameters(given.parameters, ALL_CHOICES))
    named = estimated_names(given)
    check_settings(given)
    return named, AdaptiveParameters(
        feedback=feedback,
        estimator=estimator_parameters(given, named),
        slowest=GATE_SHARE * float(given.stribeck_velocity),
        hold=GATE_HOLD / float(filter_pole(given)),
        velocity_lag=float(given.velocity_lag),
        period=float(given.period),
        tunes_lag=checked_switch("tunes_lag", given.tunes_lag),
        command=CommandParameters(
            float(given.torque_limit),
            checked_switch("feedforward_includes_inertia", given.feedforward_includes_inertia),
        ),
    )


def observer_poles(block: AdaptiveParameters, inertia: float, bandwidth: float | None) -> tuple[float, float]:
    """Return the poles of the observer (rad/s) for a bandwidth in Hz, at most the crossover of the feedback.

    The first is that of a joint that moves. By default it is the crossover, less where the drive is late, and at most
    :data:`FASTEST`. The second is that of a joint that stands before anything is learnt. It answers to no torque, so
    a late drive costs that loop no phase: what it has taken of the pole is given back, and once more for what a torque
    that acts late loses. With a delay of a period the first 5 s leave 0.41 of the error of PI without that, 0.32 where
    it is given back once, and 0.26 as it is (scenario ``delay``, seeds 201 to 230). A pole at the crossover has lost
    nothing and stays. If it were raised as well, of 1000 machines 23 and not 20 would have a window above 1.2 times the
    error of PI.
    """
    crossover = block.feedback.proportional / inertia
    # a delay of d samples costs the observer's loop the phase that it costs the feedback once more
    late = 1.0 + 2.0 * block.feedback.delay * block.period * crossover
    if bandwidth is None:
        pole = min(crossover / late, FASTEST)
    else:
        check_positive(observer_bandwidth=bandwidth)
        pole = min(2.0 * math.pi * float(bandwidth), crossover)
    taken = min(late, crossover / pole)
    return pole, min(pole * taken * taken, max(pole, FASTEST))
