"""Adaptive friction-compensating velocity control: identification, feedforward, comparison."""

from adaptive_ff.adaptive import AdaptiveController
from adaptive_ff.compare import Comparison, compare
from adaptive_ff.errors import InputError
from adaptive_ff.model import TorqueModel
from adaptive_ff.regression import assert_no_regression, read_baseline, regressions
from adaptive_ff.scenario import Scenario, load_scenario, parse_scenario
from adaptive_ff.simulate import Run, simulate

__all__ = [
    "AdaptiveController",
    "Comparison",
    "InputError",
    "Run",
    "Scenario",
    "TorqueModel",
    "assert_no_regression",
    "compare",
    "load_scenario",
    "parse_scenario",
    "read_baseline",
    "regressions",
    "simulate",
]
