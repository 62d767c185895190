"""Whatever a scenario file or a recording holds, the command line answers with a result or with one line."""

import math
import tempfile
from pathlib import Path
from unittest.mock import patch

import pytest
from command_line import content_of, run_command_line
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scenario_files import REMOVED, changed, short, to_toml

from adaptive_ff import Comparison
from adaptive_ff.comparison.registry import CONTROLLERS
from adaptive_ff.scenario.relations import LONGEST

AFFORDABLE = 100_000
"""Solver steps of a run that a test can wait for."""


def paths_in(content, path=()):
    pairs = content.items() if isinstance(content, dict) else enumerate(content)
    for key, value in pairs:
        yield ".".join((*path, str(key)))
        if isinstance(value, (dict, list)):
            yield from paths_in(value, (*path, str(key)))


def value_at(content, path):
    for part in path.split("."):
        content = content[int(part) if part.isdecimal() else part]
    return content


SHORT = to_toml(short()).encode("utf-8")
COMPLETE = changed(short(), "change", [{"time": 0.2, "friction_scale": 0.6}])
COMPLETE["fixed"] |= {"stiction": 90.0, "friction_lag": 0.02, "stribeck_velocity": 0.05}
PATHS = list(paths_in(COMPLETE))
TABLES = ["joint", "sampling", "sensor", "actuator", "reference", "feedback", "adaptation", "fixed", "change.0"]
OTHERS = (*TABLES, "change", "controllers", "controllers.0", "reference.kind", "reference.frequencies")
NUMBERS = [path for path in PATHS if path not in (*OTHERS, "reference.amplitudes", "seed")]
REQUIRED = [f"joint.{name}" for name in ("inertia", "coulomb", "stiction", "viscous", "stribeck_velocity")]
REQUIRED += ["joint", "feedback", "feedback.inertia", "adaptation", "change.0.time"]

JUNK = st.recursive(
    st.booleans() | st.text(max_size=5) | st.integers() | st.floats(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=5,
)
NO_NUMBER = (
    st.booleans()
    | st.text(max_size=5)
    | st.sampled_from([math.nan, math.inf, -math.inf, 10**400, -(10**400)])
    | st.lists(JUNK, max_size=3)
    | st.dictionaries(st.text(max_size=5), JUNK, max_size=3)
)
SIZES = st.floats(-12.0, 12.0).map(lambda exponent: 10.0**exponent) | st.floats(min_value=0.0) | st.integers(0, 10**20)


@st.composite
def broken(draw):
    """Text of a scenario that cannot be accepted."""
    kind = draw(st.sampled_from(["number", "negative", "removed", "unknown", "controllers", "junk"]))
    if kind == "number":
        return to_toml(changed(COMPLETE, draw(st.sampled_from(NUMBERS)), draw(NO_NUMBER)))
    if kind == "negative":
        paths = [path for path in NUMBERS if not path.startswith("reference.amplitudes")]
        return to_toml(changed(COMPLETE, draw(st.sampled_from(paths)), draw(st.floats(max_value=-5e-324))))
    if kind == "removed":
        return to_toml(changed(COMPLETE, draw(st.sampled_from(REQUIRED)), REMOVED))
    if kind == "unknown":
        table = draw(st.sampled_from(TABLES))
        name = draw(st.text(st.characters(exclude_characters=".", exclude_categories=["Cs", "Nd"]), min_size=1))
        assume(f"{table}.{name}" not in PATHS and name not in ("proportional", "integral", "stribeck_shape"))
        return to_toml(changed(COMPLETE, f"{table}.{name}", draw(JUNK)))
    if kind == "controllers":
        names = draw(st.lists(st.text(max_size=10) | st.sampled_from(["pi", "oracle", "adaptive"]), max_size=3))
        assume(not names or not set(names) <= set(CONTROLLERS))  # which hypothesis can find among the constants
        return to_toml({**COMPLETE, "controllers": names})
    return draw(st.text() | st.text("[]{}=\"'.,#\n ax1", max_size=50))


@st.composite
def disturbed(draw):
    """Content of a scenario with some values of another size, which it may or may not stand."""
    other = draw(st.sampled_from(["fixed", "oracle", "adaptive_paper", "adaptive"]))
    content = {**COMPLETE, "controllers": ["pi", other]}
    for path in draw(st.lists(st.sampled_from(PATHS), min_size=1, max_size=3, unique=True)):
        if path in NUMBERS and draw(st.booleans()):
            value = 10.0 ** draw(st.floats(-2.0, 2.0)) * value_at(COMPLETE, path)
        else:
            value = draw(SIZES | JUNK if path in NUMBERS else JUNK)
        try:
            content = changed(content, path, value)
        except (TypeError, IndexError, ValueError):  # there is no such place any more
            continue
    try:
        steps = content["duration"] / content["joint"]["solver_period"]
    except (TypeError, KeyError, ZeroDivisionError, OverflowError):
        return content
    assume(not AFFORDABLE < steps <= LONGEST)
    return content


@pytest.fixture(scope="module", autouse=True)
def without_any_pictures(compiled):
    with patch.object(Comparison, "plot", lambda comparison, folder: {}):
        yield


def compare_in_a_folder(scenario, motion=None):
    """Compare in a new folder, along a motion where one is given; check what goes for every outcome."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "scenario.toml").write_bytes(scenario)
        given = []
        if motion is not None:
            (folder / "motion.csv").write_text(motion, encoding="utf-8", newline="")
            given = ["--reference", folder / "motion.csv"]
        before = content_of(folder)
        outcome = run_command_line("compare", folder / "scenario.toml", "--out", folder / "new" / "out", *given)
        assert outcome.status in (0, 2), outcome
        if outcome.status == 2:
            assert content_of(folder) == before
            assert outcome.out == ""
            assert len(outcome.messages) == 1, outcome.err
            assert outcome.messages[0].startswith(f"adaptive-ff: {folder}")
        else:
            assert outcome.messages == []
            assert {"pi.csv", "result.json"} <= set(content_of(folder / "new" / "out"))
        assert not list(folder.rglob(".unfinished-*"))
    return outcome


@settings(max_examples=15)
@given(broken())
def test_broken_scenario_is_answered_with_one_line(text):
    assert compare_in_a_folder(text.encode("utf-8")).status == 2


@settings(max_examples=12)
@given(st.binary())
def test_bytes_are_answered_with_one_line(content):
    assert compare_in_a_folder(content).status == 2


@settings(max_examples=30)
@given(disturbed())
def test_disturbed_scenario_runs_or_is_answered_with_one_line(content):
    compare_in_a_folder(to_toml(content).encode("utf-8"))


VALUES = st.integers(-9, 9).map(float) | st.floats(0.0, 10.0) | st.floats(-1e300, 1e300)
CELLS = st.floats().map(repr) | st.sampled_from(["", " ", "x", "1e3", "0", '"', "1,5"]) | st.text(max_size=3)


@settings(max_examples=20)
@given(
    st.sampled_from(["time,velocity", "time,position", "position,time,velocity", "time", "a,b"]),
    st.lists(st.lists(CELLS, min_size=1, max_size=3), max_size=8),
    st.sampled_from(["\n", "\r\n", "\n\n"]),
)
def test_recording_of_anything_is_used_or_answered_with_one_line(header, rows, newline):
    compare_in_a_folder(SHORT, newline.join([header, *(",".join(row) for row in rows)]))


@settings(max_examples=25)
@given(
    st.sampled_from(["velocity", "position"]),
    st.lists(VALUES, min_size=4, max_size=8, unique=True).map(sorted),
    st.data(),
)
def test_recording_of_numbers_is_used_or_answered_with_one_line(column, times, data):
    values = data.draw(st.lists(VALUES, min_size=len(times), max_size=len(times)))
    lines = [f"time,{column}", *(f"{time!r},{value!r}" for time, value in zip(times, values, strict=True))]
    compare_in_a_folder(SHORT, "\n".join(lines))
