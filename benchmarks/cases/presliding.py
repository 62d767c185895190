"""Joints whose bristles or elements bend before they slide, over 0.75 to 75 mrad, otherwise the built-in joint."""

from collections.abc import Callable
from functools import partial

import numpy as np

from adaptive_ff import Scenario, load_scenario
from adaptive_ff.scenario.library import SCENARIOS
from benchmarks.running import scenario_case
from benchmarks.suite import Case

SLIPS = np.array([0.3, 1.0, 2.0, 4.0])
"""Ways over which the four elements slip, one to another; their mean is what a row names."""


def bristles(stiffness: float, period: float = 0.01) -> Scenario:
    """Return the built-in joint with bristles (N m/rad), sampled with a period (s)."""
    scenario = load_scenario(SCENARIOS / "lugre_1e4.toml")
    return scenario.modified(
        joint=scenario.joint.model_copy(update={"stiffness": stiffness}),
        sampling=scenario.sampling.model_copy(update={"period": period}),
    )


def elements(mean: float) -> Scenario:
    """Return the built-in joint with four Maxwell elements that slip after a way (rad) in the mean."""
    scenario = load_scenario(SCENARIOS / "maxwell.toml")
    displacements = (mean * SLIPS / np.mean(SLIPS)).tolist()
    return scenario.modified(joint=scenario.joint.model_copy(update={"displacements": displacements}))


JOINTS: dict[str, Callable[[], Scenario]] = {
    **{f"LuGre {stiffness:.0e}": partial(bristles, stiffness) for stiffness in (1e3, 3e3, 1e4, 1e5)},
    "LuGre 1e+04, 1 kHz": partial(bristles, 1e4, 0.001),
    **{f"four Maxwell elements, {slip:g} mrad": partial(elements, 1e-3 * slip) for slip in (75.0, 25.0, 7.5, 0.75)},
}
"""Joints by name of their row."""


def seeded(name: str, seed: int) -> Scenario:
    """Return a joint with a seed."""
    return JOINTS[name]().modified(seed=seed)


def joints(count: int, draws: int = 1, first: int = 1) -> list[Case]:
    """Return all of them."""
    return [
        scenario_case(name, name, seed, partial(seeded, name, seed), draws)
        for name in JOINTS
        for seed in range(first, first + count)
    ]
