"""Cogging whose period is told: it costs what the model leaves, and nothing where there is none."""

import json

import numpy as np
import typer
from typer.testing import CliRunner

from benchmarks.cogging import LINES, SHARES, drawn, main
from benchmarks.other_joints import Velocity, draw


def test_a_drawn_joint_is_tracked_with_its_cogging_as_without():
    shares = drawn(104)["shares"]
    assert [float(share) for share in shares] == list(SHARES)
    for figures in shares.values():
        assert min(each["settled"] for each in figures.values()) > 1.0
        assert max(each["window"] for each in figures.values()) < 1.2
    assert shares["0.3"]["told"]["settled"] > 3.0 * shares["0.3"]["untold"]["settled"]
    assert shares["0"]["told"]["settled"] > 0.9 * shares["0"]["untold"]["settled"]


def test_a_joint_whose_encoder_does_not_show_its_cogging_is_left_out():
    kept = {seed: bool(drawn(seed)["shares"]) for seed in (102, 110)}
    assert not any(kept.values())


def test_a_tachometer_has_an_encoder_beside_it():
    seed = next(seed for seed in range(101, 200) if draw(seed)[1].sensor == "tachometer")
    loop = draw(seed)[1]
    sensor = Velocity(loop, 0.0, np.random.default_rng(1))
    sensor.step(1.0, 0.5)
    assert abs(sensor.reading - 1.0) <= 0.5 * loop.resolution


def test_the_command_prints_and_writes_both_tables(tmp_path):
    app = typer.Typer()
    app.command()(main)
    path = tmp_path / "cogging.json"
    asked = ["--seeds", "1", "--joints", "1", "--first", "104", "--workers", "1", "--json", str(path)]
    result = CliRunner().invoke(app, asked)
    assert result.exit_code == 0, result.output
    assert "30 N m every 0.02 rad" in result.output
    assert "1 joints of another simulator" in result.output
    errors = json.loads(path.read_text())["built_in"][0]["30 N m every 0.02 rad"]
    assert list(errors) == list(LINES)
    assert errors["noise floor"] < errors["told"] < 0.3 * errors["untold"] < 0.3 * errors["pi"]
