"""Joints in lock step come to the same places as alone."""

import re

from typer.testing import CliRunner

from benchmarks import lock_step


def test_it_prints_what_lock_step_would_save():
    app = lock_step.typer.Typer()
    app.command()(lock_step.main)
    result = CliRunner().invoke(app, ["--joints", "4", "--repeats", "1"])
    assert result.exit_code == 0, result.output
    assert re.search(r"four: [\d.]+ ns a step", result.output)
    assert re.search(r"in lock step would save -?\d+ %", " ".join(result.output.split()))


def test_the_number_of_joints_must_fit_the_lanes():
    app = lock_step.typer.Typer()
    app.command()(lock_step.main)
    result = CliRunner().invoke(app, ["--joints", "6"])
    assert result.exit_code == 2
    assert "6 is not allowed" in " ".join(result.output.replace("│", " ").split())
