"""Public functions name the argument that is of another kind, its value and what is allowed; nothing runs then."""

import math

import numpy as np
import pytest

import adaptive_ff
from adaptive_ff import (
    AdaptiveController,
    JointGroup,
    Log,
    assert_no_regression,
    compare,
    export_controller,
    fit_stribeck,
    identify_log,
    identify_series,
    identify_torque_form,
    load_scenario,
    parse_scenario,
    read_baseline,
    read_log,
    regressions,
    simulate,
    support_points,
)
from adaptive_ff.comparison.comparison import Comparison
from controllers import PI
from plant import FrictionChange, schedule

SHORT = load_scenario().modified(duration=10.0, controllers=["pi"])
TIME = 0.01 * np.arange(400)
WAVE = np.sin(6.0 * TIME)
SPEEDS = np.geomspace(0.005, 0.3, 12)
STRIBECK = {"stribeck_velocity": 0.05, "stribeck_shape": 1.0}
LOG = Log("log", TIME, WAVE, velocity=WAVE)
RESULT = Comparison(SHORT, {})
EARLIER = {"scenario": {}, "controllers": {"pi": {"rms_error": 1.0}}}
GAINS = {"proportional": 1256.0, "integral": 20000.0, "period": 0.01, "inertia": 20.0, "stribeck_velocity": 0.05}
MODEL = {"inertia": 20.0, "coulomb": 60.0, "stiction": 90.0, "friction_lag": 0.02}
SURE = {"inertia": 2.0, "coulomb": 6.0}


def adaptive(**given):
    return AdaptiveController(**{**GAINS, **given})


def with_model(**model):
    return adaptive(model={**MODEL, **model})


def with_deviation(**deviation):
    return adaptive(model=MODEL, deviation=deviation)


def stepped(**given):
    return adaptive(regressors=2).step(0.1, 0.0, **given)


CALLS = {
    "AdaptiveController": adaptive,
    "model": with_model,
    "deviation": with_deviation,
    "step": stepped,
    "JointGroup": JointGroup,
    "JointGroup.from_table": JointGroup.from_table,
    "JointGroup.from_toml": JointGroup.from_toml,
    "diagnose": adaptive().diagnose,
    "Log": Log,
    "Comparison.write": RESULT.write,
    "assert_no_regression": assert_no_regression,
    "regressions": regressions,
    "compare": compare,
    "simulate": simulate,
    "export_controller": export_controller,
    "fit_stribeck": fit_stribeck,
    "support_points": support_points,
    "identify_series": identify_series,
    "identify_torque_form": identify_torque_form,
    "identify_log": identify_log,
    "load_scenario": load_scenario,
    "parse_scenario": parse_scenario,
    "read_baseline": read_baseline,
    "read_log": read_log,
    "schedule": schedule,
}
GIVEN = {
    "JointGroup": {"joints": {"elbow": adaptive()}},
    "Log": {"name": "log", "time": TIME, "torque": WAVE, "velocity": WAVE},
    "assert_no_regression": {"comparison": RESULT, "baseline": "earlier.json"},
    "regressions": {"comparison": RESULT, "baseline": EARLIER},
    "compare": {"scenario": SHORT},
    "simulate": {"scenario": SHORT, "controller": "pi"},
    "export_controller": {"controller": PI(100.0, 10.0, 0.01), "out": "drive"},
    "fit_stribeck": {"velocity": SPEEDS, "torque": 60.0 + 30.0 * np.exp(-SPEEDS / 0.05) + 80.0 * SPEEDS},
    "support_points": {"velocity": [[0.1, 0.11], [0.2, 0.21]], "torque": [[1.0, 2.0], [2.0, 3.0]]},
    "identify_series": {"velocity": WAVE, "torque": WAVE, "period": 0.01, **STRIBECK},
    "identify_torque_form": {
        **{"time": TIME, "velocity": WAVE, "torque": WAVE},
        **{"filter_pole": 30.0, "slowest": 0.01, "hold": 0.1},
        **STRIBECK,
    },
    "identify_log": {"log": LOG},
    "parse_scenario": {"content": SHORT.model_dump(exclude_unset=True), "name": "mine"},
    "read_log": {"path": "log.csv", "torque": "u", "position": "q", "time": "t"},
    "schedule": {"changes": [FrictionChange(time=1.0, friction_scale=0.5)], "solver_period": 0.001},
}
NUMBERS = [
    *[("AdaptiveController", name) for name in ("map_memory", "observer_bandwidth", "deviation", "memory")],
    *[("model", name) for name in (*MODEL, "stribeck_velocity")],
    *[("deviation", name) for name in SURE],
    *[("identify_series", name) for name in ("period", "stribeck_velocity", "stribeck_shape", "confidence")],
    *[("identify_torque_form", name) for name in ("filter_pole", "slowest", "hold", "stribeck_shape", "confidence")],
    *[("identify_log", name) for name in ("bandwidth", "held_out", "torque_delay", "confidence")],
    ("fit_stribeck", "confidence"),
    ("schedule", "solver_period"),
]
ARRAYS = [
    *[("AdaptiveController", name) for name in ("stribeck_factors", "presliding_factors")],
    *[("AdaptiveController", f"{name}_periods") for name in ("ripple", "position")],
    *[("fit_stribeck", name) for name in ("velocity", "torque", "standard_error")],
    *[("support_points", name) for name in ("velocity", "torque")],
    *[("identify_series", name) for name in ("velocity", "torque")],
    *[("identify_torque_form", name) for name in ("time", "velocity", "torque")],
    ("step", "regressors"),
]
PATHS = [
    ("JointGroup.from_toml", "path"),
    ("Comparison.write", "path"),
    ("assert_no_regression", "baseline"),
    ("export_controller", "out"),
    ("load_scenario", "reference"),
    ("parse_scenario", "folder"),
    ("read_baseline", "path"),
    ("read_log", "path"),
]
SWITCHES = [
    *[("identify_log", name) for name in ("linear", "is_current", "load_friction")],
    *[("export_controller", name) for name in ("single", "with_fmu")],
    ("simulate", "uncertain"),
]
KINDS = [
    ("AdaptiveController", "model", "mine", "it must be a TorqueModel, or values by name"),
    ("AdaptiveController", "model", [1.0, 2.0], "it must be a TorqueModel, or values by name"),
    ("JointGroup", "preceding", ["shoulder"], "it must be names of the joints before each, by joint"),
    ("JointGroup.from_table", "table", "arm.toml", "it must be a table with period and joints"),
    ("diagnose", "run", "run.csv", "it must have the series torque and feedforward"),
    ("Log", "extra", [WAVE], "it must be series by name"),
    ("assert_no_regression", "comparison", None, r"it must be a Comparison: compare\(scenario\) makes one"),
    ("regressions", "comparison", SHORT, r"it must be a Comparison: compare\(scenario\) makes one"),
    ("regressions", "baseline", "earlier.json", r"it must be what read_baseline\(path\) returns"),
    ("compare", "progress", "loud", "it must be a function"),
    ("simulate", "progress", 1, "it must be a function"),
    ("simulate", "course", SHORT, r"it must be what lay_course\(scenario\) returns"),
    ("simulate", "name", 1, "it must be a text"),
    ("export_controller", "prefix", 1, "it must be a text"),
    ("identify_log", "position_periods", 0.5, "it must be a sequence of periods"),
    ("parse_scenario", "content", "joint.toml", "it must be tables and fields by name"),
    ("read_log", "torque", None, "it must be the name of a column"),
    ("read_log", "time", 3, "it must be the name of a column"),
    ("read_log", "extra", ["w"], "it must be by name"),
    ("read_log", "scale", 2.0, "it must be by name"),
    ("schedule", "changes", [1.0], "it must be a sequence of FrictionChange"),
    ("schedule", "variation", 1.0, "it must be a FrictionVariation"),
]


def refused(call, name, wrong, kind=TypeError):
    with pytest.raises(kind, match=rf"^({call}\.)?{name} = .* is not allowed: it must be ") as error:
        CALLS[call](**{**GIVEN.get(call, {}), name: wrong})
    return str(error.value).removeprefix(f"{call}.")


@pytest.mark.parametrize(("call", "name"), NUMBERS)
@pytest.mark.parametrize("wrong", ["abc", "5", [1.0, 2.0], 1j], ids=repr)
def test_what_is_no_number_is_refused_by_name(call, name, wrong):
    assert refused(call, name, wrong) == f"{name} = {wrong!r} is not allowed: it must be a number"


@pytest.mark.parametrize(("call", "name"), ARRAYS)
@pytest.mark.parametrize(
    "wrong",
    ["abc", "5", ["1", "2"], {"a": 1.0}, [1j], [[1.0], [2.0, 3.0]]],
    ids=repr,
)
def test_what_is_no_series_of_numbers_is_refused_by_name(call, name, wrong):
    assert refused(call, name, wrong) == f"{name} = {wrong!r} is not allowed: it must be numbers"


@pytest.mark.parametrize(("call", "name"), ARRAYS)
@pytest.mark.parametrize("one", ["1", b"1", None], ids=repr)
def test_boxed_texts_are_no_numbers(call, name, one):
    assert "is not allowed: it must be numbers" in refused(call, name, np.array([one, 2.0], dtype=object))


@pytest.mark.parametrize(("call", "name"), PATHS)
@pytest.mark.parametrize("wrong", [1, [], b"mine"], ids=repr)
def test_what_is_no_path_is_refused_by_name(call, name, wrong):
    assert refused(call, name, wrong) == f"{name} = {wrong!r} is not allowed: it must be a path"


@pytest.mark.parametrize(("call", "name"), SWITCHES)
@pytest.mark.parametrize("wrong", ["off", 2, math.nan, None, [True]], ids=repr)
def test_what_is_neither_true_nor_false_is_refused_by_name(call, name, wrong):
    assert refused(call, name, wrong, ValueError).endswith(" is not allowed: it must be True or False")


@pytest.mark.parametrize(("call", "name", "wrong", "rule"), KINDS)
def test_another_kind_is_refused_with_what_is_allowed(call, name, wrong, rule):
    with pytest.raises(TypeError, match=rf"^{name} = .* is not allowed: {rule}"):
        CALLS[call](**{**GIVEN.get(call, {}), name: wrong})


@pytest.mark.parametrize("thin", [0, 2.5, "2", math.nan, True], ids=repr)
@pytest.mark.parametrize("call", ["compare", "simulate"])
def test_thinning_by_no_whole_number_is_refused(call, thin):
    with pytest.raises(ValueError, match=r"^thin = .* is not allowed: it must be a whole number of at least 1$"):
        CALLS[call](**GIVEN[call], thin=thin)


@pytest.mark.parametrize("names", [[1.0], np.ones((2, 2)), "pi"], ids=["numbers", "array", "text"])
def test_guarded_controllers_that_are_no_names_are_refused(names):
    same = {**EARLIER, "scenario": SHORT.model_dump(mode="json", exclude_none=True)}
    with pytest.raises(
        adaptive_ff.InputError, match=r"^controllers = [\s\S]* is not allowed: it must be a list of names"
    ):
        regressions(RESULT, same, controllers=names)


def test_baseline_without_its_parts_is_refused():
    with pytest.raises(adaptive_ff.InputError, match=r"^baseline is not allowed: it lacks scenario or controllers"):
        regressions(RESULT, {"pi": {}})


@pytest.mark.parametrize("names", [np.ones((3, 2)), np.array(1.0), None, 5, [5]], ids=repr)
def test_parameters_that_are_no_names_are_refused(names):
    with pytest.raises(ValueError, match=r"^parameters = [\s\S]* is not allowed: it must be \('inertia', "):
        adaptive(parameters=names)


@pytest.mark.parametrize("family", [None, ["offset"], np.ones((2, 2))], ids=["None", "list", "array"])
def test_family_that_is_no_text_is_refused(family):
    log = Log("log", 0.01 * np.arange(3000), np.cos(0.02 * np.arange(3000)), velocity=np.sin(0.02 * np.arange(3000)))
    with pytest.raises(adaptive_ff.InputError, match=r"^model = [\s\S]* is not allowed: it must be auto or one of "):
        identify_log(log, model=family)


@pytest.mark.parametrize("role", ["time", "torque"])
def test_log_without_times_or_torques_is_refused(role):
    with pytest.raises(ValueError, match=rf"^log: {role} must be a one-dimensional array of numbers"):
        Log(**{**GIVEN["Log"], role: None})


def test_numbers_of_any_kind_are_taken():
    fit = fit_stribeck(**GIVEN["fit_stribeck"])
    plain = fit_stribeck(*(values.astype(object).tolist() for values in GIVEN["fit_stribeck"].values()))
    boxed = fit_stribeck(*(values.astype(object) for values in GIVEN["fit_stribeck"].values()))
    assert fit.estimates == plain.estimates == boxed.estimates


@pytest.mark.parametrize("wrong", ["5", "abc", ["1"], 10**400], ids=["digits", "text", "texts", "huge"])
@pytest.mark.parametrize("name", ["reference", "velocity", "position", "inertia", "dt"])
def test_group_takes_no_texts_for_numbers(name, wrong):
    group = JointGroup({"elbow": adaptive()})
    before = group.state_to_json()
    with pytest.raises(ValueError, match=rf"^{name} = .* is not allowed: it must be 1 numbers"):
        group.step(**{"reference": [0.1], "velocity": [0.0], name: wrong})
    assert group.state_to_json() == before


@pytest.mark.parametrize("wrong", ["5", "abc", 10**400], ids=["digits", "text", "huge"])
def test_first_map_takes_no_texts_for_numbers(wrong):
    first = {"model": MODEL, "position_periods": [1.0], "position_map": [0.1, 0.1]}
    with pytest.raises(ValueError, match=r"^map_deviation = .* is not allowed: it must be 2 numbers"):
        adaptive(**first, map_deviation=wrong)
