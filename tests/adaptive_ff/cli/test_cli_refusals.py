"""Bad input on the command line: status 2, one line, and nothing is written, half or whole."""

import errno
import sys
from unittest.mock import patch

import numpy as np
import pytest
from command_line import content_of, refusal, run_command_line
from scenario_files import short, write_scenario
from synthetic_logs import make_log

import controllers
from adaptive_ff import Comparison, files
from adaptive_ff.cli.output import Printer
from adaptive_ff.comparison.registry import CONTROLLERS

pytestmark = pytest.mark.usefixtures("compiled")


@pytest.fixture
def refused(tmp_path, monkeypatch):
    """Refusal of a call in a folder where something lies already; the folder is as it was."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "pi.csv").write_text("of a former run", encoding="utf-8")

    def call(*arguments):
        before = content_of(tmp_path)
        line = refusal(*arguments)
        assert content_of(tmp_path) == before
        return line.removeprefix("adaptive-ff: ")

    return call


@pytest.mark.parametrize("out", ["out", "new/out"])
@pytest.mark.parametrize("known", [True, False])
def test_unknown_controller(tmp_path, refused, out, known):
    path = write_scenario(tmp_path, {**short(), "controllers": ["pi", "pid"]})
    with patch.object(controllers, "is_cached", lambda _: known):  # where nothing is compiled, it still says one thing
        line = refused("compare", path, "--out", out, "--json", "new/copy.json")
    assert line == f"{path}: controllers = 'pid' is not known; there are {', '.join(CONTROLLERS)}"


@pytest.mark.parametrize(
    ("arguments", "complaint", "help_of"),
    [
        (["compare", "--nope"], "No such option: --nope", "compare"),
        (["compare", "scenario.toml", "more.toml"], "Got unexpected extra argument", "compare"),
        (["compare", "--out"], "requires an argument", None),
        (["compere"], "No such command 'compere'", ""),
        (["--nope"], "No such option: --nope", ""),
    ],
)
def test_usage(refused, arguments, complaint, help_of):
    line = refused(*arguments)
    assert complaint in line
    if help_of is not None:
        assert line.endswith(f"{help_of} --help shows what is allowed")


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["sweep", "--runs", "0"], "--runs = 0 is not allowed: it must be greater than or equal to 1"),
        (["sweep", "--runs", "1e3"], "--runs = 1e3 is not allowed: it must be a valid integer"),
        (["tune", "--seeds", "101"], "--seeds = 101 is not allowed: it must be less than or equal to 100"),
        (["new", "--inertia", "abc"], "--inertia = 'abc' is not allowed: it must be a finite number"),
        (
            ["new", "--delay", "5"],
            "no loop suits this period, delay and velocity filter: delay = 5000 is not allowed: it must be a whole "
            "number of periods, from zero to 1000",
        ),
        (["compare", "--tables", "html"], "--tables: 'html' is not one of 'text', 'markdown', 'csv'"),
    ],
)
def test_value_of_an_option_is_named_with_what_is_allowed(refused, arguments, line):
    found = refused(*arguments)
    if "Invalid value for" in found:  # typer that leaves values to click, whose message names them as well
        assert arguments[-2] in found
        assert arguments[-1] in found
    else:
        assert found == line


FILES = [
    (["compare", "latin", "--out", "new"], "latin: is not valid TOML: byte 0xfc in line 2 is no text in UTF-8"),
    (["compare", "gone.toml", "--out", "out"], "gone.toml: cannot be read: No such file or directory"),
    (["compare", "papr_100hz"], "papr_100hz: there is no such file or scenario; did you mean paper_100hz?"),
    (["identify", "latin"], "latin: cannot be read: it is no text in UTF-8; save it as such"),
    (["identify", "gone.mat"], "gone.mat: cannot be read: No such file or directory"),
]


@pytest.mark.parametrize(("arguments", "line"), FILES)
def test_file_that_is_missing_or_no_text(tmp_path, refused, arguments, line):
    name = "latin.toml" if arguments[0] == "compare" else "latin.csv"
    (tmp_path / name).write_bytes("Zeit,Winkel\n# Prüfstand\n".encode("latin-1"))
    given = [name if word == "latin" else word for word in arguments]
    assert refused(*given) == line.replace("latin", name, 1)


COLUMNS = ("--position", "q", "--torque", "u")


def write_log(path, names=("time", "q", "u"), **changed):
    log = make_log(duration=20.0, period=0.01, noise=0.05)
    series = {"time": log.time, "q": log.position, "u": log.torque}
    for name, change in changed.items():
        series[name] = change(series[name])
    files.write_csv(path, dict(zip(names, series.values(), strict=True)))
    return path


def test_option_of_identify_is_named_and_not_the_log(tmp_path, refused):
    write_log(tmp_path / "log.csv")
    asked = ("identify", "log.csv", *COLUMNS)
    line = refused(*asked, "--torque-constant", "0")
    assert line == "--torque-constant = 0 is not allowed: it must be finite and not zero"
    assert refused(*asked, "--model", "foo").startswith("model = 'foo' is not allowed: it must be one of auto")


@pytest.mark.parametrize("value", [np.inf, -np.inf, 1e306])
def test_a_replay_of_a_time_that_cannot_be_says_so_in_a_line(tmp_path, without_pictures, value):
    log = write_log(tmp_path / "log.csv", time=lambda t: np.where(np.arange(t.size) == 700, value, t))
    outcome = run_command_line("replay", log, *COLUMNS, "--out", tmp_path / "out")
    assert outcome.status in (0, 2)
    assert "Traceback" not in outcome.err
    assert outcome.status == 0 or len(outcome.messages) == 1, outcome.err


def test_a_log_of_denormal_numbers_is_refused_for_what_it_is(tmp_path):
    path = write_log(tmp_path / "log.csv", time=lambda t: 5e-324 * np.arange(t.size), q=lambda q: 1e-320 * q)
    line = refusal("identify", path, *COLUMNS, "--out", tmp_path / "out")
    assert "cannot convert" not in line
    assert "time" in line


@pytest.mark.parametrize("command", ["identify", "replay"])
def test_names_of_columns_do_not_reach_the_terminal_as_commands(tmp_path, without_pictures, command):
    evil = "u\x1b]0;owned\x07"
    path = write_log(tmp_path / "log.csv", names=("time", "q\x1b[2J", evil))
    outcome = run_command_line(command, path, "--position", "q\x1b[2J", "--torque", evil, "--out", tmp_path / "out")
    asked = run_command_line(command, path, "--torque", "nothing", "--out", tmp_path / "out")
    assert asked.status == 2
    for text in (outcome.out, outcome.err, asked.out, asked.err):
        assert "\x1b]" not in text
        assert "\x07" not in text
        assert "[2J" not in text.replace("\\x1b[2J", "")


@pytest.mark.parametrize(("returned", "shown"), [("'x'", "'x'"), ("float('nan')", "nan"), ("None", "None")])
def test_own_controller_that_returns_no_torque(tmp_path, monkeypatch, scenario, refused, returned, shown):
    monkeypatch.setattr(sys, "dont_write_bytecode", True)  # Python's own file beside the module is none of the command
    lines = ["class Mine:", "    def step(self, reference, velocity, **_):", f"        return {returned}", ""]
    (tmp_path / f"mine_{len(returned)}.py").write_text("\n".join(lines), encoding="utf-8")
    line = refused("compare", scenario, "--own", f"mine_{len(returned)}.py:Mine", "--out", "new")
    assert line == f"the own controller Mine returned a torque of {shown}; it must be a finite number"


FAR = [
    ({"feedback": {"inertia": 1e-300, "proportional": 1e300, "integral": 0.0}, "controllers": ["adaptive"]}, ""),
    ({"actuator": {}, "change": [{"time": 0.2, "load": 1e300}]}, "the simulation fails: the run"),
]


@pytest.mark.parametrize(("content", "said"), FAR, ids=["gains", "load"])
def test_what_the_controller_cannot_work_with_or_does_not_stay_finite(tmp_path, refused, content, said):
    write_scenario(tmp_path, {**short(), **content})
    assert refused("compare", "scenario.toml", "--out", "new").startswith(f"scenario.toml: {said}")


@pytest.mark.parametrize("reference", ["gone.csv", ".", "scenario.toml", "out/pi.csv"])
def test_recorded_reference(scenario, refused, reference):
    line = refused("compare", scenario, "--reference", reference, "--out", "new")
    assert line.startswith(f"{scenario}: {reference}: ")


@pytest.mark.parametrize(
    ("option", "place", "said"),
    [
        *(("--out", out, "") for out in ("scenario.toml", "scenario.toml/out", "x" * 300, f"new/{'x' * 300}")),
        ("--out", "out/pi.csv", "Not a directory"),
        *(("--json", json, "") for json in ("out", "new", ".", "scenario.toml/copy.json")),
        ("--json", "out/pi.csv/copy.json", "Not a directory"),
    ],
)
def test_place_that_cannot_be_written(scenario, refused, option, place, said):
    line = refused("compare", scenario, "--out", "new", option, place)
    assert line.startswith(f"{place}: cannot be written: {said}")
    assert line.endswith(said)


@pytest.mark.parametrize("name", ["result.json", "pi.csv"])
@pytest.mark.parametrize("json", [[], ["--json", "copy.json"]])
def test_folder_in_the_place_of_a_file(tmp_path, scenario, refused, without_pictures, name, json):
    (tmp_path / "taken" / name).mkdir(parents=True)
    (tmp_path / "copy.json").write_text("of a former run", encoding="utf-8")
    line = refused("compare", scenario, "--out", "taken", *json)
    assert line == f"taken/{name}: cannot be written: it is a folder"


def fail(*_, **__):
    raise OSError(errno.ENOSPC, "No space left on device")


def fail_halfway(path, *_):
    path.write_text("time,refer", encoding="utf-8")
    fail()


FULL = [(files, "write_csv", fail), (files, "write_csv", fail_halfway), (files, "write_json", fail_halfway)]


@pytest.mark.parametrize(("owner", "name", "failure"), [*FULL, (Comparison, "plot", fail)])
@pytest.mark.parametrize("out", ["out", "new/out"])
def test_disk_that_is_full(scenario, refused, owner, name, failure, out):
    with patch.object(owner, name, failure):
        line = refused("compare", scenario, "--out", out, "--json", "new/copy.json")
    assert line == f"{out}: cannot be written: No space left on device"


def test_disk_that_is_full_when_the_copy_is_written(tmp_path, scenario, refused, without_pictures):
    write = files.write_json

    def write_first(path, content):
        if path.name == "copy.json":
            fail()
        write(path, content)

    with patch.object(files, "write_json", write_first):
        assert "No space left" in refused("compare", scenario, "--out", "out", "--json", "new/copy.json")


def test_terminal_that_takes_no_more(tmp_path, scenario, without_pictures):
    with patch.object(Printer, "show", fail):
        line = refusal("compare", scenario, "--out", tmp_path / "out")
    assert line == "adaptive-ff: [Errno 28] No space left on device"


def test_interrupt_while_writing_leaves_nothing(tmp_path, scenario):
    def interrupt(path, *_):
        path.write_text("time,refer", encoding="utf-8")
        raise KeyboardInterrupt

    before = content_of(tmp_path)
    with patch.object(files, "write_csv", interrupt):
        outcome = run_command_line("compare", scenario, "--out", tmp_path / "out", "--json", tmp_path / "copy.json")
    assert outcome.status == 130
    assert content_of(tmp_path) == before


def test_first_run_says_that_it_compiles(tmp_path, scenario, without_pictures):
    with patch.object(controllers, "is_cached", lambda _: False):
        outcome = run_command_line("compare", scenario, "--out", tmp_path / "out")
    assert outcome.status == 0
    assert len(outcome.messages) == 1
    assert "compiled, once" in outcome.messages[0]
