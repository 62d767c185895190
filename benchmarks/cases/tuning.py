"""The search for what the sources of the other controllers leave open, on joints and seeds that are not reported.

A controller is written with the numbers that its maker takes after the scenario, such as ``super_twisting 30``.
"""

import tomllib
from pathlib import Path

from adaptive_ff import load_scenario, simulate
from adaptive_ff.comparison.registry import CONTROLLERS
from adaptive_ff.studies.study import Found
from adaptive_ff.studies.tracking import run_errors
from benchmarks.suite import seeded

RATES = {"100 Hz": 0.01, "1 kHz": 0.001}

TABLES = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))


def run_joint(joint: str, rate: str, seed: int, controllers: list[str]) -> Found:
    """Return the settled error of each candidate."""
    plain = load_scenario().modified(seed=seed, sampling={"period": RATES[rate]}, **TABLES["joints"][joint])
    found = {}
    for text in controllers:
        name, *numbers = text.split()
        tables = TABLES["made_for"].get(name, {})
        if "joint" in tables:
            tables = {"joint": {**plain.joint.model_dump(exclude_unset=True), **tables["joint"]}}
        scenario = plain.modified(**tables)
        controller = CONTROLLERS[name](scenario, *map(float, numbers))
        found[text] = {"error": run_errors(simulate(scenario, controller, uncertain=False)).settled}
    return {"": {"row": f"{joint}, {rate}"}, **found}


ROWS = {f"{joint}, {rate}": (joint, rate) for joint in TABLES["joints"] for rate in RATES}
joints = seeded(run_joint, ROWS, first=101)
