"""Corrections of an outer loop that mean harm, on the built-in joint.

An outer loop asks for up to 0.2 rad/s beside the reference, by a rule that no position loop would follow: 12 s of the
reference alone, so that friction is learnt, then 12 s with the correction. ``error`` is the rms of reference and
correction less the joint's velocity over these 12 s, rad/s; ``over_pi`` is that over PI's.
"""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from adaptive_ff import WITH_GRAVITY, load_scenario
from adaptive_ff.studies.study import Found
from benchmarks.cases.stepped import controller_class
from benchmarks.suite import seeded
from controllers import Controller
from plant import Joint

CORRECTION, LIMIT = 0.2, 400.0  # rad/s, N m
LEARNING, HOSTILE = 12.0, 12.0  # s

Rule = Callable[[int, float], float]
Array = NDArray[np.float64]


def rules(period: float, seed: int) -> dict[str, Rule]:
    """Return the corrections, as fractions of the largest, by sample and position (rad)."""
    draws = np.random.default_rng([seed, 5]).uniform(-1.0, 1.0, round((LEARNING + HOSTILE) / period))
    return {
        "none": lambda sample, position: 0.0,
        "square wave of 1.4 Hz": lambda sample, position: math.copysign(1.0, math.sin(9.0 * sample * period)),
        "another sign at every sample": lambda sample, position: (-1.0) ** sample,
        "drawn at every sample": lambda sample, position: float(draws[sample]),
        "away from where the joint is": lambda sample, position: math.copysign(1.0, math.sin(5.0 * position)),
    }


def squared_error(controller: Controller, rule: Rule, joint: Joint, plan: Array, noise: Array, period: float) -> float:
    """Return the mean squared error (rad^2/s^2) under a correction, for one plan and noise by sample."""
    steps, errors = round(period / joint.model.solver_period), []
    for sample in range(noise.size):
        state, begun = joint.state, sample * period >= LEARNING
        correction = CORRECTION * rule(sample, state.position) if begun else 0.0
        if begun:
            errors.append(plan[sample] + correction - state.velocity)
        given = {"next_reference": plan[sample + 1], "correction": correction, "position": state.position}
        torque = controller.step(plan[sample], state.velocity + noise[sample], **given)
        for _ in range(steps):
            joint.step(min(max(torque, -LIMIT), LIMIT), period / steps)
    return float(np.mean(np.square(errors)))


def run_rule(rule: str, seed: int, controllers: list[str]) -> Found:
    """Run controllers under a correction by name."""
    scenario = load_scenario().modified(seed=seed, duration=LEARNING + HOSTILE)
    period = scenario.sampling.period
    plan = scenario.reference_velocity()[:: round(period / scenario.joint.solver_period)]
    noise = scenario.sensor.velocity_noise * np.random.default_rng([seed, 6]).standard_normal(plan.size - 1)
    known = {"inertia": scenario.feedback.inertia, "stribeck_velocity": scenario.adaptation.stribeck_velocity}
    errors = {}
    for name in dict.fromkeys(["pi", *controllers]):
        given = {} if name == "pi" else {**known, "parameters": WITH_GRAVITY, "torque_limit": LIMIT}
        own = controller_class(name)(*scenario.feedback.gains, period, **given)
        square = squared_error(own, rules(period, seed)[rule], Joint(scenario.joint), plan, noise, period)
        errors[name] = math.sqrt(square)
    figures = {name: {"error": error, "over_pi": error / errors["pi"]} for name, error in errors.items()}
    return {"": {"row": rule}, **figures}


corrections = seeded(run_rule, {rule: (rule,) for rule in rules(1.0, 0)})
