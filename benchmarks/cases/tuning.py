"""The search for what the sources of the other controllers leave open, on joints and seeds that are not reported.

A controller is written with the numbers that its maker takes after the scenario, such as ``super_twisting 30``.
"""

import importlib
from typing import Any

from adaptive_ff import load_scenario, simulate
from adaptive_ff.studies.study import Found
from adaptive_ff.studies.tracking import run_errors
from benchmarks.suite import Case, seeded

MODULES = ("adaptive_ff.comparison.registry", "adaptive_ff.comparison.literature")
"""Where the makers are, as ``make_NAME``."""

RATES = {"100 Hz": 0.01, "1 kHz": 0.001}

JOINTS: dict[str, dict[str, Any]] = {
    "slow": {
        "joint": {"friction_lag": 0.01, "stribeck_velocity": 0.08},
        "reference": {
            "frequencies": [0.013, 0.06, 0.15, 0.3, 0.6],
            "amplitudes": [1.0, 0.8, 0.6, 0.5, 0.4],
            "peak": 0.2,
        },
    },
    "heavy": {
        "joint": {"coulomb": 90.0, "stiction": 120.0, "viscous": 60.0, "friction_lag": 0.03},
        "sensor": {"velocity_noise": 0.001},
        "reference": {"frequencies": [0.02, 0.09, 0.31, 0.8], "amplitudes": [1.0, 0.9, 0.5, 0.3], "peak": 0.5},
    },
    "light": {
        "joint": {"coulomb": 25.0, "stiction": 35.0, "viscous": 120.0},
        "sensor": {"velocity_noise": 0.004},
        "reference": {"frequencies": [0.017, 0.12, 0.5, 1.3], "amplitudes": [1.0, 1.0, 0.6, 0.3], "peak": 0.4},
    },
}
"""What differs from the built-in joint."""

MADE_FOR: dict[str, dict[str, Any]] = {
    "repetitive": {"reference": {"frequencies": [0.25, 0.5, 1.5], "amplitudes": [1.0, 0.5, 0.3]}},
    "lee_tomizuka": {"position": {}},
    "friction_observer": {"joint": {"kind": "elasto_plastic", "presliding": 2e-3}},
}
"""What a controller was made for: a period, a position loop, a presliding joint."""


def maker_of(name: str) -> Any:
    """Return the function that makes a controller of a name."""
    modules = map(importlib.import_module, MODULES)
    return next(getattr(module, f"make_{name}") for module in modules if hasattr(module, f"make_{name}"))


def run_joint(joint: str, rate: str, seed: int, controllers: list[str]) -> Found:
    """Return the settled error of each candidate."""
    plain = load_scenario().modified(seed=seed, sampling={"period": RATES[rate]}, **JOINTS[joint])
    found = {}
    for text in controllers:
        name, *numbers = text.split()
        tables = MADE_FOR.get(name, {})
        if "joint" in tables:
            tables = {"joint": {**plain.joint.model_dump(exclude_unset=True), **tables["joint"]}}
        scenario = plain.modified(**tables)
        controller = maker_of(name)(scenario, *map(float, numbers))
        found[text] = {"error": run_errors(simulate(scenario, controller, uncertain=False)).settled}
    return {"": {"row": f"{joint}, {rate}"}, **found}


def joints(count: int, first: int = 101) -> list[Case]:
    """Return all joints at all rates."""
    rows = ((f"{joint}, {rate}", (joint, rate)) for joint in JOINTS for rate in RATES)
    return seeded(run_joint, rows, count, first)
