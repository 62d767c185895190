"""Encoders of few counts: drawn as told, and printed."""

import json

import numpy as np
import typer
from typer.testing import CliRunner

from benchmarks.coarse_encoders import COUNTS, SENSORS, main, run_joint, table_of
from benchmarks.other_joints import SETTLED


def test_every_joint_has_every_encoder_and_the_finest_tells_most():
    rows = run_joint(642)
    assert [(row["sensor"], row["counts"]) for row in rows] == [(each, n) for each in SENSORS for n in COUNTS]
    noise = [row["noise"] for row in rows[: len(COUNTS)]]
    assert noise == sorted(noise, reverse=True)
    assert rows[len(COUNTS) - 1]["settled"] > max(1.5, rows[0]["settled"])


def test_the_command_prints_what_it_writes(tmp_path):
    app = typer.Typer()
    app.command()(main)
    path = tmp_path / "encoders.json"
    result = CliRunner().invoke(app, ["--joints", "1", "--first", "642", "--workers", "1", "--json", str(path)])
    assert result.exit_code == 0, result.output
    assert "behind a low-pass" in result.output
    rows = json.loads(path.read_text())["joints"]
    assert len(rows) == len(SENSORS) * len(COUNTS)
    assert np.isfinite([row["settled"] for row in rows]).all()
    column = table_of(rows).columns[5]  # below the least ratio that is allowed
    assert list(column.cells) == [f"{int(row['settled'] < SETTLED)}" for row in rows]
