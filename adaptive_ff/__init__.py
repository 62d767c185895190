"""Adaptive friction-compensating velocity control: identification, feedforward, comparison."""

from adaptive_ff.adaptive import AdaptiveController
from adaptive_ff.batch import identify_series, identify_torque_form
from adaptive_ff.compare import Comparison, compare
from adaptive_ff.errors import InputError
from adaptive_ff.measured import Log, LogIdentification, identify_log, read_log
from adaptive_ff.model import PER_DIRECTION, WITH_OFFSET, TorqueModel
from adaptive_ff.regression import assert_no_regression, read_baseline, regressions
from adaptive_ff.scenario import Scenario, load_scenario, parse_scenario
from adaptive_ff.simulate import Run, simulate
from adaptive_ff.stribeck_fit import fit_stribeck
from adaptive_ff.support_points import support_points

__all__ = [
    "PER_DIRECTION",
    "WITH_OFFSET",
    "AdaptiveController",
    "Comparison",
    "InputError",
    "Log",
    "LogIdentification",
    "Run",
    "Scenario",
    "TorqueModel",
    "assert_no_regression",
    "compare",
    "fit_stribeck",
    "identify_log",
    "identify_series",
    "identify_torque_form",
    "load_scenario",
    "parse_scenario",
    "read_baseline",
    "read_log",
    "regressions",
    "simulate",
    "support_points",
]
