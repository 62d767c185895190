"""Controllers whose export is measured: every kind that compare knows, and all variants of the adaptive one."""

import itertools
from collections.abc import Callable
from functools import partial
from typing import Any

from adaptive_ff import AdaptiveController, load_scenario
from adaptive_ff.comparison.registry import CONTROLLERS
from adaptive_ff.friction.model import ESTIMATED, PER_DIRECTION, PER_DIRECTION_WITH_GRAVITY, WITH_GRAVITY, WITH_OFFSET
from controllers import PI

SIZES = {
    "symmetric": ESTIMATED,
    "offset": WITH_OFFSET,
    "gravity": WITH_GRAVITY,
    "directions": PER_DIRECTION,
}
SEED = 1


def adaptive(size: str, delay: float, velocity_lag: float) -> AdaptiveController:
    """Make an adaptive controller for the built-in joint."""
    design = PI.design(inertia=20.0, period=0.01, bandwidth=10.0)
    settings: dict[str, Any] = {"inertia": 20.0, "stribeck_velocity": 0.05, "parameters": SIZES[size]}
    settings |= {"delay": delay, "velocity_lag": velocity_lag}
    return AdaptiveController(design.proportional, design.integral, 0.01, **settings)


def everything() -> AdaptiveController:
    """Make an adaptive controller with all that it can learn: 28 columns."""
    design = PI.design(inertia=20.0, period=0.01, bandwidth=10.0)
    settings: dict[str, Any] = {"inertia": 20.0, "stribeck_velocity": 0.05, "delay": 1.5, "velocity_lag": 0.004}
    settings |= {"parameters": PER_DIRECTION_WITH_GRAVITY, "ripple_periods": [0.02], "position_periods": [0.3]}
    settings |= {"position_hats": 5, "load_friction": True, "regressors": 2}
    return AdaptiveController(design.proportional, design.integral, 0.01, **settings)


def variants() -> dict[str, Callable[[], Any]]:
    """Return functions that make a controller of each kind and variant, by name."""
    prompt = load_scenario()
    delayed = prompt.modified(actuator={"delay": 0.015}, feedback={"bandwidth": 3.0})
    found: dict[str, Callable[[], Any]] = {}
    kinds = set()
    for scenario, word in ((prompt, ""), (delayed, ", delay 1.5")):
        for name, maker in CONTROLLERS.items():
            kind = (type(maker(scenario)), type(maker(scenario).parameters), word)
            if name != "adaptive" and kind not in kinds:
                kinds.add(kind)
                found[f"{name}{word}"] = lambda maker=maker, scenario=scenario: maker(scenario)
    for size, delay, lag in itertools.product(SIZES, (0.0, 1.5), (0.0, 0.004)):
        found[f"adaptive, {size}, delay {delay}, velocity lag {lag}"] = partial(adaptive, size, delay, lag)
    return found
