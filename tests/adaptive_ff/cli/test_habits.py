"""What people expect of any command: short help, version, quiet, results on standard output, other formats."""

import csv
import io
import json
from importlib.metadata import version

import pytest
from command_line import content_of, refusal, run_command_line
from scenario_files import REMOVED, changed, short, write_scenario

from adaptive_ff.report.scaling import scale_for, shown

pytestmark = pytest.mark.usefixtures("compiled")


@pytest.mark.parametrize("option", ["--version", "-V"])
def test_version_as_an_option(option):
    assert run_command_line(option) == (0, f"{version('adaptive-ff')}\n", "")


@pytest.mark.parametrize("arguments", [["-h"], ["compare", "-h"], ["sweep", "-h"], ["matrix", "-h"], ["replay", "-h"]])
def test_short_help(arguments):
    outcome = run_command_line(*arguments)
    assert (outcome.status, outcome.err) == (0, "")
    assert "Usage: " in outcome.out
    assert len(arguments) == 1 or "--quiet" in outcome.out


def test_quiet_prints_nothing_and_writes_everything(tmp_path, scenario, without_pictures):
    outcome = run_command_line("compare", scenario, "--out", tmp_path / "out", "-q")
    assert outcome == (0, "", "")
    assert {"pi.csv", "result.json"} <= set(content_of(tmp_path / "out"))
    assert run_command_line("compare", scenario, "--out", tmp_path / "out").out != ""  # only the call that asked for it


def test_json_goes_to_standard_output_alone(tmp_path, scenario, without_pictures):
    outcome = run_command_line("compare", scenario, "--out", tmp_path / "out", "--json", "-")
    assert (outcome.status, outcome.err) == (0, "")
    assert json.loads(outcome.out) == json.loads((tmp_path / "out" / "result.json").read_text(encoding="utf-8"))
    assert not (tmp_path / "-").exists()


def test_tables_as_csv_and_markdown(tmp_path, scenario, without_pictures):
    places = ("compare", scenario, "--out", tmp_path / "out", "--tables")
    text = run_command_line(*places, "csv").out
    title, *lines = text.strip().splitlines()
    assert title.startswith("# Velocity error, ")
    (row,) = csv.DictReader(io.StringIO("\n".join(lines)))
    assert row["controller"] == "pi"
    assert float(row["settled"]) > 0.0
    text = run_command_line(*places, "markdown").out
    assert "| controller | settled | pi / own |" in text
    assert "| --- | --: | --: |" in text
    assert "'word' is not one of 'text', 'markdown', 'csv'" in refusal(*places, "word")


def test_pictures_in_several_formats_say_where_they_come_from(tmp_path, scenario):
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
        "warning: controller 'fixed' has no [fixed] table: it feeds nothing forward and equals 'pi'"
    ]


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ([0.0346], "mN m"),
        ([346.0, 1.0, 999.0], "N m"),
        ([12e3, 15e3], "kN m"),
        ([0.0, float("nan")], "N m"),
        ([1e-30], "nN m"),
        ([1000.0], "kN m"),
        ([1.0], "N m"),
    ],
)
def test_units_are_scaled_so_that_numbers_can_be_read(values, expected):
    factor, unit = scale_for(values, "N m")
    assert unit == expected
    assert factor == {"m": 1e3, "k": 1e-3, "n": 1e9}.get(unit[0], 1.0)


def test_numbers_have_no_exponent_where_it_can_be_avoided():
    assert [shown(value) for value in (0.01234, 12.34, 999.4, 40312.0, 1e9)] == [
        "0.0123",
        "12.3",
        "999",
        "40312",
        "1e+09",
    ]
