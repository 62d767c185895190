import json
import math
import pickle
import sys
from io import StringIO

import numpy as np
import pytest
from rich.console import Console
from typer.testing import CliRunner

from adaptive_ff import load_scenario
from benchmarks import speed, speed_group, speed_steps
from benchmarks import speed_rivals as closed_loop
from benchmarks.speed import Sizes
from benchmarks.speed_rivals import CLoop, ExportedLoop, OwnLoop, PythonControlLoop, check_alike, shared_series
from benchmarks.speed_rows import Row, in_turn, shown
from plant import sliding

TINY = Sizes(duration=1.0, repeats=2, slow_repeats=1, lengths=(1, 2), calls=20, commands=1)
STUB = (sys.executable, "-c", "import pathlib, sys; pathlib.Path(sys.argv[1]).mkdir()", "{out}")

VARIANTS = {
    "friction that changes": {"change": [{"time": 6.0, "friction_scale": 0.6}]},
    "fast": {"duration": 5.0, "sampling": {"period": 0.001}},
    "shape 2": {"joint": {"stribeck_shape": 2.0}, "adaptation": {"stribeck_shape": 2.0}},
    "shape 0.7": {"joint": {"stribeck_shape": 0.7}, "adaptation": {"stribeck_shape": 0.7}},
    "no lag, weak drive": {"joint": {"friction_lag": 0.0}, "actuator": {"torque_limit": 95.0}},
}


def short(**tables):
    return load_scenario().modified(**{"duration": 12.0, **tables})


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    if closed_loop.compiler() is None:
        pytest.skip("there is no C compiler: none of cc, gcc, clang is found")
    return closed_loop.compile_loop(tmp_path_factory.mktemp("library"))


@pytest.mark.parametrize("name", ["pi", "fixed"])
@pytest.mark.parametrize("variant", VARIANTS)
def test_c_loop_agrees_with_ours(library, name, variant):
    own = OwnLoop(short(**VARIANTS[variant]), name)
    rival = CLoop(library, own)
    own.run()
    rival.run()
    check_alike(own.record, rival.record, "C")
    assert np.ptp(rival.record.velocity) > 0.1
    assert (np.ptp(rival.record.feedforward) > 50.0) == (name == "fixed")


@pytest.mark.parametrize("period", [0.01, 0.001])
def test_c_loop_with_the_exported_controller_agrees_with_ours(library, tmp_path, period):
    scenario = short(sampling={"period": period}, change=[{"time": 3.0, "friction_scale": 0.6}], duration=5.0)
    own = OwnLoop(scenario, "adaptive")
    rival = ExportedLoop(tmp_path, own)
    for _ in range(2):  # a second run begins anew
        own.run()
        rival.run()
        assert check_alike(shared_series(own), shared_series(rival), "C") < 1e-9
    assert np.ptp(rival.record.feedforward) > 50.0
    assert np.ptp(rival.record.estimates[:, 1]) > 10.0


@pytest.mark.parametrize("joint", [{"offset": 5.0}, {"viscous_backward": 90.0}])
def test_c_loop_refuses_a_joint_that_it_does_not_hold(library, joint):
    with pytest.raises(ValueError, match="same friction in both directions and no offset"):
        CLoop(library, OwnLoop(short(joint=joint), "pi"))


def test_second_run_repeats_the_first(library):
    own = OwnLoop(short(), "fixed")
    rival = CLoop(library, own)
    for loop in (own, rival):
        loop.run()
        first = [series.copy() for series in loop.record]
        loop.run()
        assert all(np.array_equal(a, b) for a, b in zip(first, loop.record, strict=True))


@pytest.mark.parametrize(
    ("tables", "what"),
    [
        ({"actuator": {"delay": 0.015}, "feedback": {"bandwidth": 3.0}}, "a computation delay"),
        ({"actuator": {"lag": 0.01}}, "a drive with lag"),
        ({"sensor": {"velocity_noise": 0.0, "encoder_resolution": 1e-5}}, "an encoder"),
        ({"position": {"gain": 5.0}}, "a position loop"),
    ],
)
def test_c_loop_refuses_a_course_that_it_does_not_hold(library, tables, what):
    with pytest.raises(ValueError, match=f"does not serve {what}"):
        CLoop(library, OwnLoop(short(**tables), "pi"))


@pytest.mark.parametrize("name", ["adaptive", "oracle"])
def test_c_loop_refuses_a_controller_that_it_does_not_hold(library, name):
    scenario = short(change=[{"time": 6.0, "friction_scale": 0.6}])
    with pytest.raises(ValueError, match="the C loop serves"):
        CLoop(library, OwnLoop(scenario, name))


def test_c_loop_takes_its_tolerance_from_python(library, monkeypatch, tmp_path):
    own = OwnLoop(short(), "fixed")
    own.run()
    rival = CLoop(library, own)
    rival.run()
    check_alike(own.record, rival.record, "C")
    monkeypatch.setattr(sliding, "UPDATES", 0)
    monkeypatch.setattr(sliding, "RELATIVE_TOLERANCE", 1e9 * sliding.RELATIVE_TOLERANCE)
    rival = CLoop(closed_loop.compile_loop(tmp_path), own)
    rival.run()
    with pytest.raises(ArithmeticError, match=r"C differs from our run by \S+, more than 1e-09"):
        check_alike(own.record, rival.record, "C")


@pytest.mark.parametrize("tables", [{}, {"sampling": {"period": 0.001}}, {"actuator": {"torque_limit": 95.0}}])
def test_python_control_agrees_with_ours(tables):
    scenario = short(**{"duration": 4.0, **tables})
    own = OwnLoop(scenario, "pi")
    rival = PythonControlLoop(own)
    own.run()
    rival.run()
    limit = own.course.actuator.torque_limit
    assert (np.max(np.abs(own.record.torque)) == limit) == (limit < 100.0)
    check_alike([own.record.velocity[: -1 : scenario.substeps]], [rival.velocity], "python-control")


def test_python_control_refuses_friction_that_changes():
    with pytest.raises(ValueError, match="does not change"):
        PythonControlLoop(OwnLoop(short(change=[{"time": 6.0, "friction_scale": 0.6}]), "pi"))


def test_difference_is_relative_to_the_largest_value_and_not_a_number_is_a_difference():
    ours = [np.array([0.0, 1e6]), np.zeros((0, 5))]
    assert check_alike(ours, [np.array([1e-6, 1e6]), np.zeros((0, 5))], "it") == pytest.approx(1e-12)
    with pytest.raises(ArithmeticError):
        check_alike(ours, [np.array([math.nan, 1e6]), np.zeros((0, 5))], "it")


def test_jobs_take_turns_and_ratios_are_to_the_last():
    called = []

    def job(name, times):
        values = iter(times)
        return lambda: called.append(name) or next(values)

    times, ratios = in_turn(3, job("a", [1.0, 2.0, 9.0]), job("b", [2.0, 1.0, 3.0]))
    assert called == list("ababab")
    assert times == [2.0, 2.0]
    assert ratios == [2.0, 1.0]


@pytest.mark.parametrize(
    ("row", "met"),
    [
        (Row("x", "y", 3.0, 2.0, 1.5, largest_ratio=1.5), True),
        (Row("x", "y", 3.1, 2.0, 1.55, largest_ratio=1.5), False),
        (Row("x", "y", 3.0, 2.0, 1.5, largest=2.9), False),
        (Row("x", "y", 3.0, 2.0, 1.5), None),
        (Row("x", "skipped: no reason", largest_ratio=1.5), None),
    ],
)
def test_verdict(row, met):
    assert row.met is met
    assert row.cells()[-1] == {True: "yes", False: "NO", None: ""}[met]


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (0.0107, "s", "10.7 ms"),
        (7e-6, "s", "7 us"),
        (40.0, "s", "40 s"),
        (1200.0, "s", "1.2e+03 s"),
        (3e-10, "s", "0.3 ns"),
        (1.92e6, "B", "1.92 MB"),
        (1.5, "", "1.50"),
        (0.01, "", "1/100"),
        (None, "s", ""),
    ],
)
def test_figures_are_shown_with_their_unit(value, unit, text):
    assert shown(value, unit) == text


def here(function, *arguments):
    """Call a function in this process, which spares the time of starting another; it can be sent to one."""
    return pickle.loads(pickle.dumps(function))(*arguments)


def test_report_holds_all_that_is_printed(monkeypatch):
    monkeypatch.setattr(speed_steps, "STEPPED", ("pi",))
    monkeypatch.setattr(speed_steps, "in_new_process", here)
    monkeypatch.setattr(speed, "COURSES", {"100 Hz, joint 1 kHz": {}})
    printed = StringIO()
    result = speed.report(Console(file=printed, width=120), TINY, STUB)
    assert set(result) == {"machine", "sizes", "measurements"}
    rows = [row for section in result["measurements"].values() for row in section]
    assert sum(row["rival"] == "simple-pid" for row in rows) == 2
    text = printed.getvalue()
    assert text.startswith("processor: ")
    assert all(row["what"] in text for row in rows)
    assert "targets are met" in text
    assert json.loads(json.dumps(result, allow_nan=False)) == json.loads(json.dumps(result))
    for row in rows:
        if row["ratio"] is not None and "joint" not in row["what"]:  # there it is the median of ratios
            assert row["ratio"] == pytest.approx(row["ours"] / row["theirs"])


def test_without_a_compiler_the_c_loop_is_skipped_with_the_reason(monkeypatch, tmp_path):
    monkeypatch.setattr(closed_loop.shutil, "which", lambda name: None)
    measure, *_ = speed.measurements(TINY, tmp_path, STUB).values()
    assert {row.rival for row in measure()} == {"skipped: there is no C compiler (cc, gcc, clang)"}
    assert speed.machine()["C compiler"] == "none"
    with pytest.raises(OSError, match="no C compiler"):
        closed_loop.compile_loop(tmp_path)


def test_failing_command_is_reported():
    with pytest.raises(RuntimeError, match="failed: it broke"):
        speed.command_line((sys.executable, "-c", "import sys; sys.exit('it broke')"))


def run_main(*arguments):
    app = speed.typer.Typer()
    app.command()(speed.main)
    return CliRunner().invoke(app, arguments)


def test_json_file_is_written(monkeypatch, tmp_path):
    monkeypatch.setattr(speed, "report", lambda console, sizes, only: {"machine": {}, "calls": sizes.calls})
    assert run_main("--json", str(tmp_path / "speed.json")).exit_code == 0
    assert json.loads((tmp_path / "speed.json").read_text()) == {"machine": {}, "calls": 50_000}
    assert [path.name for path in tmp_path.iterdir()] == ["speed.json"]


def test_rival_that_differs_ends_the_run_without_figures(monkeypatch, tmp_path):
    def report(console, sizes, only):
        raise ArithmeticError("C differs")

    monkeypatch.setattr(speed, "report", report)
    done = run_main("--json", str(tmp_path / "speed.json"))
    assert done.exit_code == 1
    assert "C differs" in done.output
    assert not list(tmp_path.iterdir())


def test_a_section_can_be_measured_alone():
    printed = StringIO()
    result = speed.report(Console(file=printed, width=120), TINY, STUB, only="JointGroup")
    ((title, rows),) = result["measurements"].items()
    assert title.startswith("JointGroup.step()")
    assert [row["what"] for row in rows[:-2]] == [f"group of {count} joints" for count in speed_group.JOINTS]
    assert all(row["ours"] > 0.0 and row["theirs"] > 0.0 for row in rows[:-2])
    assert "targets are met" not in printed.getvalue()
    with pytest.raises(ValueError, match=r"^--only nothing is not allowed: it must be part of one of Closed loop"):
        speed.report(Console(file=printed, width=120), TINY, STUB, only="nothing")


def test_a_straight_line_over_the_joints_is_found():
    numbers = (1, 2, 6, 12)
    start, slope = speed_group.fitted_rows(numbers, 3e-6 + 2e-6 * np.array(numbers), 4e-6)
    assert (start.ours, start.ratio) == pytest.approx((3e-6, 0.75))
    assert (slope.ours, slope.ratio) == pytest.approx((2e-6, 0.5))
    assert slope.what == "b, a joint more; fit within 0 %"
    squares = np.array(numbers) ** 2.0
    shares = np.column_stack([1.0 / squares, np.array(numbers) / squares])
    off = np.max(np.abs(shares @ np.linalg.lstsq(shares, np.ones(4))[0] - 1.0))
    assert speed_group.fitted_rows(numbers, 1e-6 * squares, 4e-6)[1].what.endswith(f"within {100.0 * off:.0f} %")
    assert off > 0.2


def test_group_that_is_timed_does_what_the_single_joints_do():
    samples = speed_group.samples_of(2)
    joints, alone = speed_group.joints_of(2), speed_group.joints_of(2)
    together, single = speed_group.step_together(joints, samples), speed_group.step_one_by_one(alone, samples)
    for k in range(50):
        together(k)
        single(k)
    for name, controller in joints.items():
        assert controller.state_to_json() == alone[name].state_to_json()
    assert joints["joint_0"].state_to_json() != joints["joint_1"].state_to_json()
