"""Figures of short runs of everything, to seven digits.

``PYTHONPATH=. python tests/helpers/figures.py`` stores those of today. A change of behaviour shows here, by name;
whether it is wanted, the suites of ``benchmarks`` say.
"""

import json
import warnings
from dataclasses import asdict
from pathlib import Path
from unittest.mock import patch

import numpy as np
from part_figures import CURVE, PARTS, numbers, rms
from picture_figures import PICTURES

from adaptive_ff import load_scenario, simulate
from adaptive_ff.comparison.registry import CONTROLLERS
from adaptive_ff.identify.identification import identify_log
from adaptive_ff.identify.score import score_log
from adaptive_ff.logs.log import Log
from adaptive_ff.replay.replay import replay_log
from adaptive_ff.simulation.metrics import standstill_range
from adaptive_ff.studies.tracking import run_errors

STORED = Path(__file__).resolve().parent.parent / "figures.json"

SCENARIOS = """
    paper_100hz noisy_1khz encoder encoder_difference jittered_22ms asymmetric servo high_stiction via_points
    triangle pick_and_place positioning friction_triples load_step_80 payload_double vs_half inertia_low
    inertia_high delay delay_unknown saturation lugre elastic backlash gravity_40 elasto_plastic maxwell rolling
    friction_over_position friction_over_load friction_over_temperature slow_025 steep_10 standstill"""
"""Scenarios in which ``adaptive`` runs; each other controller runs in that of the paper."""

FEATURES = {
    "gravity": ("gravity_100", {"adaptation": {"identify": "gravity"}}),
    "ripples": ("gravity_40", {"adaptation": {"identify": "gravity", "ripple_periods": [0.05, 0.4]}}),
    "periods": ("friction_over_position", {"adaptation": {"position_periods": [0.5]}}),
    "hats": ("friction_over_position", {"adaptation": {"position_hats": 6, "position_range": [-1.5, 1.5]}}),
    "less friction": ("high_stiction", {"adaptation": {"friction_share": 0.6, "memory": 20.0}}),
    "late": ("noisy_1khz", {"actuator": {"delay": 0.002}}),
    "faulty sensor": ("paper_100hz", {"sensor": {"leap": 0.3, "leap_share": 0.01, "held": 3, "held_share": 0.02}}),
    "angle": ("encoder", {"sensor": {"ripple_amplitude": 1e-3, "ripple_period": 0.2, "held": 2, "held_share": 0.01}}),
    "coarse drive": (
        "paper_100hz",
        {"actuator": {"torque_resolution": 5.0, "rate_limit": 2000.0, "ripple_amplitude": 3.0}},
    ),
    "path of an elastic joint": ("elastic", {"position": {}}),
    "unspecified limit": ("saturation", {"actuator": {"reports_torque": False}}),
}
"""Features of ``adaptive``: a scenario, and what is changed in it."""


def short(name, seconds=8.0):
    """Return a scenario of the package, or with a feature, shortened: what changes does so as far on the way."""
    name, changes = FEATURES.get(name, (name, {}))
    scenario = load_scenario(name).modified(**changes)
    scale = min(1.0, seconds / scenario.duration)
    pause = getattr(scenario.reference, "pause", None)
    pause = {"reference": {"pause": [scale * one for one in pause]}} if pause else {}
    change = [{**one.model_dump(exclude_unset=True), "time": round(one.time * scale, 2)} for one in scenario.change]
    return scenario.modified(duration=seconds, seed=101, **pause, **({"change": change} if change else {}))


def run_figures(name, controller="adaptive"):
    """Return errors, figures of merit, torque and estimates of a run."""
    run = simulate(short(name), CONTROLLERS[controller](short(name)), name=controller)
    error = run.reference - run.velocity if run.position_error is None else run.position_error
    found = {"error": rms(error), "late error": rms(error[error.size // 2 :]), "torque": rms(run.torque)}
    found |= {"feedforward": rms(run.feedforward), "windows": rms(run_errors(run).series)}
    found |= dict(numbers(asdict(run.metrics) | asdict(run.position_metrics or run.metrics)))
    found |= dict(numbers({"standstill": standstill_range(run.solver_time, run.reference, run.velocity)}))
    found |= {f"estimate {key}": float(values[-1]) for key, values in run.estimates.items()}
    found |= {f"uncertainty {key}": float(values[-1]) for key, values in run.uncertainties.items()}
    return found


def recorded(kind, seconds=20.0, seed=101, **joint):
    """Return the log of a joint under PI."""
    scenario = load_scenario("paper_100hz").modified(
        seed=seed, duration=seconds, sampling={"period": 0.005}, joint={"kind": kind, "solver_period": 5e-4, **joint}
    )
    run = simulate(scenario, "pi")
    size, generator = run.time.size, np.random.default_rng(seed)
    position = np.cumsum(run.velocity)[:: run.velocity.size // size][:size] * scenario.joint.solver_period
    torque = run.torque[:size] + 0.3 * generator.standard_normal(size)
    return Log(f"{kind} {seed}", run.time, torque, position=position)


LOGS = {
    "stribeck": ("stribeck", {}),
    "lugre": ("lugre", {**CURVE, "stiffness": 2e4}),
    "viscous": ("stribeck", {"stiction": 60.0, "viscous": 150.0, "friction_lag": 0.0}),
}
"""Joints whose logs are identified, replayed and scored."""


def log_figures(name):
    """Return what is identified from a log, replayed along another one, and simulated in open loop."""
    kind, joint = LOGS[name]
    log, other = recorded(kind, **joint), recorded(kind, seed=102, **joint)
    asked = {"validation": other, "held_out": 0.3}
    found = identify_log(log, **asked)
    left = {key: one._asdict() for key, one in replay_log(other).left.items()}
    del left["fixed"]["whole"]  # its first samples hang on a lag that nothing determines
    with patch("adaptive_ff.identify.score.identify_log", lambda *given, **more: found if more == asked else None):
        score = score_log(log, other, held_out=0.3).to_dict() | {"identification": {}}
    return dict(numbers({"identified": found.to_dict(), "left": left, "score": score}))


CASES = {
    **{f"adaptive in {name}": (run_figures, (name,)) for name in (*SCENARIOS.split(), *FEATURES)},
    **{f"{name} in paper_100hz": (run_figures, ("paper_100hz", name)) for name in CONTROLLERS},
    **{f"log of {name}": (log_figures, (name,)) for name in LOGS},
    **PICTURES,
    **PARTS,
}


def figures(case):
    """Return the figures of a case: numbers, and texts or digests of them."""
    function, arguments = CASES[case]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = function(*arguments)
    rounded = {name: value if isinstance(value, str) else float(f"{value:.7g}") for name, value in found.items()}
    return {name: value for name, value in rounded.items() if isinstance(value, str) or np.isfinite(value)}


if __name__ == "__main__":
    STORED.write_text(json.dumps({case: figures(case) for case in CASES}, indent=0) + "\n", encoding="utf-8")
