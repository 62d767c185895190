"""What people expect of any command: short help, version, quiet, results on standard output, other formats, sizes."""

import csv
import io
import json
import re
import time
from importlib.metadata import version

import pytest
from command_line import content_of, refusal, run_command_line, search_shortly
from scenario_files import REMOVED, changed, short, write_scenario
from synthetic_logs import write_log

from adaptive_ff.cli.output import Printer
from adaptive_ff.report.matrix_files import matrix_tables
from adaptive_ff.report.table import scale_for, shown, table
from adaptive_ff.report.tables import gains_table, ranking_table
from adaptive_ff.scenario.library import scenario_names
from adaptive_ff.studies.matrix import Job, collect

OWN = """class Mine:
    def step(self, reference, velocity, **_):
        return 2000.0 * (reference - velocity)
"""

COLOUR = re.compile(r"\x1b\[[0-9;]*3[0-7][;m]")
"""Any colour."""

pytestmark = pytest.mark.usefixtures("compiled")


@pytest.mark.parametrize("option", ["--version", "-V", "version"])
def test_version_as_an_option(option):
    assert run_command_line(option) == (0, f"{version('adaptive-ff')}\n", "")


@pytest.mark.parametrize("option", ["-h", "--help"])
def test_help_is_no_error(option):
    outcome = run_command_line(option)
    assert (outcome.status, outcome.err) == (0, "")
    assert "Usage: " in outcome.out
    assert "--install-completion" in outcome.out


def test_quiet_prints_nothing_and_writes_everything(tmp_path, scenario, without_pictures):
    outcome = run_command_line("compare", scenario, "--out", tmp_path / "out", "-q")
    assert outcome == (0, "", "")
    assert {"pi.csv", "result.json"} <= set(content_of(tmp_path / "out"))
    loud = run_command_line("compare", scenario, "--out", tmp_path / "out").out  # only one call asked for it
    assert "\nover pi: settled error of pi over" in loud.replace("; ", "\n")  # what the columns mean


def test_controllers_are_chosen_and_json_goes_to_standard_output_alone(tmp_path, scenario, without_pictures):
    chosen = ("--controller", "pi", "--controller", "oracle", "--json", "-")
    outcome = run_command_line("compare", scenario, *chosen, "--out", tmp_path / "out")
    assert (outcome.status, outcome.err) == (0, "")
    assert {"pi.csv", "oracle.csv", "result.json"} == set(content_of(tmp_path / "out"))
    assert json.loads(outcome.out) == json.loads((tmp_path / "out" / "result.json").read_text(encoding="utf-8"))
    assert not (tmp_path / "-").exists()
    assert "'pid' is not known" in refusal("compare", scenario, "--controller", "pid", "--out", tmp_path / "out")


def test_what_is_loaded_beside_the_runs_is_waited_for(tmp_path, scenario, without_pictures, monkeypatch):
    loaded = []
    slow = lambda name: (time.sleep(0.5), loaded.append(name))  # noqa: E731
    monkeypatch.setattr("adaptive_ff.cli.compare.import_module", slow)
    assert run_command_line("compare", scenario, "--controller", "pi", "--out", tmp_path / "out", "-q").status == 0
    assert loaded == ["adaptive_ff.report.page"]


def test_tables_as_csv_and_markdown(tmp_path, scenario, without_pictures):
    places = ("compare", scenario, "--out", tmp_path / "out", "--tables")
    text = run_command_line(*places, "csv").out
    title, *lines = text.strip().splitlines()
    assert title.startswith("# Velocity error")
    (row,) = csv.DictReader(io.StringIO("\n".join(lines)))
    assert row["controller"] == "pi"
    assert float(row["settled, mrad/s"]) > 0.0
    text = run_command_line(*places, "markdown").out
    assert "| controller | settled, mrad/s | over pi |" in text
    assert "| --- | --: | --: |" in text
    assert "'word' is not one of 'text', 'markdown', 'csv'" in refusal(*places, "word")


def test_pictures_in_several_formats_say_where_they_come_from(tmp_path, scenario, drawn):
    assert run_command_line("compare", scenario, "--out", tmp_path / "out", "--format", "svg, pdf", "-q").status == 0
    names = set(content_of(tmp_path / "out"))
    assert {"tracking.svg", "tracking.pdf", "torque.svg", "torque.pdf"} <= names
    assert not any(name.endswith(".png") for name in names)
    svg = (tmp_path / "out" / "tracking.svg").read_text(encoding="utf-8")
    assert f"adaptive-ff {version('adaptive-ff')}" in svg
    assert f"{scenario}, seed 1" in svg.replace("<!-- ", "")
    assert "--format = 'gif' is not known; there are png, pdf, svg" in refusal("compare", scenario, "--format", "gif")
    assert "--format is empty" in refusal("compare", scenario, "--format", ",")


def test_fixed_without_its_table_is_warned_of(tmp_path, without_pictures):
    content = changed({**short(), "controllers": ["pi", "fixed"]}, "fixed", REMOVED)
    outcome = run_command_line("compare", write_scenario(tmp_path, content), "--out", tmp_path / "out")
    assert outcome.warnings == [
        "warning: controller 'fixed' has nothing in [fixed]: it feeds nothing forward and equals 'pi'"
    ]


NEWTON_METRES = ([346.0, 1.0, 999.0], [12e3, 15e3], [0.0, float("nan")], [1000.0], [1.0])
SMALLER = [([0.0346], "mN m"), ([1e-30], "nN m")]


@pytest.mark.parametrize(("values", "expected"), [*SMALLER, *((values, "N m") for values in NEWTON_METRES)])
def test_units_are_scaled_so_that_numbers_can_be_read(values, expected):
    factor, unit = scale_for(values, "N m")
    assert unit == expected
    assert factor == {"m": 1e3, "n": 1e9}.get(unit[0], 1.0)


def test_numbers_have_no_exponent_where_it_can_be_avoided():
    numbers = (0.01234, 12.34, 999.4, 40312.0, 1e9)
    assert [shown(value) for value in numbers] == ["0.0123", "12.3", "999", "40312", "1e+09"]


COMMANDS = ("compare", "matrix", "sweep", "tune", "excite", "commission", "identify", "replay", "score")


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_the_same_options(command):
    text = run_command_line(command, "-h").out
    missing = [name for name in ("--out", "--json", "--format", "--report", "--quiet", "--tables") if name not in text]
    assert missing == []


def printed_on_a_terminal(shown_table, **options):
    """What a terminal of many colours is sent of a table."""
    stream = io.StringIO()
    Printer(file=stream, force_terminal=True, **options).show([shown_table])
    return stream.getvalue()


def test_no_color_is_heeded():
    highlighted, colours = table("", [["Mine"]], {"controller": None}, styles={"Mine": "bold cyan"}), "xterm-256color"
    assert COLOUR.search(printed_on_a_terminal(highlighted, _environ={"TERM": colours}))
    plain = printed_on_a_terminal(highlighted, _environ={"TERM": colours, "NO_COLOR": "1"})
    assert "Mine" in plain
    assert not COLOUR.search(plain)


@pytest.mark.parametrize("columns", [40, 80, 200])
def test_nothing_of_a_table_is_cut(tmp_path, scenario, without_pictures, columns):
    text = run_command_line("compare", scenario, "--out", tmp_path / "out", columns=columns).out
    assert "…" not in text
    assert {"controller", "settled", "max", "sum", "|du|"} <= set(text.split())


@pytest.mark.parametrize("width", [20, 60, 120])
def test_headings_break_on_a_terminal_and_numbers_do_not(width):
    columns = {"controller of the loop": None, "settled error of pi over own": ("", 8)}
    text = printed_on_a_terminal(table("", [["adaptive_paper", 12345.678]], columns), width=width, no_color=True)
    assert "…" not in text
    assert all(word in text for word in ("adaptive_paper", "12345.678", "controller", "settled"))
    lines = max(len(line) for line in re.sub(r"\x1b\[[0-9;]*m", "", text).splitlines())
    assert lines <= max(width, 32)


@pytest.mark.parametrize(
    ("written", "said"),
    [("nothing", "NameError: name 'nothing' is not defined"), ("1 / 0", "ZeroDivisionError: division by zero")],
)
def test_error_in_an_own_controller_is_one_line_with_its_place(tmp_path, scenario, written, said):
    own = tmp_path / "mine.py"
    own.write_text(OWN.replace("reference - velocity", f"reference - {written}"), encoding="utf-8")
    line = refusal("compare", scenario, "--own", f"{own}:Mine", "--out", tmp_path / "out")
    assert f"{own}, line 3, in step: {said}" in line


def test_own_controller_is_given_plain_numbers(tmp_path, scenario, without_pictures):
    own = tmp_path / "mine.py"
    check = "assert type(reference) is type(velocity) is type(others['next_reference']) is type(others['dt']) is float"
    own.write_text(OWN.replace("**_", "**others").replace("        return", f"        {check}\n        return"))
    assert run_command_line("compare", scenario, "--own", f"{own}:Mine", "--out", tmp_path / "out").status == 0


WIDTH, HEIGHT = 80, 30
"""Of a terminal, which what every command prints by default fits, paths apart."""


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    return write_log(tmp_path_factory.mktemp("sizes") / "log.csv", duration=10.0, period=0.005, noise=0.1)


@pytest.mark.parametrize(
    "command",
    [
        ["compare"],
        ["compare", "SCENARIO"],
        ["scenarios"],
        ["scenarios", "lugre"],
        ["sweep", "--runs", "2", "--controller", "fixed"],
        ["identify", "LOG"],
        ["replay", "LOG"],
        ["score", "LOG", "LOG"],
        ["tune", "SCENARIO", "--seeds", "1", "--tuning-seeds", "1"],
        ["matrix", "--only", "paper_100hz", "--seeds", "1"],
        ["excite", "--period", "5", "--fastest", "1"],
        ["commission", "SCENARIO", "--log", "LOG"],
        ["new", "--inertia", "20", "--torque", "400", "--speed", "3"],
        ["new", "--inertia", "20", "--torque", "400", "--speed", "3", "--encoder", "100000", "--gear-ratio", "50"],
        ["export"],
        ["version"],
    ],
    ids=" ".join,
)
def test_output_fits_a_terminal(command, log, tmp_path, monkeypatch, without_pictures):
    monkeypatch.chdir(tmp_path)
    search_shortly(monkeypatch)
    places = {"LOG": log, "SCENARIO": write_scenario(tmp_path, {**short(), "duration": 2.0})}
    outcome = run_command_line(*(places.get(word, word) for word in command), columns=WIDTH)
    assert outcome.status == 0, outcome.err
    lines = outcome.out.splitlines()
    assert len(lines) <= (36 if command[0] == "new" else HEIGHT), outcome.out  # a file, to be redirected
    assert [line for line in lines if len(line) > WIDTH and " " in line.strip()] == []


def test_matrix_of_all_scenarios_fits_a_terminal():
    names = ("pi", "oracle", "lagged_batch", "adaptive")
    found = {Job(name, 1, False): {one: {"rms_error_settled": 1e-3} for one in names} for name in scenario_names()}
    (table,) = matrix_tables(found)
    assert len(table.rows) <= HEIGHT - 10
    assert sum(max(map(len, column)) + 2 for column in zip(*table.rows, strict=True)) <= WIDTH
    heads = [head for make in (gains_table, ranking_table) for head in make(collect(found), "").heads]
    assert not any("own" in head or " it" in f" {head} " for head in heads)
