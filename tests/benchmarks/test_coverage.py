"""The synthetic logs on which the intervals of ``identify`` are counted."""

import json

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from benchmarks.coverage import main
from benchmarks.drawn_logs import make_case


@pytest.mark.parametrize("seed", [2, 3, 8, 11])
def test_records_of_a_joint_share_it_but_not_their_motion(seed):
    one, other = (make_case(seed, record=record) for record in (0, 1))
    assert one.truth["inertia"] == other.truth["inertia"]
    assert one.kind == other.kind
    assert not np.array_equal(one.log.position[:100], other.log.position[:100])
    again = make_case(seed)
    assert np.array_equal(again.log.torque, one.log.torque)


def test_command_prints_a_table_and_writes_the_results(tmp_path):
    app = typer.Typer()
    app.command()(main)
    arguments = ["--logs", "4", "--first", "300", "--workers", "1", "--json", str(tmp_path / "found.json")]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    assert "other physics: 2 logs" in result.output
    written = json.loads((tmp_path / "found.json").read_text(encoding="utf-8"))["logs"]
    assert [len(pair) for pair in written] == [2, 2]
