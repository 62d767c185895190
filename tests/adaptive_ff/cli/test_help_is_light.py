"""``adaptive-ff --help`` and ``import adaptive_ff`` load no more than they need."""

import inspect
import subprocess
import sys
from dataclasses import fields
from importlib.metadata import version

import pytest

import adaptive_ff
from adaptive_ff.cli import compare, identify, options
from adaptive_ff.comparison.fixed_models import FORMS, SOURCES
from adaptive_ff.comparison.gate import GATED
from adaptive_ff.comparison.registry import CONTROLLERS, FIXED
from adaptive_ff.identify.identification import identify_log
from adaptive_ff.replay.replay import replay_log
from adaptive_ff.studies.motion import MotionLimits

HEAVY = ("matplotlib", "control", "scipy", "filterpy", "numpy", "plant", "controllers")


def loaded_after(code):
    """Which heavy packages a fresh interpreter has loaded after some code, output of the code left out."""
    report = f"import sys; print(*[name for name in {HEAVY} if name in sys.modules], file=sys.stderr)"
    done = subprocess.run([sys.executable, "-c", f"{code}\n{report}"], capture_output=True, text=True, check=True)
    return done.stderr.split()


@pytest.mark.parametrize("arguments", ["--help", "compare --help"])
def test_help_loads_nothing_heavy(arguments):
    code = f"from adaptive_ff.cli.main import app\napp({arguments.split()}, standalone_mode=False)"
    assert loaded_after(code) == []


def test_import_loads_nothing_heavy_and_knows_its_version():
    assert loaded_after("import adaptive_ff; adaptive_ff.__version__") == []
    assert adaptive_ff.__version__ == version("adaptive-ff")


@pytest.mark.parametrize(
    ("group", "function"),
    [(identify.Regression, identify_log), (identify.Learning, replay_log), (options.Limits, MotionLimits)],
)
def test_options_are_arguments_of_the_function_that_they_fill_with_its_defaults(group, function):
    arguments = inspect.signature(function).parameters
    for one in fields(group):
        default = arguments[one.name].default
        assert one.default == (None if default is inspect.Parameter.empty else default)


def test_names_in_help_are_those_that_there_are():
    assert list(compare.METRIC_NAMES) == list(GATED)
    assert [name for name in CONTROLLERS if name not in FIXED] == list(compare.CONTROLLER_NAMES)
    assert (tuple(FORMS), tuple(SOURCES)) == (compare.FORM_NAMES, compare.SOURCE_NAMES)
